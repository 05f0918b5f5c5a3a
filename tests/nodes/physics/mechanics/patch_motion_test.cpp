// The motion of a patch, mode by mode, against closed forms and against the same equations written for the nodes.
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "framework/realtime/allocation_watch.hpp"
#include "tests/nodes/physics/mechanics/patches.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(patch_motion_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

constexpr std::array both_integrators{Integrator::implicit_euler, Integrator::midpoint};

/// One node that moves along x alone, by one mode of mass m, begun at z and rate.
LocalPatch one_mode(PatchPool& pool, double mass, const PatchMode& mode) {
  Eigen::MatrixXd shape = Eigen::MatrixXd::Zero(3, 1);
  shape(0, 0) = 1 / std::sqrt(mass);
  return pool.patch({{{0.1, 0.2, 0.3}, {}, 0}}, {}, {mode}, shape);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_mode_goes_as_each_integrator_has_it_in_closed_form) {
  constexpr double m = 0.04, k = 900, d = 3, force = 0.2, h = 0.004;  // per unit mass: 1/s^2, 1/s
  PatchPool pool;
  for (const Integrator integrator : both_integrators) {
    PatchMotion motion(integrator);
    motion.restart(one_mode(pool, m, {.stiffness = k, .damping = d, .force = force, .z = 2e-4, .rate = 0.03}));
    // The step as a matrix on (z - z_rest, rate), to the 25th power.
    Eigen::Matrix2d step;
    const double s = integrator == Integrator::midpoint ? h / 2 : h, D = 1 / (1 + s * d + s * s * k);
    const Eigen::RowVector2d rate(-D * s * k, D);  // that is solved for
    step.row(0) = Eigen::RowVector2d(1, 0) + h * rate;
    step.row(1) = integrator == Integrator::midpoint ? Eigen::RowVector2d(2 * rate - Eigen::RowVector2d(0, 1)) : rate;
    Eigen::Vector2d state(2e-4 - force / k, 0.03);
    for (int i = 0; i < 25; ++i) {
      motion.coast(h);
      state = step * state;
    }
    std::array<PatchMode, 1> now;
    motion.write(now);
    BOOST_TEST(now[0].z == state[0] + force / k, tt::tolerance(1e-12));
    BOOST_TEST(now[0].rate == state[1], tt::tolerance(1e-12));
    BOOST_TEST(now[0].stiffness == k);
    BOOST_TEST(now[0].force == force);
    BOOST_TEST(motion.nodes_W()[0].x == 0.1 + (state[0] + force / k) / std::sqrt(m), tt::tolerance(1e-12));
    BOOST_TEST(motion.nodes_W()[0].y == 0.2);
  }
}

BOOST_AUTO_TEST_CASE(the_midpoint_rule_keeps_the_energy_of_a_free_mode_and_its_closed_phase) {
  // An undamped mode turns by 2 atan(w h / 2) a step.
  constexpr double w = 300, h = 0.004;
  PatchPool pool;
  PatchMotion motion(Integrator::midpoint);
  motion.restart(one_mode(pool, 1, {.stiffness = w * w, .z = 1e-3}));
  for (int i = 1; i <= 200; ++i) {
    motion.coast(h);
    std::array<PatchMode, 1> now;
    motion.write(now);
    const double turn = 2 * i * std::atan(w * h / 2);
    BOOST_TEST(std::abs(now[0].z - 1e-3 * std::cos(turn)) < 1e-14);
    BOOST_TEST(std::abs(now[0].rate + 1e-3 * w * std::sin(turn)) < 1e-11);
  }
}

