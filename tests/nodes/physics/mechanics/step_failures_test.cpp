// Whatever comes in, a step gives a finite state, says how it was found, and makes no energy when it gives up.
#include <boost/test/unit_test.hpp>

#include <limits>
#include <random>

#include "tests/nodes/physics/mechanics/one_body.hpp"

BOOST_AUTO_TEST_SUITE(step_failures_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

bool sane(const BodyStates& s) {
  const Pose& X = s.X_WB[0];
  return is_finite(X.p) && is_finite(s.V_WB[0].v) && is_finite(s.V_WB[0].w) && std::isfinite(X.R.w) &&
         is_finite(Vec3{X.R.x, X.R.y, X.R.z});
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_contact_that_is_not_finite_or_negative_is_left_out) {
  const Contact good = floor_at({}, -0.001);
  std::vector<Contact> bad(15, good);
  bad[0].distance = not_a_number;
  bad[1].distance = -infinity;
  bad[2].n_W.x = not_a_number;
  bad[3].p_TC.z = infinity;
  bad[4].stiffness = not_a_number;
  bad[5].stiffness = -1;
  bad[6].damping = infinity;
  bad[7].friction = not_a_number;
  bad[8].weight = -1;
  bad[9].friction = -0.1;
  bad[10].inertia = -1;
  bad[11].inertia = infinity;
  bad[12].creep = not_a_number;
  bad[13].creep = infinity;
  bad[14].lift = 1.01;
  for (const bool rotates : {false, true}) {
    OneBody alone(block(0.1, rotates)), crowded(block(0.1, rotates));
    alone.contacts = {good};
    crowded.contacts = bad;
    crowded.contacts.push_back(good);
    alone.advance(1e-3);
    const StepResult r = crowded.advance(1e-3);
    BOOST_TEST((r.outcome == StepOutcome::converged));
    BOOST_TEST(r.left_out == 15);
    BOOST_TEST(r.touching == 1);
    BOOST_TEST((alone.X() == crowded.X()));
  }
}

BOOST_AUTO_TEST_CASE(a_contact_between_bodies_that_do_not_exist_is_left_out) {
  RigidStep step(block(0.1));
  BodyStates bodies;
  const std::vector<Contact> contacts(5, floor_at({}, -0.001));
  const std::vector<ContactPair> pairs{{1, -1}, {-1, -1}, {0, 0}, {0, 1}, {0, -2}};
  const Pose query;
  const StepResult r = step.advance({}, {}, {}, {std::span(&query, 1), contacts, pairs}, 1e-3, bodies);
  BOOST_TEST(r.left_out == 5);
  BOOST_TEST(r.touching == 0);
}

BOOST_AUTO_TEST_CASE(too_few_iterations_take_a_damped_step_that_makes_no_energy) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  int damped = 0;
  for (int scene = 0; scene < 200; ++scene) {
    SystemModel m = block(0.1, scene % 2 == 1);
    m.iterations = 1;
    OneBody t(m);
    t.coupling = spring(500, 0.1);
    for (int i = 0; i < 12; ++i) {
      Contact c = floor_at({0.02 * unit(random), 0.02 * unit(random), -0.01}, 0.004 * unit(random), 3e4, 5, 0.5);
      t.contacts.push_back(c);
    }
    t.V() = {{unit(random), unit(random), 2 * unit(random)}, {}};
    double last = t.energy();
    for (int i = 0; i < 20; ++i) {
      const StepResult r = t.advance(1e-3);
      BOOST_REQUIRE(sane(t.bodies));
      const double now = t.energy();
      if (r.outcome != StepOutcome::converged) BOOST_REQUIRE(now <= last + 1e-12);
      damped += r.outcome == StepOutcome::damped ? 1 : 0;
      last = now;
    }
  }
  BOOST_TEST(damped > 100);
}

BOOST_AUTO_TEST_CASE(a_system_without_solution_keeps_the_pose_at_rest) {
  OneBody t(block(0.1));
  t.coupling.massless = 1;
  // Nothing holds it sideways.
  t.contacts = {floor_at({}, -0.001, 2000, 0, 0)};
  t.X().p = t.query.p = {1, 2, 3};
  t.V().v = {1, 1, 1};
  BOOST_TEST((t.advance(1e-3).outcome == StepOutcome::stopped));
  BOOST_TEST(norm(t.X().p - Vec3{1, 2, 3}) == 0.0);
  BOOST_TEST(norm(t.V().v) == 0.0);
}

