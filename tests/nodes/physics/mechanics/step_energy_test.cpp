// What a step does to energy, by either integrator: at rebound, in free rotation, under friction, in stiff corners.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "framework/realtime/allocation_watch.hpp"
#include "nodes/physics/mechanics/eigen.hpp"
#include "nodes/physics/mechanics/free_rotation.hpp"
#include "nodes/physics/mechanics/normal_force.hpp"
#include "tests/nodes/physics/mechanics/one_body.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(step_energy_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

constexpr Integrator both[] = {Integrator::implicit_euler, Integrator::midpoint};

SystemModel block_by(Integrator integrator, double mass, bool rotates = false) {
  SystemModel m = block(mass, rotates);
  m.integrator = integrator;
  return m;
}

/// A contact of stiffness k with a mass, damped by zeta, and how it is flung at the plane.
struct Fling {
  double k = 2000, mass = 0.1, zeta = 0, h = 1e-3;
  double speed = 0.626;                                                   // m/s, as from a fall of 20 mm
  double phase = 0;                                                       // of a sub-step, where in it contact begins
  [[nodiscard]] double frequency() const { return std::sqrt(k / mass); }  // rad/s
};

/// The share of its speed that the mass has after the rebound, without gravity.
double rebound(Integrator integrator, const Fling& f) {
  SystemModel m = block_by(integrator, f.mass);
  m.gravity_W = {};
  OneBody t(m);
  // The damper is felt from b v / k above the surface on.
  const double away = 2 * f.zeta * f.speed / f.frequency() + (2 + f.phase) * f.speed * f.h;
  t.contacts = {floor_at({}, away, f.k, 2 * f.zeta * std::sqrt(f.k * f.mass), 0)};
  t.V().v.z = -f.speed;
  const int steps = static_cast<int>(4 * away / f.speed / f.h + 3 * M_PI / f.frequency() / f.h) + 20;
  for (int i = 0; i < steps; ++i) BOOST_REQUIRE(t.advance(f.h).outcome == StepOutcome::converged);
  return t.V().v.z / f.speed;
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_midpoint_force_takes_what_the_spring_stores_and_falls_with_the_speed) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  const double k = 3000, h = 1e-3;
  int begins = 0, ends = 0;
  for (int i = 0; i < 1000; ++i) {
    const double phi = 1e-3 * unit(random), u = 2 * unit(random), after = phi + h * u;
    const NormalForce N = normal_force<Integrator::midpoint>(-k * phi, k * h / 2, 0, u);
    const auto stored = [&](double distance) { return 0.5 * k * std::pow(std::min(0.0, distance), 2); };
    BOOST_TEST(std::abs(stored(after) - stored(phi) + N.force * h * u) < 1e-15);
    begins += phi > 0 && after < 0 ? 1 : 0;
    ends += phi < 0 && after > 0 ? 1 : 0;
    for (const double b : {0.0, 2.0}) {
      const auto at = [&](double speed) { return normal_force<Integrator::midpoint>(-k * phi, k * h / 2, b, speed); };
      const double d = 1e-6, slope = (at(u - d).force - at(u + d).force) / (2 * d);
      BOOST_TEST(at(u).slope >= 0.0);
      // Where it changes from one form to the other it has a slope of either side.
      BOOST_TEST((std::abs(at(u).slope - slope) < 1e-3 || std::abs(at(u - d).slope - at(u + d).slope) > 1e-3));
      // A damper takes energy out, whichever way the bodies go.
      BOOST_TEST(stored(after) - stored(phi) + at(u).force * h * u <= 1e-15);
    }
  }
  BOOST_TEST(begins > 50);
  BOOST_TEST(ends > 50);
}

