// The contacts ahead: each as a query of the same sample finds it at that anchor, and none looked for that nobody
// wants.
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <numbers>

#include "framework/realtime/allocation_watch.hpp"
#include "nodes/collision/primitive.hpp"
#include "nodes/collision/sdf.hpp"
#include "nodes/physics/contact/local_contacts.hpp"
#include "tests/nodes/physics/contact/scenes.hpp"
#include "tests/support/dice.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(local_contacts_test)

using namespace tactor;
using namespace tactor::test;

namespace {

BodyStates one(const Pose& X, const Twist& V = {}) {
  BodyStates bodies;
  bodies.count = 1;
  bodies.X_WB[0] = X;
  bodies.V_WB[0] = V;
  return bodies;
}

Scene rock_on_floor() {
  Scene scene;
  scene.bodies = {shaped("floor", PlaneShape{}), mesh_body("rock", icosphere(0.05, 3), Motion::rigid)};
  return scene;
}

SdfCollision::Params coarse() {
  auto params = default_params<SdfCollision>();
  params.resolution = 24;
  return params;
}

Pose moved(const Pose& X, const Twist& V, double time) {
  return {X.p + time * V.v, from_rotation_vector(time * V.w) * X.R};
}

std::span<const std::array<Contact, LocalContacts::max_anchors>> contacts_of(const LocalContacts& local) {
  return {local.contact.data(), static_cast<std::size_t>(local.count)};
}

double distance(const Contact& a, const Contact& b) {
  return norm(a.p_TC - b.p_TC) + norm(a.p_WC - b.p_WC) + norm(a.n_W - b.n_W) + std::abs(a.distance - b.distance);
}

}  // namespace

BOOST_AUTO_TEST_CASE(at_each_anchor_contacts_are_those_of_a_query_there_and_the_base_query_is_among_them) {
  const Scene scene = rock_on_floor();
  auto params = coarse();
  params.local_contacts = LocalContacts::capacity;
  SdfCollision node(params, context_for(scene)), fresh(params, context_for(scene));
  // Falling and rolling: 3 mm in two anchor times of 15 ms.
  const Pose X{{0.01, 0, 0.0505}, from_rotation_vector({0.1, 0.2, 0})};
  const Twist V{{0.02, 0, -0.05}, {0.5, 1, 0}};
  for (const double age : {0.0, 0.004}) {
    LocalContacts local;
    node.query_ahead(one(X, V), age, local);
    BOOST_REQUIRE(local.anchors == 3);
    BOOST_TEST(local.bodies == 1);
    BOOST_REQUIRE(local.count > 10);
    BOOST_REQUIRE(local.count < LocalContacts::capacity);  // none is left out
    int met = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      const Pose there = moved(X, V, age + 0.015 * static_cast<double>(j));
      BOOST_TEST(norm(local.X_WB[j][0].p - there.p) < 1e-15);
      ContactSet set;
      fresh.query(there, set);
      BOOST_TEST(set.truncated == 0);
      // Each that the query finds is there, with its weight.
      for (const Contact& c : test::contacts_of(set)) {
        double nearest = 1, weight = 0;
        for (const auto& at : contacts_of(local)) {
          if (distance(at[j], c) < nearest) nearest = distance(at[j], c), weight = at[j].weight;
        }
        BOOST_TEST(nearest < 1e-12);
        BOOST_TEST(std::abs(weight - c.weight) < 1e-12);
        ++met;
      }
      // The others are farther than the margin, and just as true.
      for (const auto& at : contacts_of(local)) {
        const Vec3 p = transform(there, at[j].p_TC);
        BOOST_TEST(std::abs(at[j].distance - p.z) < 1e-12);
        BOOST_TEST(norm(at[j].n_W - Vec3{0, 0, 1}) < 1e-12);
      }
    }
    BOOST_TEST(met > local.count);
  }
}

