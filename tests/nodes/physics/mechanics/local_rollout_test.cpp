// Contacts between and beside their anchors against known surfaces, the Jacobian against the force that is balanced,
// and models that are not of the scene.
#include <boost/test/unit_test.hpp>

#include <functional>
#include <limits>

#include "framework/realtime/allocation_watch.hpp"
#include "nodes/physics/contact/local_contacts.hpp"
#include "nodes/physics/mechanics/coupling_wrench.hpp"
#include "nodes/physics/mechanics/local_model.hpp"
#include "nodes/physics/mechanics/local_rollout.hpp"
#include "tests/nodes/physics/mechanics/local_contacts.hpp"
#include "tests/support/dice.hpp"

BOOST_AUTO_TEST_SUITE(local_rollout_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

constexpr double radius = 0.01;  // m, of the ball
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

SystemModel ball_model(bool rotates = false, int count = 1) {
  SystemModel model;
  model.count = count;
  for (int i = 0; i < count; ++i) {
    BodyModel& body = model.body[static_cast<std::size_t>(i)];
    body.mass = 0.1;
    body.inertia_B = 4e-6 * Eigen::Matrix3d::Identity();
    body.rotates = rotates;
  }
  return model;
}

LocalModel at_rest(const BodyStates& bodies, const LocalContacts& contacts, const CouplingParameters& coupling,
                   const Vec3& handle) {
  LocalModel model;
  model.device.X_WD.p = handle;
  model.bodies = bodies;
  model.coupling = coupling;
  model.contacts = contacts;
  return model;
}

const CouplingParameters soft{.k_t = 500, .b_t = 14, .k_r = 0.5, .b_r = 0.005, .force_max = 8, .torque_max = 0.3};

/// The most that a quadratic of |x| is off by, s away from where it was taken, nowhere nearer to the centre than
/// `near`: the third derivative along a unit s is 3 cos(a) sin(a)^2 / |x|^2, at most 1.155 / |x|^2.
double quadratic_error(double s, double near) {
  return 2 / std::sqrt(3.0) / 6 * s * s * s / (near * near);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_plane_is_known_everywhere_however_the_anchors_lie) {
  Dice dice(1);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3 n = rotate(from_rotation_vector(dice.in_cube(3)), {1, 0, 0});
    std::vector<BodyStates> anchors;
    for (int j = 0; j <= trial % 3; ++j) anchors.push_back(one_body(dice.in_cube(0.05)));
    const LocalContacts local = around(anchors, {}, [&](const BodyStates& bodies) {
      return contact_of(plane_at(bodies.X_WB[0].p, n, 0.003, radius), bodies.X_WB[0], radius);
    });
    const BodyStates now = one_body(dice.in_cube(0.1));
    const Contact c = contact_now(local, 0, now),
                  truth = contact_of(plane_at(now.X_WB[0].p, n, 0.003, radius), now.X_WB[0], radius);
    BOOST_TEST(std::abs(c.distance - truth.distance) < 1e-15);
    BOOST_TEST(norm(c.n_W - n) < 1e-15);
    BOOST_TEST(norm(c.p_TC - truth.p_TC) < 1e-15);
    BOOST_TEST(c.weight == 1.0, tt::tolerance(1e-15));
    BOOST_TEST(c.stiffness == 1000.0);
  }
}

