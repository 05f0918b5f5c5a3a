// bullet_soft SCENE.json: a ball on a spring pressed onto a block of finite elements, by Bullet's deformable bodies.
//
// The mesh is the one that Tactor makes of the same block. The world is set up as Bullet's own demos of implicit
// elasticity do (examples/DeformableDemo/VolumetricDeformable.cpp). The spring between handle and ball is implicit: by
// implicit Euler a ball of mass m on a spring k and a damper b is a free ball of the mass m + h b + h^2 k, so that
// Bullet computes contacts with it and nothing is explicit. The scene is read, and the results are written, as JSON:
// bench/soft_peers.py says what is in both.
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableLinearElasticityForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "nodes/physics/mesh/body_volume.hpp"

using namespace tactor;
using nlohmann::json;

namespace {

double thread_cpu_us() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

btVector3 bullet(const Vec3& v) {
  return {static_cast<btScalar>(v.x), static_cast<btScalar>(v.y), static_cast<btScalar>(v.z)};
}

Vec3 vector_of(const json& three) {
  return {three.at(0).get<double>(), three.at(1).get<double>(), three.at(2).get<double>()};
}

json list_of(const Vec3& v) {
  return {v.x, v.y, v.z};
}

/// Counts the products with the stiffness matrix, of which an iteration of conjugate gradients needs one.
class CountedElasticity final : public btDeformableLinearElasticityForce {
 public:
  using btDeformableLinearElasticityForce::btDeformableLinearElasticityForce;
  void addScaledElasticForceDifferential(btScalar scale, const TVStack& dx, TVStack& df) override {
    ++products;
    btDeformableLinearElasticityForce::addScaledElasticForceDifferential(scale, dx, df);
  }
  long products = 0;
};

/// Bullet's solver with what its constructor sets made accessible, and the residual of each step.
class Solver final : public btDeformableBodySolver {
 public:
  void set_newton(int iterations, double tolerance) {
    m_maxNewtonIterations = iterations;
    m_newtonTolerance = static_cast<btScalar>(tolerance);
  }
  void set_tolerance(double tolerance) { m_cg.setTolerance(static_cast<btScalar>(tolerance)); }
  [[nodiscard]] int newton_iterations() const { return m_maxNewtonIterations; }
  [[nodiscard]] double newton_tolerance() const { return m_newtonTolerance; }

  /// As Bullet does it, and the residual afterwards.
  void solveDeformableConstraints(btScalar h) override {
    btDeformableBodySolver::solveDeformableConstraints(h);
    const double from = thread_cpu_us();
    // The equation of the nodes that no contact leads, at the end of the step: -M dv + h f(x + h v, v), in N s.
    updateState();
    int k = 0;
    for (int b = 0; b < m_softBodies.size(); ++b) {
      const auto& nodes = m_softBodies[b]->m_nodes;
      for (int i = 0; i < nodes.size(); ++i, ++k) {
        m_residual[k].setZero();
        if (nodes[i].m_im > 0) m_residual[k] = (btScalar(-1) / nodes[i].m_im) * m_dv[k];
      }
    }
    m_objective->computeResidual(h, m_residual);
    m_objective->project(m_residual);
    residual = static_cast<double>(m_objective->computeNorm(m_residual) / h);
    for (int i = 0; i < m_residual.size(); ++i) m_residual[i].setZero();
    residual_us = thread_cpu_us() - from;
  }
  double residual = 0;     ///< N, Euclidean norm over the nodes
  double residual_us = 0;  ///< of CPU, what it took to compute it
};

/// The handle at any time, straight between its samples and at rest after the last.
class HandleMotion {
 public:
  struct Sample {
    double t = 0;  ///< s
    Vec3 p, v;     ///< m, m/s
  };
  /// Rows of t, x, y, z, v_x, v_y, v_z, in ascending order of t.
  explicit HandleMotion(const json& rows) {
    const auto three = [](const json& row, std::size_t first) {
      return Vec3{row.at(first).get<double>(), row.at(first + 1).get<double>(), row.at(first + 2).get<double>()};
    };
    for (const json& row : rows) samples_.push_back({row.at(0).get<double>(), three(row, 1), three(row, 4)});
    if (samples_.size() < 2) throw std::runtime_error("handle: expected two samples or more");
  }
  [[nodiscard]] Sample at(double t) const {
    const auto after = std::upper_bound(samples_.begin() + 1, samples_.end() - 1, t,
                                        [](double time, const Sample& s) { return time < s.t; });
    const Sample &a = *(after - 1), &b = *after;
    if (t >= b.t) return {t, b.p, {}};
    const double s = std::max(0.0, (t - a.t) / (b.t - a.t));
    return {t, a.p + s * (b.p - a.p), a.v + s * (b.v - a.v)};
  }