BOOST_AUTO_TEST_CASE(two_moving_balls_are_looked_at_where_both_will_be) {
  Scene scene;
  scene.bodies = {ball("tool", 0.01, Motion::translation), ball("other", 0.04, Motion::rigid)};
  PrimitiveCollision node(default_params<PrimitiveCollision>(), context_for(scene));
  BodyStates bodies;
  bodies.count = 2;
  bodies.X_WB[0].p = {0.0505, 0, 0};
  bodies.V_WB[0].v = {-0.1, 0.05, 0};
  bodies.V_WB[1] = {{0, 0.02, -0.03}, {1, 2, 3}};
  LocalContacts local;
  node.query_ahead(bodies, 0.005, local);
  BOOST_REQUIRE(local.count == 1);
  BOOST_TEST(local.bodies == 2);
  BOOST_TEST(local.pair[0].body == 0);
  BOOST_TEST(local.pair[0].other == 1);
  for (std::size_t j = 0; j < 3; ++j) {
    const double t = 0.005 + 0.015 * static_cast<double>(j);
    const Vec3 a = bodies.X_WB[0].p + t * bodies.V_WB[0].v, b = t * bodies.V_WB[1].v;
    const Contact& c = local.contact[0][j];
    BOOST_TEST(std::abs(c.distance - (norm(a - b) - 0.05)) < 1e-12);
    BOOST_TEST(norm(c.n_W - (a - b) / norm(a - b)) < 1e-12);
    BOOST_TEST(norm(c.p_TC - -0.01 * c.n_W) < 1e-12);
    BOOST_TEST(c.weight == 1.0);
    BOOST_TEST(norm(local.X_WB[j][1].p - b) < 1e-15);
  }
}