BOOST_AUTO_TEST_CASE(a_ball_on_a_ball_and_one_in_a_hollow_are_known_to_the_error_of_the_quadratics) {
  Dice dice(2);
  for (const bool hollow : {false, true}) {
    const double R = hollow ? 0.08 : 0.04, at = hollow ? R - radius : R + radius;
    const auto query = [&](const BodyStates& bodies) {
      return contact_of(ball_at(bodies.X_WB[0].p, {}, R, radius, hollow), bodies.X_WB[0], radius);
    };
    double worst = 0, worst_plane = 0;
    for (int trial = 0; trial < 500; ++trial) {
      const Vec3 start = rotate(from_rotation_vector(dice.in_cube(3)), {at - 5e-4, 0, 0}), step = dice.in_cube(0.004);
      std::vector<BodyStates> anchors{one_body(start), one_body(start + step), one_body(start + 2 * step)};
      const LocalContacts local = around(anchors, {}, query);
      // Anywhere on the way and a little beside it.
      const BodyStates now = one_body(start + dice(-0.5, 2.5) * step + dice.in_cube(5e-4));
      const Contact c = contact_now(local, 0, now), truth = query(now);
      double bound = 0;
      for (const BodyStates& a : anchors) bound = std::max(bound, norm(now.X_WB[0].p - a.X_WB[0].p));
      const double near = at - 0.025;
      worst = std::max(worst, std::abs(c.distance - truth.distance));
      worst_plane = std::max(
          worst_plane,
          std::abs(
              truth.distance -
              plane_now({anchors[0].X_WB, {&local.contact[0][0], 1}, {local.pair.data(), 1}}, 0, now.X_WB).distance));
      BOOST_TEST(std::abs(c.distance - truth.distance) <= quadratic_error(bound, near));
      BOOST_TEST(norm(c.n_W - truth.n_W) <= 6 * bound * bound / (near * near));
      // Exactly at an anchor the others have a part in ten thousand, or less, of a say.
      const Contact there = contact_now(local, 0, anchors[1]);
      const double others = 2 * 1e-10 / std::max(dot(step, step), 1e-10);
      BOOST_TEST(std::abs(there.distance - query(anchors[1]).distance) <=
                 others * quadratic_error(norm(step), near) + 1e-15);
    }
    // A plane misses far more, so the bound above tells something.
    BOOST_TEST(worst < 0.1 * worst_plane);
  }
}

BOOST_AUTO_TEST_CASE(a_normal_turns_by_a_third_of_a_radian_at_most) {
  // The corner of a rounding of 0.1 mm, met 5 mm away: its curvature is worth nothing there.
  BodyStates start = one_body({1e-4 + radius, 0, 0});
  LocalContacts local = around({start}, {}, [&](const BodyStates& bodies) {
    Contact c = contact_of(plane_at(bodies.X_WB[0].p, {1, 0, 0}, 0, radius), bodies.X_WB[0], radius);
    c.H_W = {0, 0, 0, 1e4, 0, 1e4};
    return c;
  });
  const Contact c = contact_now(local, 0, one_body({1e-4 + radius, 0.005, 0}));
  BOOST_TEST(c.distance == 1e-4 + 0.5 * 0.3 * 0.005, tt::tolerance(1e-9));
  BOOST_TEST(std::atan2(c.n_W.y, c.n_W.x) == std::atan(0.3), tt::tolerance(1e-9));
  local.contact[0][0].H_W[3] = std::numeric_limits<double>::infinity();
  const Contact flat = contact_now(local, 0, one_body({1e-4 + radius, 0.005, 0}));
  BOOST_TEST(flat.distance == 1e-4, tt::tolerance(1e-9));
  BOOST_TEST((flat.n_W == Vec3{1, 0, 0}));
}

