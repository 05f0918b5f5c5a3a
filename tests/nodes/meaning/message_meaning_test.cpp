// The nodes do what the docs of the message types say of direction, sign, point of reference, order and stamps.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "framework/core/messages.hpp"
#include "framework/core/segment.hpp"
#include "nodes/collision/primitive.hpp"
#include "nodes/coupling/static.hpp"
#include "nodes/dynamics/rigid.hpp"
#include "nodes/physics/contact/local_contacts.hpp"
#include "nodes/prediction/linear.hpp"
#include "tests/nodes/dynamics/node_rig.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(message_meaning_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

const Field& field_of(const std::vector<Field>& fields, const std::string& path) {
  const std::size_t dot = path.find('.');
  for (const Field& field : fields) {
    if (field.name != path.substr(0, dot)) continue;
    return dot == std::string::npos ? field : field_of(field.fields, path.substr(dot + 1));
  }
  throw std::runtime_error("no field " + path);
}

/// The doc of a field; empty path: of the type.
template <class T>
std::string doc_of(const std::string& path = "") {
  const MessageType& type = message_type<T>();
  return path.empty() ? type.doc : field_of(type.fields, path).doc;
}

/// Demands that the doc has these words, which the test then holds against the code.
template <class T>
void says(const std::string& path, const std::string& words) {
  BOOST_TEST(doc_of<T>(path).find(words) != std::string::npos,
             message_type<T>().name << "." << path << " says: " << doc_of<T>(path));
}

Body shaped(const std::string& name, const Shape& shape, const Vec3& p_WB, Motion motion = Motion::fixed) {
  Body body;
  body.name = name;
  body.shape = shape;
  body.motion = motion;
  body.X_WB.p = p_WB;
  return body;
}

/// A wall x <= 0.2 m, and a ball of 10 mm.
Scene wall_and_ball() {
  Scene scene;
  scene.bodies = {shaped("wall", PlaneShape{}, {0.2, 0, 0}), shaped("tool", SphereShape{0.01}, {}, Motion::rigid)};
  scene.bodies[0].X_WB.R = from_rotation_vector({0, std::acos(0.0), 0});  // its outside, +z, turned to +x
  return scene;
}

/// The contact of the ball at x, turned by a quarter about z.
Contact contact_at(double x, Scene scene = wall_and_ball()) {
  PrimitiveCollision node(test::default_params<PrimitiveCollision>(), test::context_for(scene));
  ContactSet set;
  node.query({{x, 0.03, -0.04}, from_rotation_vector({0, 0, std::acos(0.0)})}, set);
  BOOST_REQUIRE(set.count == 1);
  BOOST_TEST(set.pair[0].body == 0);
  BOOST_TEST(set.pair[0].other == -1);
  return set.contact[0];
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_normal_points_from_the_other_body_to_the_moving_one) {
  says<ContactSet>("contact.n_W", "from the other body towards the moving body T");
  says<ContactSet>("contact.p_TC", "measured from its origin");
  says<ContactSet>("contact.p_WC", "Contact point of the other body");
  const Contact c = contact_at(0.209);
  BOOST_TEST(norm(c.n_W - Vec3{1, 0, 0}) < 1e-12);
  BOOST_TEST(norm(c.p_WC - Vec3{0.2, 0.03, -0.04}) < 1e-12);
  // The ball's lowest point is at -x of the world, which is +y of T: T's y axis points to -x.
  BOOST_TEST(field_of(message_type<ContactSet>().fields, "contact.p_TC").frame == "T");
  BOOST_TEST(norm(c.p_TC - Vec3{0, 0.01, 0}) < 1e-12);
}

BOOST_AUTO_TEST_CASE(a_distance_is_negative_inside) {
  says<ContactSet>("contact.distance", "positive apart, negative inside");
  BOOST_TEST(contact_at(0.2105).distance == 0.0005, tt::tolerance(1e-9));
  BOOST_TEST(contact_at(0.207).distance == -0.003, tt::tolerance(1e-9));
}

