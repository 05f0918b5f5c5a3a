// The implicit step against closed forms: springs, gravity, friction, free rotation, and stiff extremes.
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <vector>

#include "framework/realtime/allocation_watch.hpp"
#include "nodes/physics/mechanics/eigen.hpp"
#include "tests/nodes/physics/mechanics/one_body.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(rigid_step_test)

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
  const CouplingParameters coupling = spring(500, 0.2);
  OneBody t(m);
  t.coupling = coupling;
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
  const CouplingParameters coupling = spring(500, 0.1);
  const double w = std::sqrt(500 / 0.1), end = 0.02;
  const double exact = 0.01 * (1 - (1 + w * end) * std::exp(-w * end));
  DeviceState d;
  d.X_WD.p = {0.01, 0, 0};
  std::vector<double> errors;
  for (const int steps : {40, 80, 160, 320}) {
    OneBody t(m);
    t.coupling = coupling;
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
  CouplingParameters coupling;
  coupling.k_r = 0.5;
  const double inertia = m.body[0].inertia_B(2, 2), w = std::sqrt(coupling.k_r / inertia), end = 2 / w;
  coupling.b_r = 2 * std::sqrt(coupling.k_r * inertia);
  DeviceState d;
  d.X_WD.R = from_rotation_vector({0, 0, 0.5});
  OneBody t(m);
  t.coupling = coupling;
  const int steps = 4000;
  for (int i = 0; i < steps; ++i) t.advance(end / steps, d);
  BOOST_TEST(to_rotation_vector(t.X().R).z == 0.5 * (1 - 3 * std::exp(-2.0)), tt::tolerance(2e-3));
}