namespace {

/// Two balls that both move, and the anchors of their contact.
struct TwoBalls {
  explicit TwoBalls(Dice& dice) {
    BodyStates bodies;
    bodies.count = 2;
    bodies.X_WB[0].p = dice.in_cube(0.002) + Vec3{0.0395 + radius, 0, 0};
    bodies.X_WB[1] = dice.pose(0.002, 3);
    for (int j = 0; j < 3; ++j) {
      anchors.push_back(bodies);
      bodies.X_WB[0].p += dice.in_cube(0.003);
      bodies.X_WB[1].p += dice.in_cube(0.003);
      bodies.X_WB[1].R = from_rotation_vector(dice.in_cube(0.05)) * bodies.X_WB[1].R;
    }
    now = anchors[1];
    now.X_WB[0].p += dice.in_cube(0.001);
    now.X_WB[1] = {now.X_WB[1].p + dice.in_cube(0.001), from_rotation_vector(dice.in_cube(0.1)) * now.X_WB[1].R};
    local = around(anchors, {0, 1}, query);
  }
  static Contact query(const BodyStates& bodies) {
    return contact_of(ball_at(bodies.X_WB[0].p, bodies.X_WB[1].p, 0.04, radius, false), bodies.X_WB[0], radius);
  }
  /// How far the one ball's centre is from where it was, seen from the other.
  double moved(const BodyStates& a) const {
    return norm(transform(inverse(now.X_WB[1]), now.X_WB[0].p) - transform(inverse(a.X_WB[1]), a.X_WB[0].p));
  }
  std::vector<BodyStates> anchors;
  BodyStates now;
  LocalContacts local;
};

std::array<double, 6> turned(const std::array<double, 6>& H, const Quat& R) {
  Eigen::Matrix3d M, Q;
  M << H[0], H[1], H[2], H[1], H[3], H[4], H[2], H[4], H[5];
  for (int i = 0; i < 3; ++i) {
    const Vec3 e{i == 0 ? 1.0 : 0, i == 1 ? 1.0 : 0, i == 2 ? 1.0 : 0}, c = rotate(R, e);
    Q.col(i) << c.x, c.y, c.z;
  }
  M = (Q * M * Q.transpose()).eval();
  return {M(0, 0), M(0, 1), M(0, 2), M(1, 1), M(1, 2), M(2, 2)};
}

}  // namespace

BOOST_AUTO_TEST_CASE(two_moving_balls_are_known_by_the_way_of_the_one_seen_from_the_other) {
  Dice dice(3);
  for (int trial = 0; trial < 300; ++trial) {
    const TwoBalls two(dice);
    double bound = 0, turn = 0;
    for (const BodyStates& a : two.anchors) {
      bound = std::max(bound, two.moved(a));
      turn = std::max(turn, norm(to_rotation_vector(two.now.X_WB[1].R * inverse(a.X_WB[1].R))));
    }
    BOOST_REQUIRE(bound < 0.02);
    const double off = contact_now(two.local, 0, two.now).distance - TwoBalls::query(two.now).distance;
    // Seen from the ball that turns the other one turns too, and takes its contact point along: off the surface by
    // r a^2 / 2, and along it by r a, which the curvature takes for a way of the centre.
    const double rolled = radius * turn;
    BOOST_TEST(std::abs(off) <= quadratic_error(bound, 0.03) + rolled * (turn / 2 + (bound + rolled / 2) / 0.03));
  }
}

BOOST_AUTO_TEST_CASE(where_the_world_lies_changes_nothing) {
  Dice dice(4);
  for (int trial = 0; trial < 100; ++trial) {
    const TwoBalls two(dice);
    const Pose G = dice.pose(1, 3);
    TwoBalls moved = two;
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t b = 0; b < 2; ++b) moved.local.X_WB[j][b] = G * two.local.X_WB[j][b];
      Contact& c = moved.local.contact[0][j];
      c.n_W = rotate(G.R, c.n_W);
      c.p_WC = transform(G, c.p_WC);
      c.H_W = turned(c.H_W, G.R);
    }
    for (std::size_t b = 0; b < 2; ++b) moved.now.X_WB[b] = G * two.now.X_WB[b];
    const Contact a = contact_now(two.local, 0, two.now), b = contact_now(moved.local, 0, moved.now);
    BOOST_TEST(std::abs(a.distance - b.distance) < 1e-14);
    BOOST_TEST(norm(rotate(G.R, a.n_W) - b.n_W) < 1e-13);
    BOOST_TEST(norm(a.p_TC - b.p_TC) < 1e-14);
  }
}

