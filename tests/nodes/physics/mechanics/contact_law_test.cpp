// Contacts that tell inertia, creep and lift: closed forms, slopes, energy, and that zeros change nothing.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

#include "nodes/physics/mechanics/plane_forces.hpp"
#include "tests/nodes/physics/mechanics/one_body.hpp"
#include "tests/support/dice.hpp"

BOOST_AUTO_TEST_SUITE(contact_law_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

constexpr Integrator both[] = {Integrator::implicit_euler, Integrator::midpoint};
constexpr double g = 9.81;  // m/s^2

SystemModel block_by(Integrator integrator, double mass, bool weighs, bool rotates = false) {
  SystemModel m = block(mass, rotates);
  m.integrator = integrator;
  if (!weighs) m.gravity_W = {};
  return m;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_mass_falls_into_a_contact_of_inertia_alone_as_if_it_had_both_masses) {
  for (const Integrator integrator : both) {
    for (const bool rotates : {false, true}) {
      OneBody t(block_by(integrator, 0.2, true, rotates));
      t.contacts = {floor_at({}, -1e-3, 0, 0, 0)};
      t.contacts[0].inertia = 0.6;
      t.contacts[0].weight = 0.5;
      StepResult r;
      for (int i = 0; i < 100; ++i) r = t.advance(1e-3);
      BOOST_TEST(t.V().v.z == -g * 0.1 * 0.2 / (0.2 + 0.3), tt::tolerance(1e-9));
      BOOST_TEST(r.contact_T_W.force.z == 0.3 * g * 0.2 / 0.5, tt::tolerance(1e-9));
    }
  }
}

BOOST_AUTO_TEST_CASE(a_pressed_mass_swings_with_the_frequency_of_both_masses) {
  const double m = 0.1, m_c = 0.3, k = 1000, w = std::sqrt(k / (m + m_c)), swing = 2e-4, end = 0.1;
  const double rest = -m * g / k;
  for (const double h : {1e-3, 5e-4}) {
    OneBody t(block_by(Integrator::midpoint, m, true));
    t.contacts = {floor_at({}, 0, k, 0, 0)};
    t.contacts[0].inertia = m_c;
    t.X().p.z = rest - swing;
    for (int i = 0; i < std::lround(end / h); ++i) t.advance(h);
    // A step of the midpoint rule turns the phase by 2 atan(w h / 2).
    const double phase = 2 * std::atan(w * h / 2) * (end / h);
    BOOST_TEST(std::abs(t.X().p.z - rest + swing * std::cos(phase)) < 1e-9);
  }
}

BOOST_AUTO_TEST_CASE(beside_an_inertia_the_damper_acts_from_the_surface_on) {
  for (const Integrator integrator : both) {
    for (const double inertia : {0.0, 0.2}) {
      OneBody t(block_by(integrator, 0.1, false));
      t.contacts = {floor_at({}, 2e-3, 1000, 40, 0)};
      t.contacts[0].inertia = inertia;
      t.V().v.z = -0.1;
      int pushed_above = 0;
      for (int i = 0; i < 22; ++i) {
        const bool above = t.X().p.z - 1e-4 > -2e-3;
        const StepResult r = t.advance(1e-3);
        if (above && r.touching > 0) ++pushed_above;
      }
      BOOST_TEST((pushed_above > 0) == (inertia == 0));
      if (inertia > 0) BOOST_TEST(t.X().p.z < -2e-3);
    }
  }
}

BOOST_AUTO_TEST_CASE(static_friction_creeps_at_the_stated_speed_by_its_force) {
  const double slope = 0.2, mass = 0.2;
  for (const Integrator integrator : both) {
    for (const double weight : {1.0, 0.5}) {
      SystemModel m = block_by(integrator, mass, true);
      m.gravity_W = g * Vec3{std::sin(slope), 0, -std::cos(slope)};
      OneBody t(m);
      t.contacts = {floor_at({}, 0, 1e4, 20, 0.3)};
      t.contacts[0].weight = weight;
      t.contacts[0].creep = 0.01;
      t.X().p.z = -mass * g * std::cos(slope) / (1e4 * weight);
      for (int i = 0; i < 1000; ++i) t.advance(1e-3);
      BOOST_TEST(t.V().v.x == 0.01 / weight * mass * g * std::sin(slope), tt::tolerance(1e-4));
    }
  }
}

BOOST_AUTO_TEST_CASE(sliding_lifts_by_the_stated_force) {
  const double mass = 0.05, k = 800, b = 30, mu = 0.4, v = 0.08;
  for (const Integrator integrator : both) {
    for (const double lift : {0.0, 0.5, 1.0}) {
      for (const double creep : {0.0, 0.02}) {
        OneBody t(block_by(integrator, mass, false));
        t.coupling = spring(600, mass);
        t.contacts = {floor_at({}, 0, k, b, mu)};
        t.contacts[0].inertia = 0.5;
        t.contacts[0].creep = creep;
        t.contacts[0].lift = lift;
        DeviceState d;
        d.X_WD.p.z = -0.003;
        d.V_WD.v.x = v;
        StepResult r;
        for (int i = 0; i < 4000; ++i) {
          d.X_WD.p.x += 1e-3 * v;
          r = t.advance(1e-3, d);
        }
        const double N = r.contact_T_W.force.z, depth = -t.X().p.z;
        BOOST_TEST(t.V().v.x == v, tt::tolerance(1e-6));
        BOOST_TEST(N == k * depth + lift * b * mu * (v - std::max(1e-4, creep * mu * N)), tt::tolerance(1e-3));
        // The coupling presses with as much.
        BOOST_TEST(N == 600 * (0.003 - depth), tt::tolerance(1e-4));
        BOOST_TEST(r.contact_T_W.force.x == -mu * N, tt::tolerance(1e-4));
      }
    }
  }
}

namespace {

template <Integrator integrator>
void check_slopes() {
  Dice dice(11);
  const PlaneForces<integrator> law(1e-4);
  int compared = 0, lifting = 0, kinks = 0;
  for (int i = 0; i < 2000; ++i) {
    RigidStep::Plane p;
    const Vec3 n = dice.in_cube(1);
    p.n = (1 / norm(n)) * n;
    p.push = dice(0, 2);
    p.spring = dice(0, 5);
    p.inertia = dice(0, 50);
    p.damping = p.inertia + dice(0, 50);
    p.friction = dice(0, 1);
    p.bound = dice(0, 1);
    p.creep = dice(0, 0.1);
    p.lift = i % 2 == 0 ? 0 : p.friction * (p.damping - p.inertia);
    p.carried = dice(-1, 1);
    p.coned = p.lift > 0;
    p.lifted = p.coned ? dice(-1, 0) : 0;
    p.u = dice.in_cube(0.05);
    p.u_start = dice.in_cube(0.05);
    Eigen::Matrix3d S;
    if (!law.slope(p, S)) S.setZero();
    Eigen::Matrix3d forward, backward;
    const double d = 1e-7;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 step;
      step[axis] = d;
      const Vec3 here = law.force(p, p.u), after = law.force(p, p.u + step), before = law.force(p, p.u - step);
      forward.col(axis) = -eigen(after - here) / d;
      backward.col(axis) = -eigen(here - before) / d;
    }
    const double size = 1 + S.norm();
    // At a kink it has a slope of either side.
    if ((forward - backward).norm() > 0.02 * size) {
      ++kinks;
      continue;
    }
    BOOST_TEST((0.5 * (forward + backward) - S).norm() < 1e-3 * size);
    BOOST_TEST((S - S.transpose()).norm() <= 1e-12 * size);
    ++compared;
    lifting += p.lift > 0 && S.norm() > 0 ? 1 : 0;
  }
  BOOST_TEST(compared > 1800);
  BOOST_TEST(lifting > 300);
  BOOST_TEST(kinks < 100);
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_slopes_of_a_plane_are_those_of_its_force) {
  check_slopes<Integrator::implicit_euler>();
  check_slopes<Integrator::midpoint>();
}

namespace {

/// A block that is flung among random contacts.
OneBody among_contacts(Dice& dice, Integrator integrator, int count) {
  const double mass = 0.005 * std::pow(60, dice(0, 1));
  OneBody t(block_by(integrator, mass, false));
  t.coupling = spring(dice(300, 2300), mass, dice(0, 1));
  for (int i = 0; i < count; ++i) {
    Vec3 n = dice.in_cube(0.5) + Vec3{0, 0, 0.2};
    n = (1 / norm(n)) * n;
    const double damping = dice(1, 100);
    t.contacts.push_back({.n_W = n,
                          .distance = dice(-7e-4, 3e-4),
                          .weight = dice(0.2, 1.2),
                          .stiffness = dice(500, 5500),
                          .damping = damping,
                          .friction = dice(0, 1),
                          .inertia = dice(0, 1) < 0.7 ? mass * dice(1, 20) : 0,
                          .creep = dice(0, 1) < 0.7 ? dice(0.3, 3) / damping : 0,
                          .lift = dice(0, 1) < 0.7 ? 1 : dice(0, 1)});
  }
  t.V().v = dice.in_cube(0.3);
  return t;
}

}  // namespace

BOOST_AUTO_TEST_CASE(no_contact_feeds_energy_in_beyond_that_of_the_mass_that_it_begins_with) {
  Dice dice(5);
  int touching = 0;
  for (const Integrator integrator : both) {
    for (const double h : {1e-4, 1e-3, 4e-3}) {
      for (int scene = 0; scene < 20; ++scene) {
        OneBody t = among_contacts(dice, integrator, 1 + scene % 5);
        std::vector<double> speed(t.contacts.size());
        for (int i = 0; i < 60; ++i) {
          // The energy that t.energy() has, and how much of it the contacts' masses may keep.
          const double had = t.energy();
          for (std::size_t k = 0; k < speed.size(); ++k) speed[k] = dot(t.contacts[k].n_W, t.V().v);
          const Vec3 p = t.X().p;
          const StepResult r = t.advance(h);
          double has = t.energy();
          for (std::size_t k = 0; k < speed.size(); ++k) {
            const Contact& c = t.contacts[k];
            const double u = dot(c.n_W, t.V().v);
            const bool was = c.distance + dot(c.n_W, p) < 0, is = c.distance + dot(c.n_W, t.X().p) < 0;
            const double own = 0.5 * c.inertia * c.weight * u * u;
            const double before = 0.5 * c.inertia * c.weight * speed[k] * speed[k];
            if (is) has -= was ? std::max(0.0, own - before) : own;
          }
          BOOST_TEST(has - had <= r.work + 1e-6 * (had + 1e-9));
          BOOST_TEST((r.outcome != StepOutcome::stopped));
          touching += r.touching;
        }
      }
    }
  }
  BOOST_TEST(touching > 1000);
}

BOOST_AUTO_TEST_CASE(a_pressed_contact_that_never_ends_only_loses_energy) {
  // With weight, inertia counted; the block never leaves, so nothing begins anew.
  for (const Integrator integrator : both) {
    OneBody t(block_by(integrator, 0.05, true));
    t.contacts = {floor_at({}, -2e-3, 500, 20, 0.3)};
    t.contacts[0].inertia = 0.5;
    t.contacts[0].creep = 1 / 20.0;
    t.contacts[0].lift = 1;
    t.V().v = {0.05, 0, -0.02};
    double last = t.energy();
    for (int i = 0; i < 300; ++i) {
      BOOST_REQUIRE(t.advance(1e-3).outcome == StepOutcome::converged);
      BOOST_REQUIRE(t.X().p.z < 2e-3);
      BOOST_REQUIRE(t.energy() <= last + 1e-9);
      last = t.energy();
    }
  }
}

BOOST_AUTO_TEST_CASE(the_energy_counts_the_mass_of_contacts_that_overlap) {
  OneBody t(block_by(Integrator::implicit_euler, 0.1, false, true));
  t.contacts = {floor_at({0.02, 0, 0}, -1e-3, 0, 0, 0), floor_at({}, 1e-3, 0, 0, 0)};
  for (Contact& c : t.contacts) c.inertia = 0.4;
  t.contacts[0].weight = 0.5;
  t.V() = {{0, 0, 0.1}, {0, 2, 0}};
  const double speed = 0.1 - 2 * 0.02;
  const double own = 0.5 * 0.1 * 0.01 + 0.5 * 0.1 * 2e-4 * 4;
  BOOST_TEST(t.energy() == own + 0.5 * 0.2 * speed * speed, tt::tolerance(1e-12));
  t.coupling.massless = 1;
  BOOST_TEST(t.energy() == 0.0);
}

BOOST_AUTO_TEST_CASE(a_massless_tool_feels_neither_inertia_nor_lift) {
  std::vector<Vec3> ends;
  for (const double law : {0.0, 1.0}) {
    OneBody t(block(0.1));
    t.coupling = {.k_t = 500, .massless = 1};
    t.contacts = {floor_at({}, 0, 2000, 3, 0.2)};
    t.contacts[0].inertia = 0.5 * law;
    t.contacts[0].lift = law;
    DeviceState d;
    d.X_WD.p = {0.003, 0, -0.01};
    for (int i = 0; i < 3; ++i) t.advance(1e-3, d);
    ends.push_back(t.X().p);
  }
  BOOST_TEST((ends[0] == ends[1]));
}

BOOST_AUTO_TEST_CASE(a_law_without_the_new_terms_is_what_it_was_to_the_last_bit) {
  Dice dice(3);
  for (int i = 0; i < 1000; ++i) {
    const double push = dice(-3, 3), spring = dice(0, 5), damping = dice(0, 5), speed = dice(-1, 1);
    const NormalForce N = normal_force<Integrator::implicit_euler>(push, spring, damping, speed);
    BOOST_TEST(N.force == std::max(0.0, push - (spring + damping) * speed));
    RigidStep::Plane p;
    p.n = {0, 0, 1};
    p.push = push, p.spring = spring, p.damping = damping;
    p.friction = p.bound = 0.5;
    p.u = {dice(-1, 1), dice(-1, 1), speed};
    const Vec3 f = PlaneForces<Integrator::implicit_euler>(1e-4).force(p, p.u);
    const Vec3 u_t = p.u - dot(p.n, p.u) * p.n;
    const Vec3 want = N.force * p.n - (0.5 / std::max(norm(u_t), 1e-4)) * u_t;
    BOOST_TEST((f == want));
  }
  // A creep below the model's stick velocity takes the way of the new terms, and must come to the same.
  for (const Integrator integrator : both) {
    std::vector<BodyStates> ends;
    for (const double creep : {0.0, 1e-9}) {
      OneBody t(block_by(integrator, 0.1, true, true));
      t.coupling = spring(500, 0.1);
      t.V() = {{0.3, 0.1, -0.4}, {1, -2, 3}};
      for (const double x : {-0.01, 0.01}) t.contacts.push_back(floor_at({x, 0.005, 0}, 1e-3));
      for (Contact& c : t.contacts) c.creep = creep;
      for (int i = 0; i < 200; ++i) t.advance(1e-3);
      ends.push_back(t.bodies);
    }
    BOOST_TEST((ends[0].X_WB[0] == ends[1].X_WB[0]));
    BOOST_TEST((ends[0].V_WB[0].v == ends[1].V_WB[0].v));
  }
}

BOOST_AUTO_TEST_CASE(two_bodies_with_such_a_contact_keep_their_momentum) {
  for (const Integrator integrator : both) {
    SystemModel m = block_by(integrator, 0.1, false);
    m.body[1] = m.body[0];
    m.body[1].mass = 0.3;
    m.count = 2;
    RigidStep step(m);
    BodyStates bodies;
    bodies.count = 2;
    bodies.V_WB[0].v = {0.1, 0.05, -0.2};
    Contact c = floor_at({}, -1e-3, 1000, 10, 0.5);
    c.inertia = 0.4, c.creep = 0.05, c.lift = 1;
    const std::vector<Pose> query(2);
    const std::vector<Contact> contacts{c};
    const std::vector<ContactPair> pairs{{0, 1}};
    const Vec3 start = 0.1 * bodies.V_WB[0].v;
    bool pushed = false;
    for (int i = 0; i < 50; ++i) {
      const StepResult r = step.advance({}, {}, {}, {query, contacts, pairs}, 1e-3, bodies);
      BOOST_REQUIRE(r.outcome == StepOutcome::converged);
      pushed = pushed || r.touching > 0;
      BOOST_REQUIRE(norm(0.1 * bodies.V_WB[0].v + 0.3 * bodies.V_WB[1].v - start) < 1e-14);
    }
    BOOST_TEST(pushed);
    BOOST_TEST(norm(bodies.V_WB[1].v) > 0.01);
  }
}

BOOST_AUTO_TEST_SUITE_END()