BOOST_AUTO_TEST_CASE(at_an_undamped_rebound_euler_loses_by_its_closed_form_and_midpoint_nothing) {
  for (const double k : {300.0, 2000.0, 20000.0}) {
    for (const double mass : {0.005, 0.1, 0.3}) {
      for (const double h : {1e-4, 1e-3}) {
        const Fling f{.k = k, .mass = mass, .h = h, .phase = 0.3};
        BOOST_TEST(rebound(Integrator::midpoint, f) == 1.0, tt::tolerance(1e-9));
        // Half a period has pi / (w h) steps, each of which divides the amplitude by sqrt(1 + (w h)^2).
        const double wh = f.frequency() * h;
        if (wh < 0.3)
          BOOST_TEST(rebound(Integrator::implicit_euler, f) == std::exp(-M_PI / 2 * wh), tt::tolerance(0.01));
      }
    }
  }
  // Stiffer than any step can follow.
  BOOST_TEST(rebound(Integrator::midpoint, {.k = 1e7, .mass = 0.001}) == 1.0, tt::tolerance(1e-6));
}

BOOST_AUTO_TEST_CASE(a_damped_rebound_converges_to_its_closed_form_with_the_order_of_the_integrator) {
  // The force of this law is a damped oscillator's acceleration from rest, hence e = exp(-pi zeta / sqrt(1 - zeta^2)).
  for (const double zeta : {0.1, 0.4, 0.8}) {
    const double exact = std::exp(-M_PI * zeta / std::sqrt(1 - zeta * zeta));
    for (const Integrator integrator : both) {
      std::vector<double> errors;
      for (const double h : {5e-4, 2.5e-4, 1.25e-4}) {
        double sum = 0;
        for (int i = 0; i < 8; ++i) {
          sum += std::pow(rebound(integrator, {.k = 5000, .zeta = zeta, .h = h, .phase = i / 8.0}) - exact, 2);
        }
        errors.push_back(std::sqrt(sum / 8));
      }
      const double least = integrator == Integrator::midpoint ? 3 : 1.8;
      BOOST_TEST(errors[0] > least * errors[1]);
      BOOST_TEST(errors[1] > least * errors[2]);
      BOOST_TEST(errors[0] < (integrator == Integrator::midpoint ? 0.004 : 0.15));
    }
  }
}

BOOST_AUTO_TEST_CASE(the_critically_damped_response_converges_with_second_order_by_midpoint) {
  SystemModel m = block_by(Integrator::midpoint, 0.1);
  m.gravity_W = {};
  const double w = std::sqrt(500 / 0.1), end = 0.02;
  const double exact = 0.01 * (1 - (1 + w * end) * std::exp(-w * end));
  DeviceState d;
  d.X_WD.p = {0.01, 0, 0};
  std::vector<double> errors;
  for (const int steps : {20, 40, 80}) {
    OneBody t(m);
    t.coupling = spring(500, 0.1);
    t.advance(0, d);  // the handle was there all the time
    for (int i = 0; i < steps; ++i) t.advance(end / steps, d);
    errors.push_back(std::abs(t.X().p.x - exact));
  }
  for (std::size_t i = 1; i < errors.size(); ++i) BOOST_TEST(errors[i - 1] / errors[i] == 4.0, tt::tolerance(0.1));
  BOOST_TEST(errors[0] < 5e-5);
}

BOOST_AUTO_TEST_CASE(a_turning_tool_on_two_springs_converges_with_second_order_by_midpoint) {
  SystemModel m = block_by(Integrator::midpoint, 0.1, true);
  const auto end_of = [&](double h) {
    OneBody t(m);
    t.coupling = spring(300, 0.1, 0.1);
    t.contacts = {floor_at({0.02, 0.01, 0}, -0.004, 800, 0.5, 0), floor_at({-0.03, 0, 0}, -0.004, 800, 0.5, 0)};
    t.V() = {{0.02, 0.01, 0}, {2, -1, 4}};
    for (int i = 0; i < std::lround(0.02 / h); ++i) t.advance(h);
    return std::pair(t.X().p, to_rotation_vector(t.X().R));
  };
  const auto exact = end_of(2e-6);
  std::vector<double> ways, turns;
  for (const double h : {1e-3, 5e-4, 2.5e-4}) {
    const auto [p, turn] = end_of(h);
    ways.push_back(norm(p - exact.first));
    turns.push_back(norm(turn - exact.second));
  }
  for (std::size_t i = 1; i < ways.size(); ++i) {
    BOOST_TEST(ways[i - 1] > 3 * ways[i]);
    BOOST_TEST(turns[i - 1] > 3 * turns[i]);
  }
}