BOOST_AUTO_TEST_CASE(
    on_a_wall_the_jacobian_is_two_springs_in_series_whatever_the_lever_of_a_body_that_does_not_rotate) {
  for (const double k : {200.0, 1000.0, 50'000.0}) {
    LocalRollout rollout(ball_model());
    LocalContacts wall = wall_around({{0.0099, 0, 0}}, k);
    wall.contact[0][0].p_TC += Vec3{0, 0.05, -0.02};
    wall.contact[0][0].weight = 0.5;
    BOOST_REQUIRE(rollout.restart(at_rest(one_body({0.0099, 0, 0}), wall, soft, {0, 0, 0})));
    const Eigen::Matrix<double, 6, 6> J = rollout.jacobian();
    BOOST_TEST(J(0, 0) == -soft.k_t * 0.5 * k / (soft.k_t + 0.5 * k), tt::tolerance(1e-9));
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) {
        if (i + j > 0) BOOST_TEST(std::abs(J(i, j)) < 1e-6);
      }
    }
    // Not touching: the tool follows the handle.
    BOOST_REQUIRE(rollout.restart(at_rest(one_body({0.0101, 0, 0}), wall, soft, {0, 0, 0})));
    BOOST_TEST(rollout.jacobian().norm() < 1e-6);
    // What is not finite is not a contact.
    wall.contact[0][0].H_W[3] = not_a_number;
    wall.contact[0][0].n_W.y = not_a_number;
    BOOST_REQUIRE(rollout.restart(at_rest(one_body({0.0099, 0, 0}), wall, soft, {0, 0, 0})));
    BOOST_TEST(rollout.jacobian().norm() < 1e-6);
  }
}

BOOST_AUTO_TEST_CASE(the_jacobian_is_how_the_balanced_force_changes_with_the_handle) {
  // A block on a floor, with a wall beside: a tool without mass goes where the springs balance, step by step.
  LocalContacts local;
  local.anchors = local.bodies = 1;
  const auto add = [&](const Vec3& p_TC, const Vec3& n, double k) {
    Contact c{.p_TC = p_TC, .p_WC = p_TC, .n_W = n, .distance = 0, .weight = 1, .stiffness = k};
    local.contact[static_cast<std::size_t>(local.count++)][0] = c;
  };
  add({0.02, 0.03, -0.01}, {0, 0, 1}, 900);
  add({-0.02, 0.03, -0.01}, {0, 0, 1}, 1200);
  add({0.02, -0.03, -0.01}, {0, 0, 1}, 700);
  add({-0.02, 0.01, 0.005}, {1, 0, 0}, 1500);
  const CouplingParameters coupling{.k_t = 500, .k_r = 0.5, .force_max = 100, .torque_max = 10, .massless = 1};
  LocalRollout rollout(ball_model(true));
  Time now;
  const auto balanced = [&](const Vec3& p, const Vec3& turn) {
    Stamped<DeviceState> s;
    s.value.X_WD = {p, from_rotation_vector(turn)};
    for (int i = 0; i < 300; ++i) {
      now = now + Duration{1'000'000};
      s.stamp.valid = now;
      BOOST_REQUIRE(rollout.advance(s));
    }
    return coupling_wrench(coupling, rollout.state(), true);
  };
  const Vec3 p{-2e-4, 0, -4e-4};
  BOOST_REQUIRE(rollout.restart(at_rest(one_body({}), local, coupling, {})));
  balanced(p, {});
  const Eigen::Matrix<double, 6, 6> J = rollout.jacobian();
  Eigen::Matrix<double, 6, 6> measured;
  for (int i = 0; i < 6; ++i) {
    const double d = i < 3 ? 1e-6 : 1e-5;
    Vec3 along;
    along[i % 3] = d;
    const auto force = [&](double sign) { return i < 3 ? balanced(p + sign * along, {}) : balanced(p, sign * along); };
    const Wrench change = 0.5 / d * (force(1) - force(-1));
    measured.col(i) << change.force.x, change.force.y, change.force.z, change.torque.x, change.torque.y,
        change.torque.z;
  }
  // All four push. The forces of 0.2 N at levers of 3 cm turn with the block, which the Jacobian leaves out: 0.01 N
  // m/rad.
  const Eigen::Matrix<double, 6, 6> off = (J - measured).cwiseAbs();
  BOOST_TEST(off.topLeftCorner(3, 3).maxCoeff() < 0.5);
  BOOST_TEST(off.topRightCorner(3, 3).maxCoeff() < 0.02);
  BOOST_TEST(off.bottomLeftCorner(3, 3).maxCoeff() < 0.02);
  BOOST_TEST(off.bottomRightCorner(3, 3).maxCoeff() < 0.005);
  BOOST_TEST((J - J.transpose()).norm() < 1e-9);
}