BOOST_AUTO_TEST_CASE(absurd_numbers_never_make_a_state_that_is_not_finite) {
  const std::vector<double> odd{0, 1e-300, 1e-30, 1e-9, 1, 1e9, 1e30, 1e150, 1e300};
  int stopped = 0;
  for (const bool rotates : {false, true}) {
    for (const double k : odd) {
      for (const double mass : {1e-300, 1e-9, 1.0, 1e30}) {
        for (const double inertia : {0.0, 1e-30, 1.0}) {
          SystemModel m = block(mass, rotates);
          m.body[0].inertia_B = inertia * Eigen::Matrix3d::Identity();
          OneBody t(m);
          t.coupling = {.k_t = k, .b_t = 1, .k_r = k, .b_r = 0};
          t.contacts = {floor_at({0.01, 0, 0}, -0.001, k, k, 0.5), floor_at({0, 0.01, 0}, -1e3, 1e6, 0, 1)};
          t.V() = {{1, 2, -1e3}, rotates ? Vec3{1e4, -1e6, 3} : Vec3{}};
          DeviceState d;
          d.X_WD.p = {1, 0, 0};
          for (int i = 0; i < 3; ++i) {
            stopped += t.advance(1e-3, d).outcome == StepOutcome::stopped ? 1 : 0;
            BOOST_REQUIRE(sane(t.bodies));
          }
        }
      }
    }
  }
  BOOST_TEST(stopped > 0);  // some of them cannot be solved
}

BOOST_AUTO_TEST_CASE(a_mesh_without_thickness_has_no_inertia_and_does_not_turn_to_nothing) {
  SystemModel m = block(0.1, true);
  m.body[0].inertia_B = Eigen::Vector3d(0, 0, 1e-5).asDiagonal();
  OneBody t(m);
  t.coupling = spring(500, 0.1);
  t.contacts = {floor_at({0.01, 0, 0}, -0.001)};
  for (int i = 0; i < 100; ++i) {
    t.advance(1e-3);
    BOOST_REQUIRE(sane(t.bodies));
  }
}

BOOST_AUTO_TEST_CASE(random_hard_scenes_always_converge) {
  std::mt19937_64 random(7);
  const auto between = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  const auto spread = [&](double a, double b) { return std::exp(between(std::log(a), std::log(b))); };
  int most = 0;
  for (int scene = 0; scene < 600; ++scene) {
    const double m = spread(1e-3, 10);
    const bool rotates = scene % 3 != 0;
    SystemModel model = block(m, rotates);
    const double a = spread(0.005, 0.1), b = spread(0.005, 0.1), c = spread(0.005, 0.1);
    model.integrator = scene / 12 % 2 == 0 ? Integrator::implicit_euler : Integrator::midpoint;
    model.body[0].inertia_B = m / 3 * Eigen::Vector3d(b * b + c * c, a * a + c * c, a * a + b * b).asDiagonal();
    OneBody t(model);
    t.coupling = spring(spread(1, 1e5), m, between(0, 1.5));
    const double h = spread(1e-4, 2e-2), k = spread(1e2, 1e6), mu = between(0, 1.2);
    const int count = static_cast<int>(spread(1, 129));
    for (int i = 0; i < count; ++i) {
      Contact contact =
          floor_at({between(-a, a), between(-b, b), between(-c, c)}, between(-0.01, 0.005), k, spread(0.01, 20), mu);
      if (scene % 4 == 1) {  // two walls without clearance
        contact.n_W = {i % 2 == 0 ? 1.0 : -1.0, 0, 0};
        contact.distance = 0;
      } else if (scene % 4 == 2) {  // a hole without clearance
        const double angle = between(0, 6.28);
        contact.n_W = {std::cos(angle), std::sin(angle), 0};
        contact.p_TC = {-a * std::cos(angle), -a * std::sin(angle), contact.p_TC.z};
        contact.distance = between(-1e-4, 0);
      } else if (scene % 4 == 3) {
        const Vec3 n{between(-1, 1), between(-1, 1), between(-1, 1)};
        contact.n_W = n / norm(n);
      }
      contact.weight = spread(0.01, 1);
      t.contacts.push_back(contact);
    }
    t.V() = {{between(-3, 3), between(-3, 3), between(-3, 3)}, {}};
    if (rotates) t.V().w = {between(-20, 20), between(-20, 20), between(-20, 20)};
    for (int i = 0; i < 30; ++i) {
      DeviceState d;
      d.X_WD.p = {0.03 * std::sin(0.2 * i), 0.02 * std::sin(0.13 * i), -0.02 * std::sin(0.1 * i)};
      if (rotates) d.X_WD.R = from_rotation_vector({0.4 * std::sin(0.05 * i), 0, 0.3 * std::sin(0.11 * i)});
      const StepResult r = t.advance(h, d);
      BOOST_REQUIRE((r.outcome == StepOutcome::converged));
      BOOST_REQUIRE(sane(t.bodies));
      most = std::max(most, r.iterations);
    }
  }
  BOOST_TEST(most > 3);  // they were not easy
}

BOOST_AUTO_TEST_SUITE_END()