BOOST_AUTO_TEST_CASE(a_block_slides_to_rest_at_the_distance_of_coulomb) {
  const SystemModel m = [] {
    SystemModel b = block(0.2);
    b.stick_velocity = 1e-5;
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
  const CouplingParameters coupling = spring(500, 0.1);
  const std::vector<Contact> contacts{floor_at({}, 0)};
  for (const double aside : {0.001, 0.004}) {
    DeviceState d;
    d.X_WD.p = {aside, 0, -0.005};
    OneBody t(m);
    t.coupling = coupling;
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

namespace {

/// In W, of a body with diagonal inertia.
Vec3 angular_momentum(const SystemModel& m, OneBody& t) {
  const Vec3 w = rotate(inverse(t.X().R), t.V().w);
  const Eigen::Matrix3d& I = m.body[0].inertia_B;
  return rotate(t.X().R, {I(0, 0) * w.x, I(1, 1) * w.y, I(2, 2) * w.z});
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_free_body_keeps_its_angular_momentum_and_gains_no_energy) {
  SystemModel m = block(0.5, true);
  m.gravity_W = {};
  for (const double speed : {1.0, 20.0, 300.0}) {
    OneBody t(m);
    t.V().w = (speed / 20) * Vec3{3, 20, 1};
    const Vec3 start = angular_momentum(m, t);
    double last = t.energy();
    for (int i = 0; i < 5000; ++i) {
      BOOST_REQUIRE(t.advance(1e-3).outcome == StepOutcome::converged);
      const double now = t.energy();
      BOOST_REQUIRE(now <= last * (1 + 1e-12));
      last = now;
    }
    BOOST_TEST(norm(angular_momentum(m, t) - start) < 1e-12 * norm(start));
    const Quat& q = t.X().R;
    BOOST_TEST(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z == 1.0, tt::tolerance(1e-12));
  }
}

BOOST_AUTO_TEST_CASE(a_body_flips_about_its_intermediate_axis_as_eulers_equations_say) {
  SystemModel m = block(0.5, true);
  m.gravity_W = {};
  const Eigen::Vector3d I = m.body[0].inertia_B.diagonal();
  const Vec3 start{0.01, 10, 0.01};
  // Euler's equations in the body's frame, by Runge and Kutta at 1e-5 s, until it has turned half over.
  const auto rate = [&](const Eigen::Vector3d& w) {
    return Eigen::Vector3d((I[1] - I[2]) * w[1] * w[2] / I[0], (I[2] - I[0]) * w[2] * w[0] / I[1],
                           (I[0] - I[1]) * w[0] * w[1] / I[2]);
  };
  Eigen::Vector3d w(start.x, start.y, start.z);
  const double flip = 1.4;  // s
  for (int i = 0; i < 140000; ++i) {
    const double h = 1e-5;
    const Eigen::Vector3d a = rate(w), b = rate(w + h / 2 * a), c = rate(w + h / 2 * b), d = rate(w + h * c);
    w += h / 6 * (a + 2 * b + 2 * c + d);
  }
  std::vector<double> errors;
  for (const double h : {2e-3, 1e-3, 5e-4}) {
    OneBody t(m);
    t.V().w = start;
    for (int i = 0; i < std::lround(flip / h); ++i) t.advance(h);
    errors.push_back((eigen(rotate(inverse(t.X().R), t.V().w)) - w).norm());
  }
  BOOST_REQUIRE(w[1] < 5);
  BOOST_TEST(errors[0] < 0.02 * 10);
  BOOST_TEST(errors[1] < 0.3 * errors[0]);
  BOOST_TEST(errors[2] < 0.3 * errors[1]);
}

BOOST_AUTO_TEST_CASE(stiff_and_light_stays_bounded) {
  for (const bool rotates : {false, true}) {
    const SystemModel m = block(0.001, rotates);
    const CouplingParameters coupling = spring(1e5, 0.001);
    std::vector<Contact> contacts;
    for (const double x : {-0.01, 0.01}) {
      for (const double y : {-0.01, 0.01}) contacts.push_back(floor_at({x, y, 0}, 0.001, 1e6, 2, 0.8));
    }
    OneBody t(m);
    t.coupling = coupling;
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
  const CouplingParameters coupling = spring(800, 0.1, 0.2);
  std::vector<Contact> contacts;
  for (const double x : {-0.01, 0.013}) {
    for (const double y : {-0.012, 0.01}) contacts.push_back(floor_at({x, y, -0.01}, -0.001, 5e4, 1, 0.3));
  }
  OneBody t(m);
  t.coupling = coupling;
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
  CouplingParameters coupling;
  coupling.k_t = 500;
  coupling.massless = 1;
  const std::vector<Contact> contacts{floor_at({}, 0, 2000, 0, 0)};
  DeviceState d;
  d.X_WD.p = {0.003, 0, -0.01};
  OneBody t(m);
  t.coupling = coupling;
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

BOOST_AUTO_TEST_CASE(a_sphere_bounces_as_its_contact_spring_and_damper_say) {
  SystemModel m = block(0.1);
  m.gravity_W = {};
  const double k = 1e4, b = 12, speed = 1;
  // The same coupling by semi-implicit Euler at 1e-7 s: N = max(0, -k phi - b v), from where the damper first feels it.
  double phi = 0.01, v = -speed;
  for (const double h = 1e-7; phi <= 0.01; phi += h * v) v += h / 0.1 * std::max(0.0, -k * phi - b * v);
  const double restitution = v / speed;
  BOOST_REQUIRE(restitution > 0.4);
  BOOST_REQUIRE(restitution < 0.8);
  std::vector<double> errors;
  for (const double h : {4e-5, 2e-5, 1e-5}) {
    OneBody t(m);
    t.contacts = {floor_at({}, 0.01, k, b, 0)};
    t.V().v.z = -speed;
    for (int i = 0; i < static_cast<int>(0.05 / h); ++i) t.advance(h);
    errors.push_back(std::abs(t.V().v.z / speed - restitution));
  }
  BOOST_TEST(errors[0] < 0.03);
  BOOST_TEST(errors[1] < 0.6 * errors[0]);
  BOOST_TEST(errors[2] < 0.6 * errors[1]);
}

BOOST_AUTO_TEST_CASE(a_light_damper_gives_the_closed_form_of_restitution) {
  // Half a period of a lightly damped oscillator: e = exp(-zeta w pi / w_d), which is exp(-pi zeta) but for terms in
  // zeta^2, among them those of the force that is kept from pulling.
  SystemModel m = block(0.1);
  m.gravity_W = {};
  const double k = 1e4, zeta = 0.01, b = 2 * zeta * std::sqrt(k * 0.1);
  OneBody t(m);
  t.contacts = {floor_at({}, 0.001, k, b, 0)};
  t.V().v.z = -1;
  const double h = 1e-7;
  for (int i = 0; i < 150000; ++i) t.advance(h);
  BOOST_TEST(t.V().v.z == std::exp(-M_PI * zeta), tt::tolerance(1e-3));
}

BOOST_AUTO_TEST_CASE(a_block_on_a_slope_holds_below_the_cone_and_slides_beyond) {
  for (const double slope : {0.2, 0.4}) {
    SystemModel m = block(0.2);
    m.gravity_W = 9.81 * Vec3{std::sin(slope), 0, -std::cos(slope)};
    OneBody t(m);
    t.contacts = {floor_at({}, 0, 1e4, 20, 0.3)};
    t.X().p.z = -0.2 * 9.81 * std::cos(slope) / 1e4;
    for (int i = 0; i < 1000; ++i) t.advance(1e-3);
    if (std::tan(slope) < 0.3) {
      // Viscous below the stick velocity: the share of it that the load has in the cone.
      BOOST_TEST(t.V().v.x == m.stick_velocity * std::tan(slope) / 0.3, tt::tolerance(1e-6));
    } else {
      BOOST_TEST(t.V().v.x == 9.81 * (std::sin(slope) - 0.3 * std::cos(slope)), tt::tolerance(1e-3));
    }
  }
}

BOOST_AUTO_TEST_CASE(a_peg_on_its_rim_carries_its_weight_evenly) {
  SystemModel m = block(0.3, true);
  OneBody t(m);
  for (int i = 0; i < 43; ++i) {
    const double a = 2 * M_PI * i / 43;
    t.contacts.push_back(floor_at({0.01 * std::cos(a), 0.01 * std::sin(a), -0.02}, 0, 2000, 1, 0.3));
    Contact wall = floor_at({0.01 * std::cos(a), 0.01 * std::sin(a), 0}, 0, 2000, 1, 0.3);
    wall.n_W = {-std::cos(a), -std::sin(a), 0};
    t.contacts.push_back(wall);  // the hole, without clearance
  }
  StepResult r;
  for (int i = 0; i < 3000; ++i) r = t.advance(1e-3);
  BOOST_TEST(r.contact_T_W.force.z == 0.3 * 9.81, tt::tolerance(1e-6));
  BOOST_TEST(std::abs(r.contact_T_W.force.x) < 1e-9);
  BOOST_TEST(norm(r.contact_T_W.torque) < 1e-9);
  BOOST_TEST(t.X().p.z == -0.3 * 9.81 / (43 * 2000), tt::tolerance(1e-4));
}

BOOST_AUTO_TEST_CASE(a_tool_pressed_on_a_plane_comes_to_rest) {
  for (const double mass : {0.001, 0.1, 10.0}) {
    for (const double k : {1e2, 1e4, 1e6}) {
      for (const double h : {1e-4, 1e-3, 2e-2}) {
        OneBody t(block(mass, true));
        t.coupling = spring(500, mass);
        for (const double x : {-0.01, 0.01}) {
          for (const double y : {-0.01, 0.01}) t.contacts.push_back(floor_at({x, y, 0}, 0, k, 0.1, 0.3));
        }
        DeviceState d;
        d.X_WD.p = {0, 0, -0.004};
        t.V().v = {0.1, 0, -0.3};
        const auto count = static_cast<int>(10 / h);
        double low = 1, high = -1;
        for (int i = 0; i < count; ++i) {
          t.advance(h, d);
          if (i < count * 9 / 10) continue;
          low = std::min(low, t.X().p.z);
          high = std::max(high, t.X().p.z);
        }
        BOOST_TEST(high - low < 1e-9);
        // What is left is the creep of friction under the sideways spring.
        BOOST_TEST(norm(t.V().v) < 0.5 * block(mass).stick_velocity);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(the_first_step_of_a_contact_has_friction) {
  // From rest on the surface, the handle pulls down and aside: nothing pushes before the step.
  SystemModel m = block(0.1);
  m.gravity_W = {};
  OneBody t(m);
  t.coupling = {.k_t = 1000};
  t.contacts = {floor_at({}, 0, 1e5)};
  DeviceState d;
  d.X_WD.p = {0.01, 0, -0.01};
  const StepResult step = t.advance(1e-3, d);
  BOOST_TEST(step.contact_T_W.force.z > 1.0);
  BOOST_TEST(step.contact_T_W.force.x == -0.3 * step.contact_T_W.force.z, tt::tolerance(1e-3));
}

BOOST_AUTO_TEST_CASE(nothing_drifts_without_gravity) {
  SystemModel m = block(0.1, true);
  m.gravity_W = {};
  OneBody t(m);
  t.coupling = spring(500, 0.1);
  t.contacts = {floor_at({0.01, 0, 0}, 0.0), floor_at({-0.01, 0, 0}, 0.0)};
  for (int i = 0; i < 10000; ++i) t.advance(1e-3);
  BOOST_TEST((t.X() == Pose{}));
  BOOST_TEST(norm(t.V().v) == 0.0);
}

BOOST_AUTO_TEST_CASE(an_impact_at_10_m_s_stays_within_its_energy) {
  for (const double k : {1e3, 1e6}) {
    for (const double h : {1e-4, 1e-3, 2e-2}) {
      OneBody t(block(0.1, true));
      t.contacts = {floor_at({0.01, 0.005, -0.01}, 0.05, k, 1, 0.5), floor_at({-0.01, 0, -0.01}, 0.05, k, 1, 0.5)};
      t.V().v = {1, 0, -10};
      const double first = t.energy();
      for (int i = 0; i < 50; ++i) {
        BOOST_REQUIRE(t.advance(h).outcome == StepOutcome::converged);
        BOOST_REQUIRE(t.energy() < 1.1 * first);
      }
      BOOST_TEST(t.V().v.z > -10.0);
    }
  }
}

BOOST_AUTO_TEST_CASE(steps_allocate_nothing, *boost::unit_test::precondition(tactor::test::heap_is_counted)) {
  for (const bool rotates : {false, true}) {
    OneBody t(block(0.1, rotates));
    t.coupling = spring(500, 0.1);
    for (int i = 0; i < 60; ++i) t.contacts.push_back(floor_at({0.01 * std::sin(i), 0.01 * std::cos(i), 0}, -0.001));
    t.advance(1e-3);
    const ContactPlanes planes = t.planes();
    RigidStep step(block(0.1, rotates));
    const std::int64_t before = thread_heap_calls();
    for (int i = 0; i < 100; ++i) step.advance(t.coupling, {}, {}, planes, 1e-3, t.bodies);
    BOOST_TEST(thread_heap_calls() == before);
  }
  SystemModel several = block(0.1, true);
  several.count = 8;
  several.body.fill(several.body[0]);
  RigidStep step(several);
  BodyStates bodies;
  const std::vector<Pose> query(8);
  std::vector<Contact> contacts(60, floor_at({0.01, 0, 0}, -0.001));
  std::vector<ContactPair> pairs;
  for (std::int32_t i = 0; i < 60; ++i) pairs.push_back({i % 8, i % 8 - 1});
  const std::int64_t before = thread_heap_calls();
  for (int i = 0; i < 20; ++i) step.advance(spring(500, 0.1), {}, {}, {query, contacts, pairs}, 1e-3, bodies);
  BOOST_TEST(thread_heap_calls() == before);
}

BOOST_AUTO_TEST_SUITE_END()