 private:
  std::vector<Sample> samples_;
};

BodyVolume mesh_of(const json& gel) {
  Body body;
  body.name = "gel";
  body.shape = BoxShape{vector_of(gel.at("size"))};
  body.motion = Motion::deformable;
  body.deformable.cell_size = gel.at("cell_size");
  body.deformable.fixed = {HalfSpaceRegion{vector_of(gel.at("fixed_p")), vector_of(gel.at("fixed_n"))}};
  return load_body_volume(body);
}

/// The parts of Bullet's world that live as long as it does. `world` is declared last: its destructor uses the others.
struct World {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  Solver solver;
  btDeformableMultiBodyConstraintSolver constraints;
  btDeformableMultiBodyDynamicsWorld world{&dispatcher, &broadphase, &constraints, &configuration, &solver};
};

/// What the demos of implicit elasticity set, and of what they leave open what the scene says.
void set_up(World& w, const json& options) {
  w.constraints.setDeformableSolver(&w.solver);
  w.world.setGravity({0, 0, 0});
  w.world.setImplicit(options.at("implicit").get<bool>());
  w.world.setUseProjection(options.at("projection").get<bool>());
  w.world.setLineSearch(options.at("line_search").get<bool>());
  btContactSolverInfo& info = w.world.getSolverInfo();
  info.m_deformable_erp = options.at("erp").get<btScalar>();
  info.m_deformable_cfm = 0;
  info.m_deformable_maxErrorReduction = 200;
  info.m_leastSquaresResidualThreshold = 0;
  info.m_splitImpulse = options.at("split_impulse").get<bool>();
  info.m_numIterations = options.at("contact_iterations").get<int>();
  if (options.contains("newton")) w.solver.set_newton(options.at("newton"), options.at("newton_tolerance"));
  if (options.contains("cg_tolerance")) w.solver.set_tolerance(options.at("cg_tolerance"));
  // The ball's distances come from a grid. At 0.5 mm they are within 4 um.
  btSoftBodyWorldInfo& shared = w.world.getWorldInfo();
  shared.m_gravity.setZero();
  shared.m_sparsesdf.setDefaultVoxelsz(btScalar(0.5e-3));
  shared.m_sparsesdf.Reset();
}

/// The block, with its mass lumped by volume at the nodes.
std::unique_ptr<btSoftBody> soft_body(btSoftBodyWorldInfo& shared, const BodyVolume& volume, double density) {
  const TetMesh& mesh = volume.mesh;
  std::vector<btVector3> p;
  for (const Vec3& node : mesh.nodes) p.push_back(bullet(node));
  auto body = std::make_unique<btSoftBody>(&shared, static_cast<int>(p.size()), p.data(), nullptr);
  std::vector<double> mass(p.size());
  std::set<std::pair<int, int>> edges;
  for (const auto& [a, b, c, d] : mesh.tets) {
    body->appendTetra(a, b, c, d);
    const auto at = [&](int i) { return mesh.nodes[static_cast<std::size_t>(i)]; };
    const double share = density * dot(at(b) - at(a), cross(at(c) - at(a), at(d) - at(a))) / 24;
    const std::array<int, 4> corners{a, b, c, d};
    for (const int node : corners) mass[static_cast<std::size_t>(node)] += share;
    for (const int from : corners) {
      for (const int to : corners) {
        if (from < to) edges.insert({from, to});
      }
    }
  }
  // Without a force on them, links only tell Bullet which nodes are neighbours: it builds its tree of nodes by them.
  for (const auto& [from, to] : edges) body->appendLink(from, to);
  btSoftBodyHelpers::generateBoundaryFaces(body.get());
  body->initializeDmInverse();
  body->m_tetraScratches.resize(body->m_tetras.size());
  body->m_tetraScratchesTn.resize(body->m_tetras.size());
  for (std::size_t i = 0; i < mass.size(); ++i) {
    body->setMass(static_cast<int>(i), volume.fixed[i] ? btScalar(0) : static_cast<btScalar>(mass[i]));
  }
  body->setActivationState(DISABLE_DEACTIVATION);
  return body;
}

/// N, the sum of the elastic forces on the nodes that are free: at rest, what the block pushes the ball with.
Vec3 elastic_force(const btSoftBody& body, CountedElasticity& elasticity) {
  btAlignedObjectArray<btVector3> forces;
  forces.resize(body.m_nodes.size(), btVector3(0, 0, 0));
  elasticity.addScaledElasticForce(1, forces);
  btVector3 sum(0, 0, 0);
  for (int i = 0; i < forces.size(); ++i) {
    if (body.m_nodes[i].m_im > 0) sum += forces[i];
  }
  return {sum.x(), sum.y(), sum.z()};
}

json run(const json& scene) {
  const json &gel = scene.at("gel"), &ball = scene.at("ball"), &options = scene.at("bullet");
  const double mass = ball.at("mass"), k = scene.at("coupling").at("k"), b = scene.at("coupling").at("b");
  const double margin = options.at("margin"), radius = ball.at("radius");
  const BodyVolume volume = mesh_of(gel);
  const HandleMotion handle(scene.at("handle"));
  const auto times = scene.at("times").get<std::vector<double>>();
  const int substeps = options.at("substeps");
  const bool faces = options.at("contacts") == "faces";

  World w;
  set_up(w, options);
  const auto block = soft_body(w.world.getWorldInfo(), volume, gel.at("density"));
  block->getCollisionShape()->setMargin(static_cast<btScalar>(margin));
  block->m_cfg.kKHR = block->m_cfg.kCHR = 1;
  block->m_cfg.kDF = 1;  // multiplied by the friction of the rigid body
  block->m_cfg.collisions =
      btSoftBody::fCollision::SDF_RD | (faces ? btSoftBody::fCollision::SDF_RDF : btSoftBody::fCollision::SDF_RDN);
  w.world.addSoftBody(block.get());
  CountedElasticity elasticity(1, 1, 0, gel.at("damping").get<btScalar>());
  elasticity.setYoungsModulus(gel.at("young").get<btScalar>());
  elasticity.setPoissonRatio(gel.at("poisson").get<btScalar>());
  w.world.addForce(block.get(), &elasticity);

  // Bullet holds surfaces apart by the margin, so the ball is smaller by it.
  btSphereShape shape(static_cast<btScalar>(radius - margin));
  btRigidBody tool(static_cast<btScalar>(mass), nullptr, &shape, {0, 0, 0});  // no inertia: it does not turn
  const HandleMotion::Sample begin = handle.at(times.at(0));
  btTransform start;
  start.setIdentity();
  start.setOrigin(bullet(begin.p));
  tool.setCenterOfMassTransform(start);
  tool.setInterpolationWorldTransform(start);
  tool.setFriction(ball.at("friction").get<btScalar>());
  tool.setActivationState(DISABLE_DEACTIVATION);
  w.world.addRigidBody(&tool);

  // Bullet's corrections of depth move the ball without a velocity, so the damper goes by the way.
  Vec3 p = begin.p, v = begin.v, moved;
  json rows = json::array();
  for (std::size_t i = 1; i < times.size(); ++i) {
    const double h = (times[i] - times[i - 1]) / substeps;
    const long products = elasticity.products;
    double cost = 0;
    for (int s = 1; s <= substeps; ++s) {
      const HandleMotion::Sample d = handle.at(times[i - 1] + h * s);
      const double total = mass + h * b + h * h * k;
      const Vec3 free = (mass * v + h * (k * (d.p - p) + b * d.v)) / total;
      const double from = thread_cpu_us();
      tool.setMassProps(static_cast<btScalar>(total), {0, 0, 0});
      tool.updateInertiaTensor();
      tool.setLinearVelocity(bullet(free));
      w.world.stepSimulation(static_cast<btScalar>(h), 0);
      cost += thread_cpu_us() - from - w.solver.residual_us;
      const btVector3 &at = tool.getCenterOfMassPosition(), &moves = tool.getLinearVelocity();
      moved = (Vec3{at.x(), at.y(), at.z()} - p) / h;
      p = {at.x(), at.y(), at.z()};
      v = {moves.x(), moves.y(), moves.z()};
    }
    const HandleMotion::Sample d = handle.at(times[i]);
    rows.push_back({{"t", times[i]},
                    {"force", list_of(k * (p - d.p) + b * (moved - d.v))},
                    {"p", list_of(p)},
                    {"cost_us", cost},
                    {"contacts", faces ? block->m_faceRigidContacts.size() : block->m_nodeRigidContacts.size()},
                    {"products", elasticity.products - products},
                    {"residual", w.solver.residual}});
  }
  block->updateDeformation();
  const json result{{"tissue_force", list_of(elastic_force(*block, elasticity))},
                    {"precision", sizeof(btScalar) == 8 ? "double" : "float"},
                    {"tetrahedra", volume.mesh.tets.size()},
                    {"nodes", volume.mesh.nodes.size()},
                    {"newton", w.solver.newton_iterations()},
                    {"newton_tolerance", w.solver.newton_tolerance()},
                    {"results", std::move(rows)}};
  w.world.removeRigidBody(&tool);
  w.world.removeSoftBody(block.get());
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: bullet_soft SCENE.json\n");
    return 2;
  }
  try {
    std::ifstream file(argv[1]);
    if (!file) throw std::runtime_error("cannot be read");
    std::printf("%s\n", run(json::parse(file)).dump().c_str());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bullet_soft: %s: %s\n", argv[1], error.what());
    return 2;
  }
}