namespace {

constexpr double anchor_time = 0.015;

/// A moving box, body 0, and a fixed one.
Scene two_boxes(const Vec3& tool_size, const Vec3& base_size) {
  Scene scene;
  scene.bodies = {shaped("tool", BoxShape{tool_size}, Motion::rigid), shaped("base", BoxShape{base_size})};
  return scene;
}

double push(const Contact& c) {
  return c.weight * std::max(0.0, -c.distance);
}

/// Sums of weight * depth over contacts and anchors.
struct Pushes {
  double of_tool = 0, of_base = 0;  // by contacts at samples of either body
  double by_query = 0;              // of all contacts of queries at the anchors
};

Pushes pushes_of(const Scene& scene, const Pose& X, const Twist& V, int local_contacts) {
  auto params = default_params<PrimitiveCollision>();
  params.local_contacts = local_contacts;
  PrimitiveCollision node(params, context_for(scene));
  LocalContacts local;
  node.query_ahead(one(X, V), 0, local);
  Pushes pushes;
  for (std::size_t j = 0; j < 3; ++j) {
    ContactSet set;
    node.query(moved(X, V, anchor_time * static_cast<double>(j)), set);
    BOOST_REQUIRE(set.truncated == 0);
    for (const Contact& c : test::contacts_of(set)) pushes.by_query += push(c);
    for (const auto& at : contacts_of(local)) {
      // A sample of the tool stays where it is on the tool.
      (norm(at[0].p_TC - at[2].p_TC) < 1e-12 ? pushes.of_tool : pushes.of_base) += push(at[j]);
    }
  }
  return pushes;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_sliding_contact_is_known_by_the_samples_that_stay_in_it) {
  // 0.2 mm deep. In two anchor times it goes 6 mm along the edge of 24 mm of the smaller box.
  const Vec3 small{0.024, 0.016, 0.012}, large{0.3, 0.3, 0.02};
  const Twist V{{0.2, 0, 0}, {}};
  for (const bool tool_is_small : {true, false}) {
    const Scene scene = tool_is_small ? two_boxes(small, large) : two_boxes(large, small);
    const Pose X{{tool_is_small ? 0.013 : 0.001, -0.007, 0.0158}, {}};
    const Pushes at_rest = pushes_of(scene, X, {}, LocalContacts::capacity);
    BOOST_TEST(at_rest.of_tool + at_rest.of_base == at_rest.by_query, boost::test_tools::tolerance(1e-2));
    const Pushes sliding = pushes_of(scene, X, V, LocalContacts::capacity);
    BOOST_TEST(sliding.of_tool + sliding.of_base == sliding.by_query, boost::test_tools::tolerance(1e-2));
    const double stays = tool_is_small ? sliding.of_tool : sliding.of_base;
    BOOST_TEST(stays > 0.99 * sliding.by_query);
  }
}

BOOST_AUTO_TEST_CASE(where_only_the_samples_that_leave_touch_they_push_all_the_same) {
  // An edge of the tool, along y, lies across one of the base, along x; both are 3 mm apart from sample to sample. The
  // tool slides along its own edge, past a sample of the base that stays midway between two of the tool.
  Scene scene = two_boxes({0.024, 0.024, 0.024}, {0.024, 0.024, 0.024});
  scene.bodies[1].X_WB.R = from_rotation_vector({0.25 * std::numbers::pi, 0, 0});
  const Quat tool_on_edge = from_rotation_vector({0, 0.25 * std::numbers::pi, 0});
  const double above = 0.024 * std::sqrt(2.0) - 0.0004;
  for (const double along : {0.0, 0.0015}) {
    const Pose X{{0.0015, along, above}, tool_on_edge};
    const Pushes pushes = pushes_of(scene, X, {{0, 0.1, 0}, {}}, LocalContacts::capacity);
    BOOST_TEST(pushes.by_query > 0);
    BOOST_TEST(pushes.of_tool > 0.9 * pushes.by_query);
    BOOST_TEST(pushes.of_tool + pushes.of_base < 1.1 * pushes.by_query);
  }
}

BOOST_AUTO_TEST_CASE(contacts_sent_have_weight_where_a_plate_hovers_over_a_small_box) {
  const Scene scene = two_boxes({0.1, 0.1, 0.01}, {0.024, 0.016, 0.012});
  auto params = default_params<PrimitiveCollision>();
  params.local_contacts = 24;
  PrimitiveCollision node(params, context_for(scene));
  LocalContacts local;
  node.query_ahead(one({{0, 0, 0.012}, {}}, {{0.2, 0, 0}, {}}), 0, local);
  BOOST_TEST(local.count == 24);
  double most = 0;
  for (const auto& at : contacts_of(local)) most = std::max(most, at[1].weight);
  for (const auto& at : contacts_of(local)) BOOST_TEST(at[1].weight > 0.1 * most);
}

BOOST_AUTO_TEST_CASE(of_more_than_are_sent_those_kept_have_the_wrench_of_all_at_the_middle_anchor) {
  const Scene scene = rock_on_floor();
  auto params = coarse();
  params.anchors = 1;
  params.local_contacts = LocalContacts::capacity;
  SdfCollision all(params, context_for(scene));
  params.anchors = 3;
  params.local_contacts = 12;
  SdfCollision few(params, context_for(scene));
  const Twist V{{0.02, 0, -0.05}, {0, 0, 0}};
  const Pose X{{0.01, 0, 0.0465}, from_rotation_vector({0.1, 0.2, 0})};
  LocalContacts local;
  few.query_ahead(one(X, V), 0, local);
  BOOST_TEST(local.count == 12);
  ContactSet set, kept;
  all.query(moved(X, V, 0.015), set);
  BOOST_REQUIRE(set.truncated == 0);
  BOOST_REQUIRE(set.penetrating > 12);
  kept.count = local.count;
  for (std::size_t i = 0; i < 12; ++i) {
    kept.contact[i] = local.contact[i][1];
    kept.pair[i] = local.pair[i];
    // One that stands for others does so at every anchor.
    const double share = local.contact[i][0].weight / local.contact[i][1].weight;
    BOOST_TEST(std::abs(share - local.contact[i][2].weight / local.contact[i][1].weight) < 1e-9);
  }
  const Wrench whole = spring_wrench(set), part = spring_wrench(kept);
  BOOST_TEST(norm(whole.force) > 0.1);
  BOOST_TEST(norm(whole.force - part.force) < 1e-6 * norm(whole.force));
  BOOST_TEST(norm(whole.torque - part.torque) < 1e-6 * norm(whole.force));
}

namespace {

/// A node with a device that triggers it, a result and what is expected.
template <class N>
struct Rig {
  Rig(const Scene& s, const typename N::Params& params) : scene(s), node(params, context_for(scene)) {
    node.device.configure({});
    node.bodies.configure({});
    node.expected.configure({});
  }
  void step(std::int64_t ms) {
    node.contacts.clear_pending();
    node.local.clear_pending();
    const DeviceState state;
    const Time now{ms * 1'000'000};
    node.device.push({now, now, 0}, &state);
    StepContext context(now);
    node.step(context);
  }
  static void push(Input<BodyStates>& in, std::int64_t valid_ms, const BodyStates& bodies) {
    in.push({Time{valid_ms * 1'000'000}, Time{valid_ms * 1'000'000}, 0}, &bodies);
  }
  Scene scene;
  N node;
};

}  // namespace

BOOST_AUTO_TEST_CASE(a_query_is_made_where_the_bodies_are_expected_and_the_anchors_go_on_from_its_time) {
  Rig<SdfCollision> rig(rock_on_floor(), coarse());
  SdfCollision apart(coarse(), context_for(rig.scene));
  const BodyStates then = one({{0, 0, 0.06}, {}}), by_now = one({{0.001, 0, 0.0495}, {}}, {{0, 0, -0.1}, {}});
  rig.push(rig.node.bodies, 10, then);
  rig.step(30);
  BOOST_TEST(sent(rig.node.contacts).bodies.X_WB[0].p.z == 0.06);
  rig.push(rig.node.expected, 28, by_now);
  rig.step(30);
  ContactSet set;
  apart.query(by_now, set);
  BOOST_REQUIRE(sent(rig.node.contacts).count == set.count);
  BOOST_TEST(set.penetrating > 0);
  for (std::size_t i = 0; i < static_cast<std::size_t>(set.count); ++i) {
    BOOST_TEST(distance(sent(rig.node.contacts).contact[i], set.contact[i]) == 0.0);
  }
  // 2 ms after the time of what was expected.
  BOOST_TEST(std::abs(sent(rig.node.local).X_WB[0][0].p.z - (0.0495 - 0.1 * 0.002)) < 1e-15);
  BOOST_TEST(std::abs(sent(rig.node.local).X_WB[2][0].p.z - (0.0495 - 0.1 * 0.032)) < 1e-15);
  BOOST_TEST(rig.node.local.pending_valid(0).ns == 30'000'000);
  // What is looked for ahead changes nothing of the query, and is left out where nobody reads it.
  rig.node.local.set_wanted(false);
  rig.step(30);
  BOOST_TEST(rig.node.local.pending() == 0U);
  BOOST_REQUIRE(sent(rig.node.contacts).count == set.count);
  BodyStates two = by_now;
  two.count = 2;
  rig.push(rig.node.expected, 29, two);
  BOOST_CHECK_EXCEPTION(rig.step(31), InputError, [](const InputError& e) {
    return std::string(e.what()).find("the input expected has 2 moving bodies; the scene has 1") != std::string::npos;
  });
}

BOOST_AUTO_TEST_CASE(looking_ahead_allocates_nothing_once_it_has_met_the_most,
                     *boost::unit_test::precondition(tactor::test::heap_is_counted)) {
  const Scene scene = rock_on_floor();
  SdfCollision node(coarse(), context_for(scene));
  LocalContacts local;
  const auto look = [&](int i) {
    const Twist V{{0.02, 0, -0.05 * std::cos(0.1 * i)}, {0.5, 1, 0}};
    node.query_ahead(one({{0, 0, 0.0495 - 0.001 * std::sin(0.1 * i)}, {}}, V), 0.003, local);
  };
  for (int i = 0; i < 70; ++i) look(i);
  const std::int64_t before = thread_heap_calls();
  for (int i = 0; i < 70; ++i) look(i);
  const std::int64_t calls = thread_heap_calls() - before;
  BOOST_TEST(calls == 0);
}

BOOST_AUTO_TEST_SUITE_END()