BOOST_AUTO_TEST_CASE(a_step_against_exact_planes_is_that_of_a_query_made_anew) {
  Dice dice(5);
  LocalRollout rollout(ball_model());
  RigidStep step(ball_model());
  const LocalContacts wall = wall_around({{0.009, 0, 0}, {0.02, 0.01, 0}, {0.003, 0, 0.01}}, 3000, 4, 0.4);
  BodyStates bodies = one_body({0.0098, 0, 0}, {-0.1, 0.05, 0});
  LocalModel model = at_rest(bodies, wall, soft, {0.0098, 0, 0});
  BOOST_REQUIRE(rollout.restart(model));
  DeviceState before = model.device;
  for (int k = 1; k <= 200; ++k) {
    Stamped<DeviceState> s;
    s.stamp.valid = Time{1'000'000LL * k};
    s.value.X_WD.p = {0.005 + 0.008 * std::sin(0.05 * k), 0.002 * std::sin(0.02 * k), 0};
    s.value.V_WD.v = {0.4 * std::cos(0.05 * k), 0.04 * std::cos(0.02 * k), 0};
    const Contact c =
        contact_of(plane_at(bodies.X_WB[0].p, {1, 0, 0}, 0, radius), bodies.X_WB[0], radius, 3000, 4, 0.4);
    const ContactPair pair;
    const std::vector<Pose> query{bodies.X_WB[0]};
    const StepResult result = step.advance(soft, before, s.value, {query, {&c, 1}, {&pair, 1}}, 0.001, bodies);
    before = s.value;
    const Vec3 v = rollout.model().bodies.V_WB[0].v;
    BOOST_REQUIRE(rollout.advance(s));
    BOOST_REQUIRE_SMALL(norm(rollout.state().X_WT.p - bodies.X_WB[0].p), 1e-13);
    BOOST_REQUIRE_SMALL(norm(rollout.state().V_WT.v - bodies.V_WB[0].v), 1e-10);
    BOOST_REQUIRE_SMALL(norm(rollout.state().contact_T_W.force - result.contact_T_W.force), 1e-8);
    BOOST_REQUIRE(rollout.state().contacts == result.touching);
    BOOST_REQUIRE_SMALL(norm(rollout.acceleration().v - 1000 * (bodies.V_WB[0].v - v)), 1e-6);
    // A sample that is not later moves nothing.
    BOOST_REQUIRE(rollout.advance(s));
    BOOST_REQUIRE_SMALL(norm(rollout.state().X_WT.p - bodies.X_WB[0].p), 1e-13);
  }
}

