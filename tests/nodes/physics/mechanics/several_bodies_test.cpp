// Bodies that touch each other: momentum is kept, forces are equal and opposite, and a plane moves with its body.
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <vector>

#include "nodes/physics/mechanics/eigen.hpp"
#include "nodes/physics/mechanics/energy.hpp"
#include "nodes/physics/mechanics/free_rotation.hpp"
#include "nodes/physics/mechanics/rigid_step.hpp"

BOOST_AUTO_TEST_SUITE(several_bodies_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

/// Bodies that step against planes whose query was made where they start.
struct Group {
  explicit Group(const SystemModel& model) : step(model) { bodies.count = model.count; }

  void add(const ContactPair& pair, const Contact& contact) {
    pairs.push_back(pair);
    contacts.push_back(contact);
  }
  StepResult advance(double h) { return step.advance(coupling, device, device, planes(), h, bodies); }
  [[nodiscard]] ContactPlanes planes() const { return {query, contacts, pairs}; }
  [[nodiscard]] double energy() const {
    return system_energy(step.model(), coupling, device, planes(), bodies).total();
  }

  [[nodiscard]] Vec3 momentum() const {
    Vec3 sum;
    for (std::size_t i = 0; i < count(); ++i) sum += step.model().body[i].mass * bodies.V_WB[i].v;
    return sum;
  }
  /// About the world's origin.
  [[nodiscard]] Vec3 angular_momentum() const {
    Vec3 sum;
    for (std::size_t i = 0; i < count(); ++i) {
      const BodyModel& m = step.model().body[i];
      sum += cross(bodies.X_WB[i].p, m.mass * bodies.V_WB[i].v);
      if (m.rotates) sum += plain(inertia_W(m.inertia_B, bodies.X_WB[i].R) * eigen(bodies.V_WB[i].w));
    }
    return sum;
  }
  [[nodiscard]] std::size_t count() const { return static_cast<std::size_t>(step.model().count); }

  RigidStep step;
  CouplingParameters coupling;
  DeviceState device;
  BodyStates bodies;
  std::vector<Pose> query;
  std::vector<Contact> contacts;
  std::vector<ContactPair> pairs;
};

SystemModel balls(const std::vector<double>& masses, bool rotate) {
  SystemModel m;
  m.count = static_cast<int>(masses.size());
  for (std::size_t i = 0; i < masses.size(); ++i) {
    m.body[i].mass = masses[i];
    m.body[i].inertia_B = masses[i] * Eigen::Vector3d(1e-4, 2e-4, 1.5e-4).asDiagonal();
    m.body[i].rotates = rotate;
  }
  return m;
}

Contact plane(const Vec3& p_TC, const Vec3& n_W, double distance, double k, double b, double mu) {
  return {.p_TC = p_TC, .n_W = n_W, .distance = distance, .weight = 1, .stiffness = k, .damping = b, .friction = mu};
}

void keep_query(Group& g) {
  g.query.assign(g.bodies.X_WB.begin(), g.bodies.X_WB.begin() + g.step.model().count);
}

}  // namespace

