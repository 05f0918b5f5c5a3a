// The implicit step against closed forms: springs, gravity, friction, free rotation, and stiff extremes.
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <vector>

#include "nodes/dynamics/rigid_step.hpp"

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

ToolModel block(double mass, bool rotates = false) {
  ToolModel m;
  m.mass = mass;
  m.inertia_T = mass * Eigen::Vector3d(1e-4, 2e-4, 3e-4).asDiagonal();
  m.gravity_W = {0, 0, -9.81};
  m.rotates = rotates;
  return m;
}

CouplingLaw spring(double k, double mass, double zeta = 1) {
  return {.k_t = k,
          .b_t = 2 * zeta * std::sqrt(k * mass),
          .k_r = k * 1e-3,
          .b_r = 2 * zeta * std::sqrt(k * 1e-3 * mass * 2e-4)};
}

Contact floor_at(const Vec3& p_TC, double height, double k = 2000, double b = 2, double mu = 0.3) {
  return {.p_TC = p_TC,
          .p_WC = {0, 0, 0},
          .n_W = {0, 0, 1},
          .distance = height,
          .weight = 1,
          .stiffness = k,
          .damping = b,
          .friction = mu};
}

double energy(const ToolModel& m, const CouplingLaw& law, const DeviceState& d, const ToolState& t,
              const std::vector<Contact>& contacts = {}) {
  const Vec3 stretch = d.X_WD.p - t.X_WT.p;
  double e = 0.5 * m.mass * dot(t.V_WT.v, t.V_WT.v) - m.mass * dot(m.gravity_W, t.X_WT.p) +
             0.5 * law.k_t * dot(stretch, stretch);
  if (m.rotates) {
    const Vec3 w = rotate(inverse(t.X_WT.R), t.V_WT.w);
    for (int i = 0; i < 3; ++i) e += 0.5 * m.inertia_T(i, i) * w[i] * w[i];
    const Vec3 turn = to_rotation_vector(d.X_WD.R * inverse(t.X_WT.R));
    e += 0.5 * law.k_r * dot(turn, turn);
  }
  for (const Contact& c : contacts) {
    const double phi = c.distance + dot(c.n_W, transform(t.X_WT, c.p_TC) - c.p_TC);
    if (phi < 0) e += 0.5 * c.stiffness * c.weight * phi * phi;
  }
  return e;
}

bool sane(const ToolState& t) {
  return is_finite(t.X_WT.p) && is_finite(t.V_WT.v) && is_finite(t.V_WT.w) && std::isfinite(t.X_WT.R.w);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_hanging_tool_sags_by_m_g_over_k) {
  const ToolModel m = block(0.2);
  const CouplingLaw law = spring(500, 0.2);
  ToolState t;
  for (int i = 0; i < 2000; ++i) rigid_step(m, law, {}, {}, 1e-3, t);
  BOOST_TEST(t.X_WT.p.z == -0.2 * 9.81 / 500, tt::tolerance(1e-9));
  BOOST_TEST(std::abs(t.V_WT.v.z) < 1e-12);
}

BOOST_AUTO_TEST_CASE(a_free_tool_falls_with_an_error_of_first_order) {
  for (const bool rotates : {false, true}) {
    const ToolModel m = block(0.3, rotates);
    ToolState t;
    const double h = 1e-3;
    for (int i = 0; i < 500; ++i) rigid_step(m, {}, {}, {}, h, t);
    BOOST_TEST(t.V_WT.v.z == -9.81 * 0.5, tt::tolerance(1e-10));
    // Implicit Euler sums h^2 g (1 + 2 + ... + n).
    BOOST_TEST(t.X_WT.p.z == -0.5 * 9.81 * (0.25 + 0.5 * h), tt::tolerance(1e-10));
  }
}

BOOST_AUTO_TEST_CASE(the_critically_damped_response_converges_with_first_order) {
  ToolModel m = block(0.1);
  m.gravity_W = {};
  const CouplingLaw law = spring(500, 0.1);
  const double w = std::sqrt(500 / 0.1), end = 0.02;
  const double exact = 0.01 * (1 - (1 + w * end) * std::exp(-w * end));
  DeviceState d;
  d.X_WD.p = {0.01, 0, 0};
  std::vector<double> errors;
  for (const int steps : {40, 80, 160, 320}) {
    ToolState t;
    for (int i = 0; i < steps; ++i) rigid_step(m, law, d, {}, end / steps, t);
    errors.push_back(std::abs(t.X_WT.p.x - exact));
  }
  for (std::size_t i = 1; i < errors.size(); ++i) {
    BOOST_TEST(errors[i - 1] / errors[i] > 1.85);
    BOOST_TEST(errors[i - 1] / errors[i] < 2.15);
  }
  BOOST_TEST(errors.back() < 2e-5);
}

