// What a step of elastic bodies is made of, by the number of tetrahedra: assembly by law and tangent, factors, a solve.
#include <array>
#include <memory>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "nodes/physics/deformable/elastic_model.hpp"
#include "nodes/physics/deformable/signed_svd.hpp"
#include "nodes/physics/deformable/sparse_factor.hpp"
#include "tests/nodes/physics/deformable/boxes.hpp"

using namespace tactor;
using namespace tactor::test;
using Tangent = ElasticModel::Tangent;

namespace {

/// A box of about so many tetrahedra, held at one face. Quadratic elements are as many.
ElasticModel box_of(int tetrahedra, Elasticity law, ElementOrder order) {
  int n = 1;
  while (6 * (n + 1) * (n + 1) * (n + 1) * 2 <= 2 * tetrahedra) ++n;
  std::vector<SoftBody> bodies{
      soft_body(box_of_tets(n + 1, n, n, {0.06, 0.05, 0.05}), 2e4, 0.45, [](const Vec3& p) { return p.x < 1e-9; })};
  return {std::move(bodies), law, order};
}

/// Turned by `turn` (rad) at the end, and uneven.
Eigen::VectorXd bent(const ElasticModel& model, double turn = 0.5) {
  Noise noise;
  Eigen::VectorXd x = model.rest();
  for (int n = 0; n < model.nodes(); ++n) {
    const Eigen::Vector3d p = x.segment<3>(3 * n);
    const double angle = turn / 0.06 * p.x();
    x.segment<3>(3 * n) = Eigen::Vector3d(p.x(), std::cos(angle) * p.y() - std::sin(angle) * p.z(),
                                          std::sin(angle) * p.y() + std::cos(angle) * p.z());
  }
  return moved(model, x, 2e-4 * noise.vector(model.unknowns()));
}

void assembly(benchmark::State& state, Elasticity law, ElementOrder order, Tangent tangent) {
  const ElasticModel model = box_of(static_cast<int>(state.range(0)), law, order);
  const Eigen::VectorXd x = bent(model);
  Eigen::SparseMatrix<double> K;
  Eigen::VectorXd f;
  for (auto _ : state) {
    model.assemble(x, tangent, K, f);
    benchmark::DoNotOptimize(K.valuePtr());
  }
  state.counters["tetrahedra"] = model.elements();
  state.counters["each"] =
      benchmark::Counter(model.elements(), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void forces(benchmark::State& state, Elasticity law, ElementOrder order) {
  const ElasticModel model = box_of(static_cast<int>(state.range(0)), law, order);
  const Eigen::VectorXd x = bent(model);
  Eigen::VectorXd f;
  for (auto _ : state) {
    model.force(x, f);
    benchmark::DoNotOptimize(f.data());
  }
  state.counters["each"] =
      benchmark::Counter(model.elements(), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void singular_values(benchmark::State& state) {
  Noise noise;
  std::array<Eigen::Matrix3d, 64> matrices;
  for (Eigen::Matrix3d& F : matrices) {
    for (double& entry : F.reshaped()) entry = 0.3 * noise();
    F += Eigen::Matrix3d::Identity();
  }
  SignedSvd svd;
  for (auto _ : state) {
    for (const Eigen::Matrix3d& F : matrices) {
      signed_svd(F, svd);
      benchmark::DoNotOptimize(svd);
    }
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(matrices.size()) * state.iterations());
}

/// Solves A x = b by conjugate gradients preconditioned with a factor of another matrix, until what is left is 0.001 of
/// b; returns the iterations.
int conjugate_gradients(const Eigen::SparseMatrix<double>& A, const SparseFactor& factor, const Eigen::VectorXd& b,
                        Eigen::VectorXd& x) {
  x.setZero(b.size());
  Eigen::VectorXd left = b, z = left, direction, along;
  factor.solve(z);
  direction = z;
  double product = left.dot(z);
  for (int i = 1; i <= 200; ++i) {
    along.noalias() = A.selfadjointView<Eigen::Lower>() * direction;
    const double step = product / direction.dot(along);
    x += step * direction;
    left -= step * along;
    if (left.norm() <= 1e-3 * b.norm()) return i;
    z = left;
    factor.solve(z);
    const double next = left.dot(z);
    direction = z + next / product * direction;
    product = next;
  }
  return 200;
}

/// Nodes of the face opposite to the one that is held: what a tool touches.
std::vector<int> patch_of(const ElasticModel& model, int most) {
  std::vector<int> patch;
  for (int u = 0; u < model.unknowns() && static_cast<int>(patch.size()) < most; u += 3) {
    if (model.rest()[3 * model.node_of(u)] > 0.06 - 1e-9) patch.push_back(u / 3);
  }
  return patch;
}

struct Matrix {
  Matrix(int tetrahedra, ElementOrder order, double turn = 0.5)
      : model(box_of(tetrahedra, Elasticity::corotational, order)) {
    Eigen::VectorXd f;
    model.assemble(bent(model, turn), Tangent::warped, A, f);
    A += 2500 * model.mass();
  }
  ElasticModel model;
  Eigen::SparseMatrix<double> A;
};

void factor(benchmark::State& state, FactorKind kind, ElementOrder order) {
  const Matrix matrix(static_cast<int>(state.range(0)), order);
  const std::unique_ptr<SparseFactor> factor = make_factor(kind, 0);
  factor->analyze(matrix.A, patch_of(matrix.model, 30));
  for (auto _ : state) benchmark::DoNotOptimize(factor->factor(matrix.A));
  state.counters["tetrahedra"] = matrix.model.elements();
  state.counters["unknowns"] = matrix.model.unknowns();
  state.counters["entries"] = static_cast<double>(factor->entries());
}

void analysis(benchmark::State& state, FactorKind kind, ElementOrder order) {
  const Matrix matrix(static_cast<int>(state.range(0)), order);
  const std::unique_ptr<SparseFactor> factor = make_factor(kind, 0);
  for (auto _ : state) factor->analyze(matrix.A, patch_of(matrix.model, 30));
}

void solve(benchmark::State& state, FactorKind kind, ElementOrder order) {
  const Matrix matrix(static_cast<int>(state.range(0)), order);
  const std::unique_ptr<SparseFactor> factor = make_factor(kind, 0);
  factor->analyze(matrix.A, patch_of(matrix.model, 30));
  factor->factor(matrix.A);
  Eigen::VectorXd b = Eigen::VectorXd::Ones(matrix.model.unknowns());
  for (auto _ : state) {
    factor->solve(b);
    benchmark::DoNotOptimize(b.data());
  }
}

/// A solve with the factor of the body at rest where it is turned by so much at its end.
void conjugate(benchmark::State& state, double turn) {
  const auto tetrahedra = static_cast<int>(state.range(0));
  const Matrix rest(tetrahedra, ElementOrder::linear, 0), matrix(tetrahedra, ElementOrder::linear, turn);
  const std::unique_ptr<SparseFactor> factor = make_factor(FactorKind::supernodal, 0);
  factor->analyze(rest.A, patch_of(rest.model, 30));
  factor->factor(rest.A);
  Noise noise;
  const Eigen::VectorXd b = noise.vector(matrix.model.unknowns());
  Eigen::VectorXd x;
  int iterations = 0;
  for (auto _ : state) iterations = conjugate_gradients(matrix.A, *factor, b, x);
  state.counters["cg_iterations"] = iterations;
}

void schur(benchmark::State& state, FactorKind kind) {
  const Matrix matrix(static_cast<int>(state.range(0)), ElementOrder::linear);
  const std::unique_ptr<SparseFactor> factor = make_factor(kind, 0);
  factor->analyze(matrix.A, patch_of(matrix.model, 30));
  factor->factor(matrix.A);
  Eigen::MatrixXd S;
  for (auto _ : state) factor->schur(S);
}

constexpr auto linear = ElementOrder::linear, quadratic = ElementOrder::quadratic;
constexpr auto corotational = Elasticity::corotational, neo_hookean = Elasticity::neo_hookean;

void sizes(benchmark::internal::Benchmark* b) {
  for (const int tetrahedra : {1000, 3000, 10000, 30000, 100000}) b->Arg(tetrahedra);
  b->Unit(benchmark::kMillisecond);
}

BENCHMARK(singular_values);
BENCHMARK_CAPTURE(forces, corotational_linear, corotational, linear)->Apply(sizes);
BENCHMARK_CAPTURE(forces, neo_hookean_linear, neo_hookean, linear)->Apply(sizes);
BENCHMARK_CAPTURE(assembly, warped_linear, corotational, linear, Tangent::warped)->Apply(sizes);
BENCHMARK_CAPTURE(assembly, corotational_linear, corotational, linear, Tangent::projected)->Apply(sizes);
BENCHMARK_CAPTURE(assembly, neo_hookean_linear, neo_hookean, linear, Tangent::projected)->Apply(sizes);
BENCHMARK_CAPTURE(assembly, warped_quadratic, corotational, quadratic, Tangent::warped)->Apply(sizes);
BENCHMARK_CAPTURE(assembly, neo_hookean_quadratic, neo_hookean, quadratic, Tangent::projected)->Apply(sizes);
BENCHMARK_CAPTURE(factor, eigen, FactorKind::eigen, linear)
    ->Arg(1000)
    ->Arg(3000)
    ->Arg(10000)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(factor, simplicial, FactorKind::simplicial, linear)
    ->Arg(1000)
    ->Arg(3000)
    ->Arg(10000)
    ->Arg(30000)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(factor, supernodal, FactorKind::supernodal, linear)->Apply(sizes);
BENCHMARK_CAPTURE(factor, supernodal_quadratic, FactorKind::supernodal, quadratic)
    ->Arg(1000)
    ->Arg(3000)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(analysis, eigen, FactorKind::eigen, linear)->Arg(1000)->Arg(3000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(analysis, supernodal, FactorKind::supernodal, linear)->Apply(sizes);
BENCHMARK_CAPTURE(solve, eigen, FactorKind::eigen, linear)->Arg(1000)->Arg(3000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve, supernodal, FactorKind::supernodal, linear)->Apply(sizes);
BENCHMARK_CAPTURE(conjugate, small_turn, 0.05)->Apply(sizes);
BENCHMARK_CAPTURE(conjugate, large_turn, 0.5)->Apply(sizes);
BENCHMARK_CAPTURE(schur, supernodal, FactorKind::supernodal)->Apply(sizes);

}  // namespace
