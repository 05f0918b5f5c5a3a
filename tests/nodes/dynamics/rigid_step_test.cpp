// The implicit step against closed forms: springs, gravity, friction, free rotation, and stiff extremes.
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <vector>

#include "tests/nodes/dynamics/one_body.hpp"

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

bool sane(const BodyStates& s) {
  return is_finite(s.X_WB[0].p) && is_finite(s.V_WB[0].v) && is_finite(s.V_WB[0].w) && std::isfinite(s.X_WB[0].R.w);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_hanging_tool_sags_by_m_g_over_k) {
  const SystemModel m = block(0.2);
  const CouplingLaw law = spring(500, 0.2);
  OneBody t(m);
  t.law = law;
  for (int i = 0; i < 2000; ++i) t.advance(1e-3);
  BOOST_TEST(t.X().p.z == -0.2 * 9.81 / 500, tt::tolerance(1e-9));
  BOOST_TEST(std::abs(t.V().v.z) < 1e-12);
}

BOOST_AUTO_TEST_CASE(a_free_tool_falls_with_an_error_of_first_order) {
  for (const bool rotates : {false, true}) {
    const SystemModel m = block(0.3, rotates);
    OneBody t(m);
    const double h = 1e-3;
    for (int i = 0; i < 500; ++i) t.advance(h);
    BOOST_TEST(t.V().v.z == -9.81 * 0.5, tt::tolerance(1e-10));
    // Implicit Euler sums h^2 g (1 + 2 + ... + n).
    BOOST_TEST(t.X().p.z == -0.5 * 9.81 * (0.25 + 0.5 * h), tt::tolerance(1e-10));
  }
}

BOOST_AUTO_TEST_CASE(the_critically_damped_response_converges_with_first_order) {
  SystemModel m = block(0.1);
  m.gravity_W = {};
  const CouplingLaw law = spring(500, 0.1);
  const double w = std::sqrt(500 / 0.1), end = 0.02;
  const double exact = 0.01 * (1 - (1 + w * end) * std::exp(-w * end));
  DeviceState d;
  d.X_WD.p = {0.01, 0, 0};
  std::vector<double> errors;
  for (const int steps : {40, 80, 160, 320}) {
    OneBody t(m);
    t.law = law;
    for (int i = 0; i < steps; ++i) t.advance(end / steps, d);
    errors.push_back(std::abs(t.X().p.x - exact));
  }
  for (std::size_t i = 1; i < errors.size(); ++i) {
    BOOST_TEST(errors[i - 1] / errors[i] > 1.85);
    BOOST_TEST(errors[i - 1] / errors[i] < 2.15);
  }
  BOOST_TEST(errors.back() < 2e-5);
}

BOOST_AUTO_TEST_CASE(the_rotational_spring_responds_as_its_closed_form) {
  SystemModel m = block(0.1, true);
  m.gravity_W = {};
  CouplingLaw law;
  law.k_r = 0.5;
  const double inertia = m.body[0].inertia_B(2, 2), w = std::sqrt(law.k_r / inertia), end = 2 / w;
  law.b_r = 2 * std::sqrt(law.k_r * inertia);
  DeviceState d;
  d.X_WD.R = from_rotation_vector({0, 0, 0.5});
  OneBody t(m);
  t.law = law;
  const int steps = 4000;
  for (int i = 0; i < steps; ++i) t.advance(end / steps, d);
  BOOST_TEST(to_rotation_vector(t.X().R).z == 0.5 * (1 - 3 * std::exp(-2.0)), tt::tolerance(2e-3));
}

BOOST_AUTO_TEST_CASE(a_block_slides_to_rest_at_the_distance_of_coulomb) {
  const SystemModel m = [] {
    SystemModel b = block(0.2);
    b.stick_velocity = 1e-5;
    b.iterations = 20;
    return b;
  }();
  const double depth = 0.2 * 9.81 / 2000, v = 0.3;
  const std::vector<Contact> contacts{floor_at({}, 0)};
  OneBody t(m);
  t.contacts = contacts;
  t.X().p = {0, 0, -depth};
  t.V().v = {v, 0, 0};
  for (int i = 0; i < 20000; ++i) t.advance(1e-4);
  BOOST_TEST(t.X().p.x == v * v / (2 * 0.3 * 9.81), tt::tolerance(3e-3));
  BOOST_TEST(std::abs(t.V().v.x) < 1e-6);
  BOOST_TEST(t.X().p.z == -depth, tt::tolerance(1e-6));
}