BOOST_AUTO_TEST_CASE(free_rotation_keeps_energy_and_angular_momentum_over_ten_seconds) {
  for (const Integrator integrator : both) {
    SystemModel m = block_by(integrator, 0.5, true);
    m.gravity_W = {};
    for (const double speed : {1.0, 20.0, 300.0}) {
      OneBody t(m);
      t.V().w = (speed / 20) * Vec3{3, 20, 1};
      const auto momentum = [&]() -> Eigen::Vector3d {
        return inertia_W(m.body[0].inertia_B, t.X().R) * eigen(t.V().w);
      };
      const Eigen::Vector3d L = momentum();
      const double energy = t.energy();
      for (int i = 0; i < 10000; ++i) BOOST_REQUIRE(t.advance(1e-3).outcome == StepOutcome::converged);
      BOOST_TEST(t.energy() == energy, tt::tolerance(1e-11));
      BOOST_TEST((momentum() - L).norm() < 1e-11 * L.norm());
    }
  }
}

BOOST_AUTO_TEST_CASE(a_closed_system_in_the_stiff_corner_gains_no_energy_by_midpoint) {
  // The stiff corner: 20 N/mm, 5 g, full friction, 1 ms, with a coupling of 5 N/mm without a damper.
  for (const bool rotates : {false, true}) {
    OneBody t(block_by(Integrator::midpoint, 0.005, rotates));
    t.coupling = spring(5000, 0.005, 0);
    for (const double x : {-0.01, 0.012}) {
      for (const double y : {-0.01, 0.01}) t.contacts.push_back(floor_at({x, y, -0.005}, 0.001, 2e4, 0, 1));
    }
    t.X().p.z = 0.002;
    t.V() = {{0.4, 0.2, -0.6}, rotates ? Vec3{5, -3, 8} : Vec3{}};
    const double first = t.energy();
    double most = first;
    for (int i = 0; i < 5000; ++i) {
      BOOST_REQUIRE(t.advance(1e-3).outcome == StepOutcome::converged);
      most = std::max(most, t.energy());
    }
    BOOST_TEST(most <= first + (rotates ? 0.02 : 1e-9) * std::abs(first));
  }
}