BOOST_AUTO_TEST_CASE(the_rotational_spring_responds_as_its_closed_form) {
  ToolModel m = block(0.1, true);
  m.gravity_W = {};
  CouplingLaw law;
  law.k_r = 0.5;
  const double inertia = m.inertia_T(2, 2), w = std::sqrt(law.k_r / inertia), end = 2 / w;
  law.b_r = 2 * std::sqrt(law.k_r * inertia);
  DeviceState d;
  d.X_WD.R = from_rotation_vector({0, 0, 0.5});
  ToolState t;
  const int steps = 4000;
  for (int i = 0; i < steps; ++i) rigid_step(m, law, d, {}, end / steps, t);
  BOOST_TEST(to_rotation_vector(t.X_WT.R).z == 0.5 * (1 - 3 * std::exp(-2.0)), tt::tolerance(2e-3));
}

BOOST_AUTO_TEST_CASE(a_block_slides_to_rest_at_the_distance_of_coulomb) {
  const ToolModel m = [] {
    ToolModel b = block(0.2);
    b.stick_velocity = 1e-5;
    b.iterations = 20;
    return b;
  }();
  const double depth = 0.2 * 9.81 / 2000, v = 0.3;
  const std::vector<Contact> contacts{floor_at({}, 0)};
  ToolState t;
  t.X_WT.p = {0, 0, -depth};
  t.V_WT.v = {v, 0, 0};
  for (int i = 0; i < 20000; ++i) rigid_step(m, {}, {}, {{}, contacts}, 1e-4, t);
  BOOST_TEST(t.X_WT.p.x == v * v / (2 * 0.3 * 9.81), tt::tolerance(3e-3));
  BOOST_TEST(std::abs(t.V_WT.v.x) < 1e-6);
  BOOST_TEST(t.X_WT.p.z == -depth, tt::tolerance(1e-6));
}