BOOST_AUTO_TEST_CASE(a_pushed_tool_sticks_below_the_friction_limit_and_slides_above_it) {
  SystemModel m = block(0.1);
  m.gravity_W = {};
  const CouplingLaw law = spring(500, 0.1);
  const std::vector<Contact> contacts{floor_at({}, 0)};
  for (const double aside : {0.001, 0.004}) {
    DeviceState d;
    d.X_WD.p = {aside, 0, -0.005};
    OneBody t(m);
    t.law = law;
    t.contacts = contacts;
    StepResult r;
    for (int i = 0; i < 300; ++i) r = t.advance(1e-3, d);
    // The normal force is that of two springs in series.
    BOOST_TEST(r.contact_T_W.force.z == 0.005 * 500 * 2000 / 2500, tt::tolerance(1e-6));
    const double pull = 500 * (aside - t.X().p.x);
    if (aside < 0.3 * 0.005 * 2000 / 2500) {
      BOOST_TEST(t.V().v.x < 0.0005);
    } else {
      BOOST_TEST(pull <= 0.3 * r.contact_T_W.force.z * 1.001);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_free_body_keeps_its_angular_momentum) {
  SystemModel m = block(0.5, true);
  m.gravity_W = {};
  m.iterations = 20;
  OneBody t(m);
  t.V().w = {3, 20, 1};
  const auto momentum = [&] {
    const Vec3 w = rotate(inverse(t.X().R), t.V().w);
    return rotate(t.X().R,
                  {m.body[0].inertia_B(0, 0) * w.x, m.body[0].inertia_B(1, 1) * w.y, m.body[0].inertia_B(2, 2) * w.z});
  };
  const Vec3 start = momentum();
  double last = t.energy();
  for (int i = 0; i < 5000; ++i) {
    BOOST_REQUIRE(t.advance(1e-3).outcome == StepOutcome::converged);
    const double now = t.energy();
    BOOST_REQUIRE(now <= last * (1 + 1e-9));
    last = now;
  }
  BOOST_TEST(norm(momentum() - start) < 1e-8 * norm(start));
  const Quat& q = t.X().R;
  BOOST_TEST(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z == 1.0, tt::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(stiff_and_light_stays_bounded) {
  for (const bool rotates : {false, true}) {
    const SystemModel m = block(0.001, rotates);
    const CouplingLaw law = spring(1e5, 0.001);
    std::vector<Contact> contacts;
    for (const double x : {-0.01, 0.01}) {
      for (const double y : {-0.01, 0.01}) contacts.push_back(floor_at({x, y, 0}, 0.001, 1e6, 2, 0.8));
    }
    OneBody t(m);
    t.law = law;
    t.contacts = contacts;
    t.V() = {{1, -2, 3}, {10, 0, -5}};
    for (int i = 0; i < 2000; ++i) {
      DeviceState d;
      d.X_WD.p = {0.02 * std::sin(0.05 * i), 0, -0.02 * std::sin(0.03 * i)};
      d.X_WD.R = from_rotation_vector({0.3 * std::sin(0.02 * i), 0.2, 0});
      BOOST_REQUIRE(t.advance(1e-3, d).outcome == StepOutcome::converged);
      BOOST_REQUIRE(sane(t.bodies));
      BOOST_REQUIRE(norm(t.X().p) < 0.05);
    }
  }
}

BOOST_AUTO_TEST_CASE(energy_never_grows_without_input) {
  SystemModel m = block(0.1, true);
  const CouplingLaw law = spring(800, 0.1, 0.2);
  std::vector<Contact> contacts;
  for (const double x : {-0.01, 0.013}) {
    for (const double y : {-0.012, 0.01}) contacts.push_back(floor_at({x, y, -0.01}, -0.001, 5e4, 1, 0.3));
  }
  OneBody t(m);
  t.law = law;
  t.contacts = contacts;
  t.X() = {{0, 0, 0.004}, from_rotation_vector({0.2, -0.1, 0})};
  t.V() = {{0.3, 0.1, -1}, {1, 2, 3}};
  double last = t.energy();
  const double first = last;
  for (int i = 0; i < 3000; ++i) {
    t.advance(2e-4);
    const double now = t.energy();
    BOOST_REQUIRE(now <= last + 1e-6 * first);
    last = now;
  }
  BOOST_TEST(last < 0.3 * first);
}

BOOST_AUTO_TEST_CASE(a_massless_tool_rests_where_springs_balance) {
  const SystemModel m = block(0.1);
  CouplingLaw law;
  law.k_t = 500;
  law.massless = 1;
  const std::vector<Contact> contacts{floor_at({}, 0, 2000, 0, 0)};
  DeviceState d;
  d.X_WD.p = {0.003, 0, -0.01};
  OneBody t(m);
  t.law = law;
  t.contacts = contacts;
  const StepResult r = t.advance(1e-3, d);
  BOOST_TEST(t.X().p.z == -0.01 * 500 / 2500, tt::tolerance(1e-10));
  BOOST_TEST(t.X().p.x == 0.003, tt::tolerance(1e-10));
  BOOST_TEST(r.contact_T_W.force.z == 0.01 * 500 * 2000 / 2500, tt::tolerance(1e-10));
  BOOST_TEST(r.touching == 1);
}

BOOST_AUTO_TEST_CASE(an_off_centre_contact_turns_the_tool) {
  SystemModel m = block(0.1, true);
  m.gravity_W = {};
  const std::vector<Contact> contacts{floor_at({0.02, 0, 0}, -0.001, 1000, 0, 0)};
  OneBody t(m);
  t.contacts = contacts;
  const StepResult r = t.advance(1e-6);
  BOOST_TEST(r.contact_T_W.force.z == 1.0, tt::tolerance(1e-4));
  BOOST_TEST(r.contact_T_W.torque.y == -0.02, tt::tolerance(1e-4));
  BOOST_TEST(t.V().w.y == -0.02 / m.body[0].inertia_B(1, 1) * 1e-6, tt::tolerance(1e-3));
}

BOOST_AUTO_TEST_CASE(a_system_without_solution_leaves_the_pose_at_rest) {
  OneBody t(block(0.1));
  t.law.massless = 1;
  // Nothing holds it sideways.
  t.contacts = {floor_at({}, -0.001, 2000, 0, 0)};
  t.X().p = t.query.p = {1, 2, 3};
  t.V().v = {1, 1, 1};
  BOOST_TEST((t.advance(1e-3).outcome == StepOutcome::stopped));
  BOOST_TEST(norm(t.X().p - Vec3{1, 2, 3}) == 0.0);
  BOOST_TEST(norm(t.V().v) == 0.0);
}