BOOST_AUTO_TEST_CASE(stiffnesses_are_in_series_and_the_softer_damps) {
  says<ContactSet>("contact.stiffness", "in series");
  says<ContactSet>("contact.damping", "of the softer material");
  says<ContactSet>("contact.friction", "geometric mean");
  Scene scene = wall_and_ball();
  scene.bodies[0].material = {.stiffness = 6000, .damping = 1, .friction = 0.9};
  scene.bodies[1].material = {.stiffness = 2000, .damping = 7, .friction = 0.4};
  const Contact c = contact_at(0.209, scene);
  BOOST_TEST(c.stiffness == 1 / (1 / 6000.0 + 1 / 2000.0), tt::tolerance(1e-12));
  BOOST_TEST(c.damping == 7);
  BOOST_TEST(c.friction == 0.6, tt::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(a_pair_names_the_other_moving_body_by_its_index) {
  says<ContactSet>("pair.other", "where it moves too; -1 where it is fixed");
  says<ContactSet>("pair", "0 is the tool, then come the others");
  Scene scene = wall_and_ball();
  scene.bodies.push_back(shaped("far", SphereShape{0.01}, {0.4, 0, 0}, Motion::rigid));
  scene.bodies.push_back(shaped("near", SphereShape{0.01}, {0.319, 0, 0}, Motion::rigid));
  PrimitiveCollision node(test::default_params<PrimitiveCollision>(), test::context_for(scene));
  ContactSet set;
  node.query({{0.3, 0, 0}, {}}, set);
  BOOST_REQUIRE(set.count == 1);
  BOOST_TEST(set.pair[0].body == 0);
  BOOST_TEST(set.pair[0].other == 2);
  // From the other one, at greater x, towards the tool.
  BOOST_TEST(norm(set.contact[0].n_W - Vec3{-1, 0, 0}) < 1e-12);
}

BOOST_AUTO_TEST_CASE(the_device_is_pulled_to_the_tool_and_the_tool_gets_the_whole_opposite) {
  says<CouplingParameters>("", "Force on the device: -k_t (p_WD - p_WT) - b_t (v_WD - v_WT)");
  says<CouplingParameters>("", "The tool gets the opposite");
  says<CouplingParameters>("force_max", "A longer one is shortened to it; the tool gets the whole.");
  const Scene scene = test::ball_scene(Motion::rigid);
  auto params = test::default_params<StaticCoupling>();
  StaticCoupling node(params, test::context_for(scene));
  node.state.configure({});
  StepContext at_start(Time{0});
  node.start(at_start);
  const CouplingParameters spring = test::sent(node.parameters);
  PhysicsState state;
  state.X_WD.p = {0.001, 0, 0};  // the handle is at +x of the tool
  node.state.push(test::stamp_ms(7), &state);
  StepContext at_step(test::at_ms(9));
  node.step(at_step);
  BOOST_TEST(test::sent(node.force).force.x == -0.001 * spring.k_t, tt::tolerance(1e-12));
  // Stamped as the state that it was computed for.
  says<Wrench>("", "valid for the state or the tick that it was computed for");
  BOOST_TEST(node.force.pending_valid(0).ns == test::at_ms(7).ns);

  // The tool, at rest, is pulled to +x, as far with a limit of the device as without.
  std::vector<double> speeds;
  for (const double force_max : {8.0, 1e-3}) {
    auto rigid = test::default_params<RigidDynamics>();
    rigid.start_at_device = false;
    test::NodeRig<RigidDynamics> rig(rigid, Motion::rigid);
    rig.coupling.force_max = force_max;
    rig.push_law();
    for (int ms = 0; ms <= 2; ++ms) {
      rig.device(ms, {0.001, 0, 0});
      rig.step(ms);
    }
    speeds.push_back(rig.state().V_WT.v.x);
  }
  BOOST_TEST(speeds[0] > 0);
  BOOST_TEST(speeds[0] == speeds[1]);
}

BOOST_AUTO_TEST_CASE(the_contact_torque_is_about_the_origin_of_the_tool) {
  says<PhysicsState>("contact_force", "on the tool");
  says<PhysicsState>("contact_torque", "about the origin of T");
  says<PhysicsState>("", "Stamped valid for the device sample");
  const Vec3 p_WT{0.5, -0.2, 0.1}, lever{0, 0.004, 0};
  Scene scene = test::ball_scene(Motion::rigid);
  scene.bodies[0].X_WB.p = p_WT;
  auto params = test::default_params<RigidDynamics>();
  test::NodeRig<RigidDynamics> rig(params, scene);
  ContactSet set;
  set.bodies.count = set.count = set.penetrating = 1;
  set.bodies.X_WB[0].p = p_WT;
  set.contact[0] = {.p_TC = lever,
                    .p_WC = p_WT + lever + Vec3{0.001, 0, 0},
                    .n_W = {1, 0, 0},
                    .distance = -0.001,
                    .weight = 1,
                    .stiffness = 1000};
  rig.contacts(0, set);
  rig.device(0, p_WT);
  rig.step(0);
  rig.contacts(1, set);
  rig.device(1, p_WT);
  BOOST_REQUIRE(rig.step(2) == 1U);
  BOOST_TEST(rig.valid_ms() == 1);
  const Wrench& felt = rig.state().contact_T_W;
  // It pushes the tool along the normal. About the world's origin the torque would be a hundred times as large.
  BOOST_TEST(felt.force.x > 0.5);
  BOOST_TEST(norm(felt.torque - cross(lever, felt.force)) < 0.02 * norm(felt.torque));
}

BOOST_AUTO_TEST_CASE(a_forecast_counts_its_periods_from_its_stamp) {
  says<Forecast>("", "Stamped valid for the newest usable physics force");
  says<Forecast>("predicted", "`predicted[i - 1]` is expected at the stamp plus i times `horizon`");
  says<Forecast>("count", "Entries of `predicted` in use");
  const Scene scene = test::ball_scene(Motion::rigid);
  auto params = test::default_params<LinearPredictor>();
  params.steps = 3;
  params.force_max = 100;
  LinearPredictor node(params, test::context_for(scene));
  node.force.configure({QueuePolicy::drop_oldest, 64});
  // A ramp of 40 N/s, a sample each 10 ms, the last of them not finite.
  const auto ramp = [](double seconds) { return 40 * seconds; };
  for (int k = 0; k <= 20; ++k) {
    const Wrench wrench{{0, k < 20 ? ramp(0.01 * k) : std::nan(""), 0}, {}};
    node.force.push(test::stamp_ms(10.0 * k, static_cast<std::uint64_t>(k)), &wrench);
    node.forecast.clear_pending();
    StepContext context(test::at_ms(10.0 * k + 3));
    node.step(context);
    if (k != 19) continue;
    const Forecast& made = test::sent(node.forecast);
    BOOST_TEST(node.forecast.pending_valid(0).ns == test::at_ms(190).ns);
    BOOST_TEST(made.count == 3);
    BOOST_TEST(made.fallback == 0);
    BOOST_TEST(made.horizon == 0.01, tt::tolerance(1e-6));
    BOOST_TEST(made.current_D_W.force.y == ramp(0.19), tt::tolerance(1e-9));
    for (int i = 1; i <= made.count; ++i) {
      const double expected = ramp(0.19 + i * made.horizon);
      BOOST_TEST(made.predicted_D_W[static_cast<std::size_t>(i - 1)].force.y == expected, tt::tolerance(1e-6));
    }
  }
  BOOST_TEST(node.forecast.pending_valid(0).ns == test::at_ms(190).ns);
  says<Forecast>("fallback", "1: the wrenches could not all be predicted");
  BOOST_TEST(test::sent(node.forecast).fallback == 1);
}

BOOST_AUTO_TEST_CASE(a_quaternion_is_w_x_y_z_and_rotates_to_the_world) {
  says<DeviceState>("R_WD", "Unit quaternion w, x, y, z: it rotates vectors expressed in D to W");
  DeviceState state;
  state.X_WD.R = from_rotation_vector({0, 0, 0.6});
  std::array<double, 4> numbers{};
  const Field& field = field_of(message_type<DeviceState>().fields, "R_WD");
  std::memcpy(numbers.data(), reinterpret_cast<const std::byte*>(&state) + field.offset, sizeof numbers);
  BOOST_TEST(numbers[0] == std::cos(0.3), tt::tolerance(1e-12));
  BOOST_TEST(numbers[3] == std::sin(0.3), tt::tolerance(1e-12));
  BOOST_TEST(norm(rotate(state.X_WD.R, {1, 0, 0}) - Vec3{std::cos(0.6), std::sin(0.6), 0}) < 1e-12);
}

BOOST_AUTO_TEST_CASE(a_segment_holds_its_ends) {
  says<ForceSegment>("", "s = (t - begin) / (end - begin). Before `begin` it is F(begin), after `end` F(end)");
  ForceSegment segment{test::at_ms(10), test::at_ms(20), {}, {}};
  for (std::size_t k = 0; k < 6; ++k) segment.c[k].force.z = static_cast<double>(k + 1);
  BOOST_TEST(evaluate(segment, test::at_ms(3)).force.z == 1);
  BOOST_TEST(evaluate(segment, test::at_ms(30)).force.z == 21);
  // 1 + 2/2 + 3/4 + 4/8 + 5/16 + 6/32 in the middle.
  BOOST_TEST(evaluate(segment, test::at_ms(15)).force.z == 3.75, tt::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(the_anchors_of_local_contacts_follow_one_another_in_time) {
  says<LocalContacts>("anchors", "The first has the bodies where they are at the stamp, the others later and later.");
  says<LocalContacts>("contact", "`contact[i][j]` is contact i, linearised at anchor j");
  Scene scene = wall_and_ball();
  auto params = test::default_params<PrimitiveCollision>();
  PrimitiveCollision node(params, test::context_for(scene));
  BodyStates at;
  at.count = 1;
  at.X_WB[0].p = {0.2115, 0, 0};
  at.V_WB[0].v = {-0.1, 0, 0};
  const double age = 0.01;  // s
  LocalContacts around;
  node.query_ahead(at, age, around);
  BOOST_REQUIRE(around.anchors > 1);
  BOOST_REQUIRE(around.count == 1);
  BOOST_TEST(around.X_WB[0][0].p.x == 0.2115 - 0.1 * age, tt::tolerance(1e-12));
  for (std::size_t j = 0; j < static_cast<std::size_t>(around.anchors); ++j) {
    if (j > 0) BOOST_TEST(around.X_WB[j][0].p.x < around.X_WB[j - 1][0].p.x);
    BOOST_TEST(around.contact[0][j].distance == around.X_WB[j][0].p.x - 0.01 - 0.2, tt::tolerance(1e-6));
  }
}

BOOST_AUTO_TEST_SUITE_END()