BOOST_AUTO_TEST_CASE(two_free_bodies_keep_momentum_head_on_and_off_centre) {
  for (const Integrator integrator : {Integrator::implicit_euler, Integrator::midpoint}) {
    for (const double aside : {0.0, 0.008}) {
      for (const double ratio : {1.0, 1e4}) {
        SystemModel m = balls({0.1, 0.1 * ratio}, true);
        m.integrator = integrator;
        Group g(m);
        g.bodies.X_WB[0].p = {-0.02, aside, 0.001};
        g.bodies.X_WB[1].p = {0.0, 0, 0};
        g.bodies.V_WB[0] = {{2, 0.1, 0}, {5, 1, -20}};
        g.bodies.V_WB[1] = {{-0.3, 0, 0.2}, {0, 8, 3}};
        keep_query(g);
        for (const double z : {-0.003, 0.004}) {
          g.add({0, 1}, plane({0.01, -aside, z}, {-1, 0, 0}, 0.0005, 5e4, 5, 0.6));
        }
        const Vec3 p = g.momentum(), L = g.angular_momentum();
        const Vec3 v = g.bodies.V_WB[0].v;
        for (int i = 0; i < 100; ++i) BOOST_REQUIRE((g.advance(1e-4).outcome == StepOutcome::converged));
        BOOST_TEST(norm(g.bodies.V_WB[0].v - v) > 0.5);  // they did meet
        BOOST_TEST(norm(g.momentum() - p) < 1e-12 * norm(p));
        // About the origin, where the moving masses have momenta of their own.
        BOOST_TEST(norm(g.angular_momentum() - L) < 1e-11 * (norm(L) + 0.02 * norm(p)));
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(an_elastic_head_on_impact_swaps_the_velocities_of_equal_masses) {
  double last_error = 0;
  for (const double h : {4e-6, 2e-6}) {
    Group g(balls({0.2, 0.2}, false));
    g.bodies.X_WB[1].p = {0.1, 0, 0};
    g.bodies.V_WB[0].v = {1, 0, 0};
    keep_query(g);
    g.add({0, 1}, plane({0.02, 0, 0}, {-1, 0, 0}, 0.0001, 1e4, 0, 0));
    for (int i = 0; i < static_cast<int>(0.03 / h); ++i) g.advance(h);
    const double error = std::abs(g.bodies.V_WB[1].v.x - 1) + std::abs(g.bodies.V_WB[0].v.x);
    BOOST_TEST(error < 0.02);
    // Numerical damping is of first order.
    if (last_error > 0) BOOST_TEST(last_error / error == 2.0, tt::tolerance(0.1));
    last_error = error;
  }
}

BOOST_AUTO_TEST_CASE(an_impact_at_a_distance_gives_the_impulse_of_rigid_body_mechanics) {
  // Frictionless, elastic: J = 2 u / (1/m1 + 1/m2 + (r1 x n) I1^-1 (r1 x n) + (r2 x n) I2^-1 (r2 x n)).
  Group g(balls({0.1, 0.3}, true));
  g.bodies.X_WB[1].p = {0.03, 0, 0};
  g.bodies.V_WB[0].v = {1, 0, 0};
  keep_query(g);
  g.add({0, 1}, plane({0.01, 0.012, 0}, {-1, 0, 0}, 1e-5, 1e7, 0, 0));
  for (int i = 0; i < 3000; ++i) g.advance(1e-7);
  const double I1 = 0.1 * 1.5e-4, I2 = 0.3 * 1.5e-4;
  const double J = 2 / (1 / 0.1 + 1 / 0.3 + 0.012 * 0.012 / I1 + 0.012 * 0.012 / I2);
  BOOST_TEST(g.bodies.V_WB[0].v.x == 1 - J / 0.1, tt::tolerance(0.02));
  BOOST_TEST(g.bodies.V_WB[1].v.x == J / 0.3, tt::tolerance(0.02));
  BOOST_TEST(g.bodies.V_WB[0].w.z == 0.012 * J / I1, tt::tolerance(0.02));
  BOOST_TEST(g.bodies.V_WB[1].w.z == -0.012 * J / I2, tt::tolerance(0.02));
}

BOOST_AUTO_TEST_CASE(a_plane_moves_and_turns_with_its_body) {
  Group g(balls({0.1, 0.1}, true));
  g.bodies.X_WB[0].p = {0, 0, 0.02};
  keep_query(g);
  g.add({0, 1}, plane({0.004, 0, -0.01}, {0, 0, 1}, 0.001, 1e3, 0, 0));
  // The other body turns about x by a right angle and moves: +z becomes -y.
  const Quat R = from_rotation_vector({std::acos(-1.0) / 2, 0, 0});
  g.bodies.X_WB[1] = {{0.5, 0, 0}, R};
  g.bodies.X_WB[0] = g.bodies.X_WB[1] * g.query[0];
  const PlaneNow carried = plane_now(g.planes(), 0, g.bodies.X_WB);
  BOOST_TEST(norm(carried.n_W - Vec3{0, -1, 0}) < 1e-15);
  BOOST_TEST(carried.distance == 0.001, tt::tolerance(1e-12));
  g.bodies.X_WB[0].p += Vec3{0, 0.0015, 0};
  BOOST_TEST(plane_now(g.planes(), 0, g.bodies.X_WB).distance == -0.0005, tt::tolerance(1e-10));
}

BOOST_AUTO_TEST_CASE(a_stack_of_masses_1_to_10000_rests_with_the_weight_above_on_each_contact) {
  for (const bool heavy_on_top : {false, true}) {
    const std::vector<double> masses = heavy_on_top ? std::vector{10.0, 0.001} : std::vector{0.001, 10.0};
    SystemModel m = balls(masses, false);
    m.gravity_W = {0, 0, -9.81};
    Group g(m);
    g.bodies.X_WB[0].p = {0, 0, 0.06};
    g.bodies.X_WB[1].p = {0, 0, 0.02};
    keep_query(g);
    g.add({0, 1}, plane({0, 0, -0.02}, {0, 0, 1}, 0, 1e5, 50, 0.3));
    g.add({1, ContactPair::fixed}, plane({0, 0, -0.02}, {0, 0, 1}, 0, 1e5, 50, 0.3));
    for (int i = 0; i < 4000; ++i) BOOST_REQUIRE((g.advance(1e-3).outcome == StepOutcome::converged));
    const double upper = -plane_now(g.planes(), 0, g.bodies.X_WB).distance * 1e5;
    const double lower = -plane_now(g.planes(), 1, g.bodies.X_WB).distance * 1e5;
    BOOST_TEST(upper == 9.81 * masses[0], tt::tolerance(1e-6));
    BOOST_TEST(lower == 9.81 * (masses[0] + masses[1]), tt::tolerance(1e-6));
    // Equations are met to 1e-9 of their terms, here up to 0.1 N s on 1 g.
    BOOST_TEST(norm(g.bodies.V_WB[0].v) < 1e-7);
    BOOST_TEST(norm(g.bodies.V_WB[1].v) < 1e-7);
  }
}

BOOST_AUTO_TEST_CASE(only_the_tool_hangs_on_the_coupling) {
  Group g(balls({0.1, 0.1}, true));
  g.coupling = {.k_t = 500, .b_t = 14, .k_r = 1, .b_r = 0.01};
  g.device.X_WD.p = {0.01, 0, 0};
  g.bodies.X_WB[1].p = {1, 0, 0};
  g.bodies.V_WB[1] = {{0, 0.1, 0}, {0, 0, 2}};
  keep_query(g);
  for (int i = 0; i < 1000; ++i) g.advance(1e-3);
  BOOST_TEST(g.bodies.X_WB[0].p.x == 0.01, tt::tolerance(1e-6));
  BOOST_TEST(norm(g.bodies.X_WB[1].p - Vec3{1, 0.1, 0}) < 1e-12);
  BOOST_TEST(g.bodies.V_WB[1].w.z == 2.0, tt::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(a_body_that_only_translates_gets_no_rotation_from_one_that_turns) {
  SystemModel m = balls({0.1, 0.1, 0.1}, true);
  m.body[1].rotates = false;
  Group g(m);
  g.bodies.X_WB[1].p = {0.03, 0, 0};
  g.bodies.X_WB[2].p = {0, 0.5, 0};
  g.bodies.V_WB[0] = {{1, 0, 0}, {0, 0, 30}};
  keep_query(g);
  g.add({0, 1}, plane({0.01, 0.01, 0}, {-1, 0, 0}, 0.0001, 1e4, 1, 0.8));
  const Vec3 p = g.momentum();
  for (int i = 0; i < 200; ++i) BOOST_REQUIRE((g.advance(1e-4).outcome == StepOutcome::converged));
  BOOST_TEST(g.bodies.V_WB[1].v.x > 0.05);
  BOOST_TEST((g.bodies.X_WB[1].R == Quat{}));
  BOOST_TEST(norm(g.bodies.V_WB[1].w) == 0.0);
  BOOST_TEST(norm(g.momentum() - p) < 1e-13);
  BOOST_TEST(norm(g.bodies.X_WB[2].p - Vec3{0, 0.5, 0}) == 0.0);
}

BOOST_AUTO_TEST_CASE(eight_bodies_in_a_pile_settle_and_lose_energy) {
  SystemModel m = balls(std::vector<double>(8, 0.05), false);
  m.gravity_W = {0, 0, -9.81};
  Group g(m);
  for (std::size_t i = 0; i < 8; ++i) g.bodies.X_WB[i].p = {0, 0, 0.02 + 0.04 * static_cast<double>(i)};
  keep_query(g);
  for (std::int32_t i = 0; i < 8; ++i) {
    for (const double x : {-0.01, 0.0, 0.01}) {
      g.add({i, i - 1}, plane({x, 0, -0.02}, {0, 0, 1}, 0.002, 2e4, 5, 0.5));
    }
  }
  double last = g.energy();
  for (int i = 0; i < 3000; ++i) {
    BOOST_REQUIRE((g.advance(1e-3).outcome == StepOutcome::converged));
    const double now = g.energy();
    BOOST_REQUIRE(now <= last + 1e-12);
    last = now;
  }
  for (std::size_t i = 0; i < 8; ++i) {
    const double force = -3 * 2e4 * plane_now(g.planes(), 3 * i, g.bodies.X_WB).distance;
    BOOST_TEST(force == 0.05 * 9.81 * static_cast<double>(8 - i), tt::tolerance(1e-6));
  }
}

BOOST_AUTO_TEST_SUITE_END()