BOOST_AUTO_TEST_CASE(a_pushed_tool_sticks_below_the_friction_limit_and_slides_above_it) {
  ToolModel m = block(0.1);
  m.gravity_W = {};
  const CouplingLaw law = spring(500, 0.1);
  const std::vector<Contact> contacts{floor_at({}, 0)};
  for (const double aside : {0.001, 0.004}) {
    DeviceState d;
    d.X_WD.p = {aside, 0, -0.005};
    ToolState t;
    StepResult r;
    for (int i = 0; i < 300; ++i) r = rigid_step(m, law, d, {{}, contacts}, 1e-3, t);
    // The normal force is that of two springs in series.
    BOOST_TEST(r.contact_T_W.force.z == 0.005 * 500 * 2000 / 2500, tt::tolerance(1e-6));
    const double pull = 500 * (aside - t.X_WT.p.x);
    if (aside < 0.3 * 0.005 * 2000 / 2500) {
      BOOST_TEST(t.V_WT.v.x < 0.0005);
    } else {
      BOOST_TEST(pull <= 0.3 * r.contact_T_W.force.z * 1.001);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_free_body_keeps_its_angular_momentum) {
  ToolModel m = block(0.5, true);
  m.gravity_W = {};
  m.iterations = 20;
  ToolState t;
  t.V_WT.w = {3, 20, 1};
  const auto momentum = [&] {
    const Vec3 w = rotate(inverse(t.X_WT.R), t.V_WT.w);
    return rotate(t.X_WT.R, {m.inertia_T(0, 0) * w.x, m.inertia_T(1, 1) * w.y, m.inertia_T(2, 2) * w.z});
  };
  const Vec3 start = momentum();
  double last = energy(m, {}, {}, t);
  for (int i = 0; i < 5000; ++i) {
    BOOST_REQUIRE(rigid_step(m, {}, {}, {}, 1e-3, t).solved);
    const double now = energy(m, {}, {}, t);
    BOOST_REQUIRE(now <= last * (1 + 1e-9));
    last = now;
  }
  BOOST_TEST(norm(momentum() - start) < 1e-8 * norm(start));
  const Quat& q = t.X_WT.R;
  BOOST_TEST(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z == 1.0, tt::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(stiff_and_light_stays_bounded) {
  for (const bool rotates : {false, true}) {
    const ToolModel m = block(0.001, rotates);
    const CouplingLaw law = spring(1e5, 0.001);
    std::vector<Contact> contacts;
    for (const double x : {-0.01, 0.01}) {
      for (const double y : {-0.01, 0.01}) contacts.push_back(floor_at({x, y, 0}, 0.001, 1e6, 2, 0.8));
    }
    ToolState t;
    t.V_WT = {{1, -2, 3}, {10, 0, -5}};
    for (int i = 0; i < 2000; ++i) {
      DeviceState d;
      d.X_WD.p = {0.02 * std::sin(0.05 * i), 0, -0.02 * std::sin(0.03 * i)};
      d.X_WD.R = from_rotation_vector({0.3 * std::sin(0.02 * i), 0.2, 0});
      BOOST_REQUIRE(rigid_step(m, law, d, {{}, contacts}, 1e-3, t).solved);
      BOOST_REQUIRE(sane(t));
      BOOST_REQUIRE(norm(t.X_WT.p) < 0.05);
    }
  }
}

BOOST_AUTO_TEST_CASE(energy_never_grows_without_input) {
  ToolModel m = block(0.1, true);
  const CouplingLaw law = spring(800, 0.1, 0.2);
  std::vector<Contact> contacts;
  for (const double x : {-0.01, 0.013}) {
    for (const double y : {-0.012, 0.01}) contacts.push_back(floor_at({x, y, -0.01}, -0.001, 5e4, 1, 0.3));
  }
  ToolState t;
  t.X_WT = {{0, 0, 0.004}, from_rotation_vector({0.2, -0.1, 0})};
  t.V_WT = {{0.3, 0.1, -1}, {1, 2, 3}};
  double last = energy(m, law, {}, t, contacts);
  const double first = last;
  for (int i = 0; i < 3000; ++i) {
    rigid_step(m, law, {}, {{}, contacts}, 2e-4, t);
    const double now = energy(m, law, {}, t, contacts);
    BOOST_REQUIRE(now <= last + 1e-6 * first);
    last = now;
  }
  BOOST_TEST(last < 0.3 * first);
}

BOOST_AUTO_TEST_CASE(a_massless_tool_rests_where_springs_balance) {
  const ToolModel m = block(0.1);
  CouplingLaw law;
  law.k_t = 500;
  law.massless = 1;
  const std::vector<Contact> contacts{floor_at({}, 0, 2000, 0, 0)};
  DeviceState d;
  d.X_WD.p = {0.003, 0, -0.01};
  ToolState t;
  const StepResult r = rigid_step(m, law, d, {{}, contacts}, 1e-3, t);
  BOOST_TEST(t.X_WT.p.z == -0.01 * 500 / 2500, tt::tolerance(1e-10));
  BOOST_TEST(t.X_WT.p.x == 0.003, tt::tolerance(1e-10));
  BOOST_TEST(r.contact_T_W.force.z == 0.01 * 500 * 2000 / 2500, tt::tolerance(1e-10));
  BOOST_TEST(r.touching == 1);
}

BOOST_AUTO_TEST_CASE(an_off_centre_contact_turns_the_tool) {
  ToolModel m = block(0.1, true);
  m.gravity_W = {};
  const std::vector<Contact> contacts{floor_at({0.02, 0, 0}, -0.001, 1000, 0, 0)};
  ToolState t;
  const StepResult r = rigid_step(m, {}, {}, {{}, contacts}, 1e-6, t);
  BOOST_TEST(r.contact_T_W.force.z == 1.0, tt::tolerance(1e-4));
  BOOST_TEST(r.contact_T_W.torque.y == -0.02, tt::tolerance(1e-4));
  BOOST_TEST(t.V_WT.w.y == -0.02 / m.inertia_T(1, 1) * 1e-6, tt::tolerance(1e-3));
}

BOOST_AUTO_TEST_CASE(a_system_without_solution_leaves_the_pose_at_rest) {
  CouplingLaw law;
  law.massless = 1;
  ToolState t;
  t.X_WT.p = {1, 2, 3};
  t.V_WT.v = {1, 1, 1};
  const StepResult r = rigid_step(block(0.1), law, {}, {}, 1e-3, t);
  BOOST_TEST(!r.solved);
  BOOST_TEST(norm(t.X_WT.p - Vec3{1, 2, 3}) == 0.0);
  BOOST_TEST(norm(t.V_WT.v) == 0.0);
}