BOOST_AUTO_TEST_CASE(a_pressed_tool_comes_to_rest_in_the_family_of_stiff_and_light_by_midpoint) {
  for (const double mass : {0.005, 0.3}) {
    for (const double k : {300.0, 20000.0}) {
      for (const double coupled : {100.0, 5000.0}) {
        for (const double mu : {0.0, 1.0}) {
          SystemModel m = block_by(Integrator::midpoint, mass, true);
          m.gravity_W = {};
          OneBody t(m);
          t.coupling = spring(coupled, mass);
          for (const double x : {-0.01, 0.01}) {
            for (const double y : {-0.01, 0.01}) {
              t.contacts.push_back(floor_at({x, y, 0}, 0.001, k, 0.2 * std::sqrt(k * mass), mu));
            }
          }
          t.V().v = {0.1, 0, -0.5};
          DeviceState d;
          d.X_WD.p = {0.0005, 0, -0.005};
          StepResult r;
          for (int i = 0; i < 3000; ++i) r = t.advance(1e-3, d);
          const double depth = coupled * (0.005 - 0.001) / (coupled + 4 * k);
          BOOST_TEST(t.X().p.z == -0.001 - depth, tt::tolerance(1e-6));
          BOOST_TEST(r.contact_T_W.force.z == 4 * k * depth, tt::tolerance(1e-4));
          BOOST_TEST(norm(t.V().v) < m.stick_velocity);
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(friction_stops_a_block_where_coulomb_does_and_holds_it_by_midpoint) {
  SystemModel m = block_by(Integrator::midpoint, 0.2);
  m.stick_velocity = 1e-5;
  OneBody t(m);
  t.contacts = {floor_at({}, 0)};
  t.X().p = {0, 0, -0.2 * 9.81 / 2000};
  t.V().v = {0.3, 0, 0};
  double last = 0.3;
  for (int i = 0; i < 500; ++i) {
    t.advance(1e-3);
    // It does not turn back.
    BOOST_REQUIRE(t.V().v.x > -1e-12);
    BOOST_REQUIRE(t.V().v.x <= last + 1e-12);
    last = t.V().v.x;
  }
  BOOST_TEST(t.X().p.x == 0.3 * 0.3 / (2 * 0.3 * 9.81), tt::tolerance(1e-4));
  BOOST_TEST(last < 1e-9);
  for (const double slope : {0.2, 0.4}) {
    m.gravity_W = 9.81 * Vec3{std::sin(slope), 0, -std::cos(slope)};
    m.stick_velocity = 1e-4;
    OneBody s(m);
    s.contacts = {floor_at({}, 0, 1e4, 20, 0.3)};
    s.X().p.z = -0.2 * 9.81 * std::cos(slope) / 1e4;
    for (int i = 0; i < 1000; ++i) s.advance(1e-3);
    if (std::tan(slope) < 0.3) {
      BOOST_TEST(s.V().v.x == m.stick_velocity * std::tan(slope) / 0.3, tt::tolerance(1e-6));
    } else {
      BOOST_TEST(s.V().v.x == 9.81 * (std::sin(slope) - 0.3 * std::cos(slope)), tt::tolerance(1e-3));
    }
  }
}

BOOST_AUTO_TEST_CASE(a_midpoint_step_that_is_not_solved_is_a_step_of_implicit_euler) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  int alike = 0;
  for (int scene = 0; scene < 50; ++scene) {
    std::vector<Contact> contacts;
    for (int i = 0; i < 12; ++i) {
      contacts.push_back(
          floor_at({0.02 * unit(random), 0.02 * unit(random), -0.01}, 0.004 * unit(random), 3e4, 5, 0.5));
    }
    BodyStates ends[2];
    for (const Integrator integrator : both) {
      SystemModel m = block_by(integrator, 0.1, true);
      m.iterations = 1;
      OneBody t(m);
      t.coupling = spring(500, 0.1);
      t.contacts = contacts;
      t.V().v = {0.3, 0.2, -1};
      const double before = t.energy();
      const StepResult r = t.advance(1e-3);
      BOOST_TEST(is_finite(t.X().p));
      if (r.outcome != StepOutcome::converged) BOOST_TEST(t.energy() <= before + 1e-12);
      ends[integrator == Integrator::midpoint ? 1 : 0] = t.bodies;
    }
    alike += ends[0].X_WB[0] == ends[1].X_WB[0] ? 1 : 0;
  }
  BOOST_TEST(alike > 40);
}

BOOST_AUTO_TEST_CASE(a_massless_tool_is_the_same_by_either_integrator) {
  std::vector<Vec3> ends;
  for (const Integrator integrator : both) {
    OneBody t(block_by(integrator, 0.1));
    t.coupling = {.k_t = 500, .massless = 1};
    t.contacts = {floor_at({}, 0, 2000, 0, 0)};
    DeviceState d;
    d.X_WD.p = {0.003, 0, -0.01};
    t.advance(1e-3, d);
    ends.push_back(t.X().p);
  }
  BOOST_TEST(norm(ends[0] - ends[1]) == 0.0);
}

BOOST_AUTO_TEST_CASE(midpoint_steps_allocate_nothing, *boost::unit_test::precondition(tactor::test::heap_is_counted)) {
  for (const bool rotates : {false, true}) {
    OneBody t(block_by(Integrator::midpoint, 0.1, rotates));
    t.coupling = spring(500, 0.1);
    for (int i = 0; i < 60; ++i) t.contacts.push_back(floor_at({0.01 * std::sin(i), 0.01 * std::cos(i), 0}, -0.001));
    const ContactPlanes planes = t.planes();
    RigidStep step(block_by(Integrator::midpoint, 0.1, rotates));
    const std::int64_t before = thread_heap_calls();
    for (int i = 0; i < 100; ++i) step.advance(t.coupling, {}, {}, planes, 1e-3, t.bodies);
    BOOST_TEST(thread_heap_calls() == before);
  }
}

BOOST_AUTO_TEST_SUITE_END()