BOOST_AUTO_TEST_CASE(models_of_another_scene_or_not_finite_are_refused_and_change_nothing) {
  LocalRollout rollout(ball_model(false, 2));
  BodyStates two;
  two.count = 2;
  two.X_WB[0].p = {0.0099, 0, 0};
  two.X_WB[1].p = {0.5, 0, 0};
  std::vector<BodyStates> anchors{two, two};
  const LocalModel good = at_rest(two, around(anchors, {0, 1}, TwoBalls::query), soft, {0.01, 0, 0});
  BOOST_REQUIRE(rollout.restart(good));
  const std::vector<std::function<void(LocalModel&)>> spoil{
      [](LocalModel& m) { m.bodies.count = 1; },
      [](LocalModel& m) { m.bodies.count = 3; },
      [](LocalModel& m) { m.bodies.X_WB[1].p.y = not_a_number; },
      [](LocalModel& m) { m.bodies.V_WB[0].v.z = std::numeric_limits<double>::infinity(); },
      [](LocalModel& m) { m.bodies.V_WB[1].w.z = not_a_number; },
      [](LocalModel& m) {
        m.bodies.X_WB[0].R = {0, 0, 0, 0};
      },
      [](LocalModel& m) { m.bodies.X_WB[0].R.x = not_a_number; },
      [](LocalModel& m) { m.device.X_WD.p.x = not_a_number; },
      [](LocalModel& m) { m.device.V_WD.v.x = not_a_number; },
      [](LocalModel& m) {
        m.device.X_WD.R = {0, 0, 0, 0};
      },
      [](LocalModel& m) { m.coupling.k_t = not_a_number; },
      [](LocalModel& m) { m.coupling.b_r = -1; },
      [](LocalModel& m) { m.coupling.force_max = not_a_number; },
      [](LocalModel& m) { m.contacts.count = -1; },
      [](LocalModel& m) { m.contacts.count = LocalContacts::capacity + 1; },
      [](LocalModel& m) { m.contacts.bodies = 1; },
      [](LocalModel& m) { m.contacts.anchors = 0; },
      [](LocalModel& m) { m.contacts.anchors = LocalContacts::max_anchors + 1; },
      [](LocalModel& m) { m.contacts.pair[0].body = 2; },
      [](LocalModel& m) { m.contacts.pair[0].body = -1; },
      [](LocalModel& m) { m.contacts.pair[0].other = 2; },
      [](LocalModel& m) { m.contacts.pair[0].other = -2; }};
  for (std::size_t i = 0; i < spoil.size(); ++i) {
    LocalModel bad = good;
    bad.time = Time{5};
    spoil[i](bad);
    BOOST_TEST(!rollout.restart(bad), "kind " << i);
    BOOST_TEST(rollout.model().time.ns == 0, "kind " << i);
  }
  // What lies beyond the counts does not matter, nor do anchors where there are no contacts.
  LocalModel odd = good;
  odd.contacts.pair[1].body = 77;
  odd.bodies.X_WB[2].p.x = not_a_number;
  BOOST_TEST(rollout.restart(odd));
  odd.contacts = {};
  BOOST_TEST(rollout.restart(odd));
  BOOST_TEST(rollout.distance_from_known() == 0.0);
}

BOOST_AUTO_TEST_CASE(contacts_of_numbers_that_are_none_are_left_out_and_no_state_is_ever_made_that_is_not_finite) {
  Dice dice(6);
  const double poison[] = {not_a_number, std::numeric_limits<double>::infinity(), 1e200, -1e308, 0};
  for (int trial = 0; trial < 2000; ++trial) {
    LocalRollout rollout(ball_model(true));
    LocalContacts wall = wall_around({{0.0099, 0, 0}, {0.0098, 0, 0}, {0.0097, 0, 0}}, 3000, 4, 0.4);
    const auto words = reinterpret_cast<double*>(wall.contact[0].data());
    constexpr int numbers = 3 * sizeof(Contact) / sizeof(double);
    for (int k = 0; k < 3; ++k) words[static_cast<int>(dice(0, numbers))] = poison[trial % 5];
    if (trial % 7 == 0) wall.X_WB[1][0].p.x = poison[trial % 5];
    if (trial % 11 == 0) wall.X_WB[1][0].R = {0, 0, 0, 0};
    BOOST_REQUIRE(rollout.restart(at_rest(one_body({0.0099, 0, 0}), wall, soft, {0.0099, 0, 0})));
    const std::int64_t before = thread_heap_calls();
    for (int k = 1; k <= 5; ++k) {
      Stamped<DeviceState> s;
      s.stamp.valid = Time{1'000'000LL * k};
      s.value.X_WD.p = {0.0099 - 1e-4 * k, 0, 0};
      rollout.advance(s);
      const PhysicsState state = rollout.state();
      BOOST_REQUIRE((is_finite(state.X_WT.p) && is_finite(state.V_WT.v) && is_finite(state.contact_T_W)));
      BOOST_REQUIRE(is_finite(rollout.acceleration().v));
    }
    BOOST_REQUIRE(rollout.jacobian().allFinite());
    const std::int64_t calls = thread_heap_calls() - before;
    BOOST_REQUIRE(calls == 0);
  }
}

BOOST_AUTO_TEST_SUITE_END()