BOOST_AUTO_TEST_CASE(a_step_with_forces_solves_the_equations_of_the_nodes) {
  // (M + s D + s^2 K) (u' - u) = s (f + J - K (x + s u) - D u), for s the time that is solved for, in the nodes'
  // coordinates; from the second step on too.
  constexpr double drag = 2, beta = 0.003, h = 0.003;
  PatchPool pool;
  for (const Integrator integrator : both_integrators) {
    for (const int nodes : {1, 4, 9}) {
      const RandomPatch random(nodes, 100 + nodes);
      const Eigen::MatrixXd C = drag * random.M + beta * random.K;
      PatchMotion motion(integrator);
      const LocalPatch patch = random.make(pool, drag, beta);
      BOOST_REQUIRE(is_usable(patch));
      motion.restart(patch);
      Eigen::VectorXd x = Eigen::VectorXd::Zero(3 * nodes), u = random.u;
      Noise noise;
      const bool midpoint = integrator == Integrator::midpoint;
      const double s = midpoint ? h / 2 : h;
      for (int i = 0; i < 5; ++i) {
        // Contacts that name all nodes, in descending order.
        std::vector<SoftContact> contacts = touching_all(nodes);
        const std::array<Pose, 1> X_WB{};
        const SoftPatch seen = motion.begin(h, contacts, X_WB);
        BOOST_REQUIRE(seen.p_W.size() == static_cast<std::size_t>(nodes));
        const Eigen::MatrixXd A = random.M + s * C + s * s * random.K;
        const Eigen::VectorXd inner = random.f - random.K * x;
        const Eigen::VectorXd free = A.ldlt().solve(random.M * u + s * inner);
        const Eigen::MatrixXd inertia = seen.inertia.selfadjointView<Eigen::Lower>();
        // Told in the order in which the contacts name the nodes.
        const Eigen::VectorXd f = noise.vector(3 * nodes);
        const std::vector<int> order = order_of(contacts, nodes);
        for (int n = 0; n < nodes; ++n) {
          const int place = order[static_cast<std::size_t>(n)];
          BOOST_TEST((seen.free_velocity.segment<3>(3 * place) - free.segment<3>(3 * n)).norm() <
                     1e-9 * (1 + free.norm()));
          BOOST_TEST((seen.velocity.segment<3>(3 * place) - u.segment<3>(3 * n)).norm() < 1e-9 * (1 + u.norm()));
          motion.motion().force.segment<3>(3 * place) = f.segment<3>(3 * n);
          for (int k = 0; k < nodes; ++k) {
            const Eigen::Matrix3d block = inertia.block<3, 3>(3 * place, 3 * order[static_cast<std::size_t>(k)]);
            BOOST_TEST((block - A.block<3, 3>(3 * n, 3 * k)).norm() < 1e-8 * A.norm());
          }
        }
        motion.end(h);
        const Eigen::VectorXd solved = A.ldlt().solve(random.M * u + s * (inner + f));
        x += h * solved;
        u = midpoint ? Eigen::VectorXd(2 * solved - u) : solved;
        for (int n = 0; n < nodes; ++n) {
          const Vec3 p = motion.nodes_W()[static_cast<std::size_t>(n)];
          const Vec3 at = random.p(n);
          BOOST_TEST((Eigen::Vector3d(p.x - at.x, p.y - at.y, p.z - at.z) - x.segment<3>(3 * n)).norm() <
                     1e-9 * (1 + x.norm()));
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(an_inertia_is_made_anew_for_other_nodes_another_time_and_another_patch) {
  PatchPool pool;
  const RandomPatch one(10, 3), other(10, 4);
  const LocalPatch patches[] = {one.make(pool, 1, 0.002), other.make(pool, 1, 0.002)};
  const auto contacts_on = [](std::vector<std::array<std::int32_t, 3>> nodes) {
    std::vector<SoftContact> contacts(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) contacts[i].node = nodes[i];
    return contacts;
  };
  const std::vector<SoftContact> all = touching_all(10), few = contacts_on({{0, 4, 7}}),
                                 few_turned = contacts_on({{7, 0, 4}});
  struct Step {
    int patch;
    const std::vector<SoftContact>* contacts;
    double h;
  };
  const Step steps[] = {{0, &all, 0.001},        {0, &few, 0.001},        {0, &few_turned, 0.001},
                        {0, &few_turned, 0.001}, {0, &few_turned, 0.003}, {1, &few_turned, 0.003},
                        {1, &all, 0.003}};
  const std::array<Pose, 1> X_WB{};
  PatchMotion kept(Integrator::implicit_euler);
  int now = -1;
  for (const Step& step : steps) {
    if (step.patch != now) kept.restart(patches[step.patch]);
    now = step.patch;
    PatchMotion fresh(Integrator::implicit_euler);
    fresh.restart(patches[step.patch]);
    std::vector<SoftContact> contacts = *step.contacts, again = *step.contacts;
    const Eigen::MatrixXd found = kept.begin(step.h, contacts, X_WB).inertia.selfadjointView<Eigen::Lower>();
    const Eigen::MatrixXd expected = fresh.begin(step.h, again, X_WB).inertia.selfadjointView<Eigen::Lower>();
    BOOST_REQUIRE(found.rows() == expected.rows());
    BOOST_TEST((found - expected).norm() == 0.0);
    // Of all nodes it is the sum of the matrices.
    if (step.contacts != &all) continue;
    const RandomPatch& random = now == 0 ? one : other;
    const std::vector<int> order = order_of(contacts, 10);
    const Eigen::MatrixXd A = (1 + step.h) * random.M + (0.002 * step.h + step.h * step.h) * random.K;
    for (int n = 0; n < 10; ++n) {
      for (int k = 0; k < 10; ++k) {
        const int row = order[static_cast<std::size_t>(n)], column = order[static_cast<std::size_t>(k)];
        BOOST_TEST((found.block<3, 3>(3 * row, 3 * column) - A.block<3, 3>(3 * n, 3 * k)).norm() < 1e-8 * A.norm());
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(nodes_that_are_fixed_stay_and_are_told_as_such) {
  PatchPool pool;
  const RandomPatch random(3, 7);
  const LocalPatch patch = random.make(pool, 0, 0, 2);  // two more nodes, fixed
  BOOST_REQUIRE(is_usable(patch));
  PatchMotion motion(Integrator::implicit_euler);
  motion.restart(patch);
  // Nodes 3 and 4 are fixed; of the free ones only node 1 is touched.
  std::vector<SoftContact> contacts(2);
  contacts[0].node = {3, 1, 4};
  contacts[1].node = {4, 3, 4};
  const std::array<Pose, 1> X_WB{};
  const SoftPatch seen = motion.begin(0.001, contacts, X_WB);
  BOOST_TEST(seen.p_W.size() == 1U);
  BOOST_TEST((contacts[0].node == std::array<std::int32_t, 3>{-1, 0, -1}));
  BOOST_TEST((contacts[1].node == std::array<std::int32_t, 3>{-1, -1, -1}));
  motion.motion().force.setConstant(1);
  motion.end(0.001);
  for (const std::size_t i : {3U, 4U}) BOOST_TEST(norm(motion.nodes_W()[i] - patch.nodes[i].p_W) == 0.0);
}

BOOST_AUTO_TEST_CASE(a_patch_of_any_size_moves_without_the_heap, *boost::unit_test::precondition(heap_is_counted)) {
  PatchPool pool;
  for (const Integrator integrator : both_integrators) {
    constexpr int all = LocalPatch::most_modes / 3;
    for (const auto [nodes, touched] : {std::array{1, 1}, {8, 8}, {24, 24}, {40, 40}, {all, LocalPatch::capacity}}) {
      const LocalPatch patch = RandomPatch(nodes, nodes).make(pool, 1, 0.002);
      std::vector<SoftContact> contacts = touching_all(touched);
      const std::vector<SoftContact> first = contacts;
      const std::array<Pose, 1> X_WB{};
      PatchMotion motion(integrator);
      const std::int64_t before = thread_heap_calls();
      motion.restart(patch);
      for (int i = 0; i < 3; ++i) {
        contacts = first;
        motion.begin(0.001, contacts, X_WB);
        motion.motion().force.setConstant(0.1);
        motion.end(0.001);
        motion.coast(0.001);
      }
      const std::int64_t calls = thread_heap_calls() - before;
      BOOST_TEST(calls == 0);
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
