// The coupling in MuJoCo's solver against implicit Euler by hand, its contacts, its state, and how it fails.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "framework/core/value_error.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "tests/own_physics/mujoco_models.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(mujoco_engine_test, *boost::unit_test::precondition(tactor::test::NeedsMujoco{}))

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

constexpr double h = 5e-4, mass = 0.05;

std::string refusal(const std::filesystem::path& file, const std::string& tool = "tool",
                    const std::string& keyframe = "") {
  try {
    load_mujoco_plugin("a test").engine({.file = file, .tool = tool, .keyframe = keyframe, .bodies = {}});
  } catch (const ValueError& error) {
    return error.path() + ": " + error.what();
  }
  return "taken";
}

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

std::vector<double> all(const EngineNumbers& n) {
  std::vector<double> out(n.position.begin(), n.position.end());
  for (const auto& more : {n.velocity, n.activation, n.acceleration}) out.insert(out.end(), more.begin(), more.end());
  return out;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_ball_on_the_coupling_moves_by_implicit_euler) {
  for (const char* option : {"", "solver=\"PGS\"", "solver=\"CG\" tolerance=\"1e-14\"", "jacobian=\"sparse\""}) {
    for (const bool is_free : {false, true}) {
      const auto engine = engine_of(model_file(ball(is_free ? "<freejoint/>" : slides, "0.1 0.2 0", "0 0 0.003"),
                                               std::string("<option gravity=\"0 0 0\" ") + option + "/>"));
      BOOST_TEST(engine->tool_rotates() == is_free);
      BOOST_TEST(engine->tool_mass() == mass, tt::tolerance(1e-12));
      const Vec3 start{0.1, 0.2, 0.003};
      BOOST_TEST(norm(engine->tool().X_WT.p - start) < 1e-15);
      double x = 0, v = 0, worst = 0;
      for (int i = 1; i <= 400; ++i) {
        const double t = i * h, x_D = 0.01 * std::sin(30 * t), v_D = 0.3 * std::cos(30 * t);
        DeviceState handle;
        handle.X_WD.p = start + Vec3{x_D, -2 * x_D, 0};
        handle.V_WD.v = {v_D, -2 * v_D, 0};
        BOOST_REQUIRE(engine->step(stiff, handle, h, nullptr));
        v = (mass / h * v + stiff.k_t * (x_D - x) + stiff.b_t * v_D) / (mass / h + h * stiff.k_t + stiff.b_t);
        x += h * v;
        worst = std::max(worst, norm(engine->tool().X_WT.p - start - Vec3{x, -2 * x, 0}));
        worst = std::max(worst, h * norm(engine->tool().V_WT.v - Vec3{v, -2 * v, 0}));
      }
      // PGS and CG stop where their own bound says so.
      BOOST_TEST(worst < (*option == '\0' || option[0] == 'j' ? 1e-12 : 1e-6), option << ' ' << worst);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_ball_turns_by_implicit_euler) {
  const auto engine = engine_of(model_file(ball("<freejoint/>"), weightless));
  const double inertia = 0.4 * mass * 0.01 * 0.01;
  double angle = 0, w = 0;
  for (int i = 1; i <= 400; ++i) {
    const double t = i * h, a_D = 0.5 * std::sin(20 * t), w_D = 10 * std::cos(20 * t);
    DeviceState handle;
    handle.X_WD.R = from_rotation_vector({0, a_D, 0});
    handle.V_WD.w = {0, w_D, 0};
    BOOST_REQUIRE(engine->step(stiff, handle, h, nullptr));
    w = (inertia / h * w + stiff.k_r * (a_D - angle) + stiff.b_r * w_D) / (inertia / h + h * stiff.k_r + stiff.b_r);
    angle += h * w;
    const Vec3 turned = to_rotation_vector(engine->tool().X_WT.R);
    BOOST_REQUIRE(norm(turned - Vec3{0, angle, 0}) < 1e-9);
    BOOST_REQUIRE(norm(engine->tool().V_WT.w - Vec3{0, w, 0}) < 1e-6);
  }
  BOOST_TEST(std::abs(angle) > 0.01);
}

BOOST_AUTO_TEST_CASE(without_a_coupling_a_body_falls_as_gravity_says) {
  const auto engine = engine_of(model_file(ball("<freejoint/>", "0 0 1"), R"(<option gravity="0 0 -9.81"/>)"));
  BOOST_TEST(engine->gravity_W().z == -9.81);
  constexpr int steps = 300;
  for (int i = 0; i < steps; ++i) BOOST_REQUIRE(engine->step({}, {}, h, nullptr));
  // Semi-implicit Euler: the speed after each step moves the body in it.
  BOOST_TEST(engine->tool().V_WT.v.z == -9.81 * steps * h, tt::tolerance(1e-6));
  BOOST_TEST(engine->tool().X_WT.p.z == 1 - 9.81 * h * h * steps * (steps + 1) / 2, tt::tolerance(1e-6));
}

BOOST_AUTO_TEST_CASE(at_rest_on_a_plane_contact_coupling_and_weight_balance) {
  for (const bool is_free : {false, true}) {
    const auto engine = engine_of(model_file(plane + ball(is_free ? "<freejoint/>" : slides, "0 0 0.02")));
    DeviceState handle;
    handle.X_WD.p = {0, 0, 0.008};
    ContactSet found;
    for (int i = 0; i < 6000; ++i) BOOST_REQUIRE(engine->step(stiff, handle, h, &found));
    const EngineTool& tool = engine->tool();
    const double pull = stiff.k_t * (handle.X_WD.p.z - tool.X_WT.p.z);
    BOOST_TEST(pull < -1.0);
    BOOST_TEST(tool.contacts == 1);
    BOOST_TEST(tool.contact_T_W.force.z + pull - 9.81 * mass == 0.0, tt::tolerance(1e-6) << tt::tolerance(1e-6));
    BOOST_TEST(norm(tool.contact_T_W.torque) < 1e-6);
    BOOST_REQUIRE(found.count == 1);
    BOOST_TEST(found.penetrating == 1);
    BOOST_TEST(found.pair[0].body == 0);
    BOOST_TEST(found.pair[0].other == ContactPair::fixed);
    const Contact& c = found.contact[0];
    BOOST_TEST(norm(c.n_W - Vec3{0, 0, 1}) < 1e-9);
    BOOST_TEST(c.distance == tool.X_WT.p.z - 0.01, tt::tolerance(1e-6));
    // Both points lie on the surfaces, whatever the frame of the tool.
    BOOST_TEST(std::abs(c.p_WC.z) < 1e-9);
    BOOST_TEST(norm(c.p_TC) == 0.01, tt::tolerance(1e-6));
    BOOST_TEST(c.stiffness > 0);
  }
}

BOOST_AUTO_TEST_CASE(a_state_that_is_restored_is_gone_on_with_to_the_last_bit) {
  const auto file = model_file(plane + ball(slides, "0 0 0.012") + R"(<body name="box" pos="0.05 0 0.02"><freejoint/>
      <geom type="box" size="0.03 0.02 0.02" mass="0.1"/></body>)");
  const auto a = engine_of(file), b = engine_of(file);
  BOOST_TEST(a->moving_bodies() == 2);
  const auto handle = [](int i) {
    DeviceState d;
    d.X_WD.p = {1e-4 * i, 0, 0.009};
    d.V_WD.v = {1e-4 / h, 0, 0};
    return d;
  };
  for (int i = 0; i < 150; ++i) BOOST_REQUIRE(a->step(stiff, handle(i), h, nullptr));
  BOOST_REQUIRE(b->restore(a->numbers()));
  for (int i = 150; i < 400; ++i) {
    BOOST_REQUIRE(a->step(stiff, handle(i), h, nullptr));
    BOOST_REQUIRE(b->step(stiff, handle(i), h, nullptr));
    BOOST_REQUIRE(all(a->numbers()) == all(b->numbers()));
  }
  BOOST_TEST(a->tool().contacts > 0);
  const auto other = engine_of(model_file(ball(slides)));
  BOOST_TEST(!other->restore(a->numbers()));
}

BOOST_AUTO_TEST_CASE(the_controls_of_a_keyframe_are_kept_even_after_a_failure) {
  const std::string motor = R"(<actuator><motor joint="door"/></actuator>
      <keyframe><key name="pushed" qpos="0 0 0 0.5" ctrl="0.01"/></keyframe>)";
  const auto file = model_file(ball(slides, "1 0 0") + R"(<body name="door" pos="0 0 0">
      <joint name="door" type="hinge" axis="0 0 1"/><geom type="box" size="0.05 0.01 0.05" pos="0.05 0 0" mass="0.1"/>
      </body>)",
                               weightless, motor);
  const auto engine = engine_of(file, "pushed");
  BOOST_TEST(engine->numbers().position.back() == 0.5);
  const std::vector<double> position(engine->numbers().position.begin(), engine->numbers().position.end());
  const std::vector<double> zero(engine->numbers().velocity.size(), 0.0);
  for (int round = 0; round < 2; ++round) {
    BOOST_REQUIRE(engine->restore({position, zero, {}, zero}));
    for (int i = 0; i < 10; ++i) BOOST_REQUIRE(engine->step({}, {}, h, nullptr));
    // A box about its edge: 0.1 kg (w^2 + d^2) / 12 + 0.1 kg (w / 2)^2.
    const double inertia = 0.1 * (0.1 * 0.1 + 0.02 * 0.02) / 12 + 0.1 * 0.05 * 0.05;
    BOOST_TEST(engine->numbers().velocity.back() == 10 * h * 0.01 / inertia, tt::tolerance(1e-6));
    DeviceState far_away;
    far_away.X_WD.p = {1e14, 0, 0};
    BOOST_TEST(!engine->step(stiff, far_away, h, nullptr));
    BOOST_TEST(holds(engine->failure(), "unstable"), engine->failure());
  }
}

BOOST_AUTO_TEST_CASE(a_model_that_cannot_be_used_is_refused_with_its_reason) {
  const std::string good = ball(slides);
  const auto with = [](const std::string& joints) { return model_file(ball(joints), weightless); };
  const std::vector<std::pair<std::string, std::string>> cases{
      {refusal(model_file(good), "probe"), "tool: "},
      {refusal(model_file(good), "probe"), "is not there"},
      {refusal(model_file(good), "probe"), "tool"},
      {refusal(model_file(good), "world"), "is the world"},
      {refusal(with("")), "has no joint"},
      {refusal(with(R"(<joint type="hinge" axis="0 0 1"/>)")), "has other joints"},
      {refusal(with(R"(<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>)")), "has other joints"},
      {refusal(with(R"(<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
                       <joint type="slide" axis="1 1 0"/>)")),
       "has other joints"},
      {refusal(model_file("<body name=\"carrier\"><freejoint/><geom type=\"sphere\" size=\"0.01\"/>" +
                          ball(slides, "0.1 0 0") + "</body>")),
       "hangs on body 'carrier'"},
      {refusal(model_file("<geom type=\"nothing\"/>" + good)), "MuJoCo cannot read it"},
      {refusal(model_file(good, R"(<option><flag equality="disable"/></option>)")), "enable both"},
      {refusal(model_file(good), "tool", "begin"), "keyframe: "},
      {refusal(with(R"(<joint type="slide" axis="1 0 0" damping="1"/><joint type="slide" axis="0 1 0"/>
                       <joint type="slide" axis="0 0 1"/>)")),
       "a joint of body 'tool' has damping"},
      {refusal(with(R"(<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0" stiffness="1"/>
                       <joint type="slide" axis="0 0 1"/>)")),
       "has stiffness"},
      {refusal(with(R"(<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
                       <joint type="slide" axis="0 0 1" frictionloss="0.1"/>)")),
       "has frictionloss"},
      {refusal(with(R"(<joint type="free" armature="0.01"/>)")), "has armature"},
      {refusal(model_file(R"(<body name="tool"><freejoint/><geom type="sphere" size="0.01"/>
                             <body name="tip" pos="0 0 0.1"><geom type="sphere" size="0.01"/></body></body>)")),
       "body 'tip' is welded to body 'tool'"},
      {refusal(model_file(good).replace_extension(".mjb")), ".xml"},
      {refusal("/nowhere/model.xml"), "model: "}};
  for (const auto& [text, part] : cases) BOOST_TEST(holds(text, part), part << " in " << text);
  BOOST_TEST(refusal(model_file(good)) == "taken");
}

BOOST_AUTO_TEST_CASE(a_fatal_error_of_mujoco_leaves_the_process_alive) {
  // Its stack is too small for its own work.
  const std::string text = refusal(model_file(plane + ball("<freejoint/>", "0 0 0.005"), R"(<size nstack="40"/>)"));
  BOOST_TEST(holds(text, "model: "), text);
  BOOST_TEST(holds(text, "Stack overflow"), text);
  BOOST_TEST(refusal(model_file(ball(slides))) == "taken");
}

BOOST_AUTO_TEST_CASE(too_many_constraints_fail_a_step) {
  const auto engine = engine_of(model_file(plane + ball("<freejoint/>", "0 0 0.009"), R"(<size njmax="7"/>)"));
  DeviceState handle;
  handle.X_WD.p = {0, 0, 0.009};
  BOOST_TEST(!engine->step(stiff, handle, h, nullptr));
  BOOST_TEST(holds(engine->failure(), "njmax"), engine->failure());
}

BOOST_AUTO_TEST_CASE(steps_and_restarts_allocate_nothing, *boost::unit_test::precondition(heap_is_counted)) {
  const auto engine = engine_of(model_file(plane + ball(slides, "0 0 0.009")));
  BOOST_TEST(engine->allocates(all_trees) == "");
  DeviceState handle;
  handle.X_WD.p = {0, 0, 0.008};
  BOOST_REQUIRE(engine->step(stiff, handle, h, nullptr));
  const std::vector<double> p(engine->numbers().position.begin(), engine->numbers().position.end());
  const std::vector<double> v(engine->numbers().velocity.begin(), engine->numbers().velocity.end());
  const std::int64_t before = thread_heap_calls();
  bool stepped = true;
  for (int i = 0; i < 500; ++i) {
    stepped = stepped && engine->step(stiff, handle, h, nullptr);
    if (i % 20 == 0) stepped = stepped && engine->restore({p, v, {}, v});
  }
  BOOST_TEST(thread_heap_calls() == before);
  BOOST_TEST(stepped);
}

namespace {

/// So many spheres in a heap, each touching many others.
std::filesystem::path heap_of(int spheres) {
  std::string world = plane + ball(slides, "0 0 0.1");
  for (int i = 0; i < spheres; ++i) {
    world += "<body pos=\"" + std::to_string(0.015 * (i % 3)) + ' ' + std::to_string(0.015 * (i / 3 % 3)) + ' ' +
             std::to_string(0.012 + 0.015 * (i / 9)) + R"("><freejoint/><geom type="sphere" size="0.012"/></body>)";
  }
  return model_file(world, R"(<size njmax="4000" nconmax="1000"/>)");
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_heap_that_mujoco_sorts_on_the_heap_is_refused,
                     *boost::unit_test::precondition(heap_is_counted)) {
  BOOST_TEST(engine_of(heap_of(30))->allocates(all_trees) != "");
  const auto engine = engine_of(heap_of(20));
  BOOST_TEST(engine->allocates(all_trees) == "");
  BOOST_REQUIRE(engine->step({}, {}, h, nullptr));
  const std::int64_t before = thread_heap_calls();
  bool stepped = true;
  for (int i = 0; i < 50; ++i) stepped = stepped && engine->step({}, {}, h, nullptr);
  BOOST_TEST(thread_heap_calls() == before);
  BOOST_TEST(stepped, engine->failure());
}

BOOST_AUTO_TEST_CASE(a_ball_that_pushes_a_box_gives_it_the_momentum_that_is_told) {
  const std::string box = R"(<body name="box" pos="0.05 0.01 0"><freejoint/>
      <geom type="box" size="0.02 0.03 0.02" pos="0.01 0 0" mass="0.2"/></body>)";
  const std::string tool = ball(slides, "0.02 0 0");
  // The tool before its obstacle, and behind it.
  for (const std::string& world : {tool + box, box + tool}) {
    const auto engine = load_mujoco_plugin("a test").engine(
        {.file = model_file(world, weightless), .tool = "tool", .keyframe = "", .bodies = {"box"}});
    BOOST_TEST(engine->moving_bodies() == 2);
    BOOST_TEST(engine->untold_bodies().empty());
    BodyStates before = engine->bodies();
    BOOST_TEST(norm(before.X_WB[1].p - Vec3{0.06, 0.01, 0}) < 1e-12);
    int touching = 0;
    ContactSet found;
    for (int i = 1; i <= 500; ++i) {
      DeviceState handle;
      handle.X_WD.p = {0.02 + 0.1 * i * h, 0, 0};
      handle.V_WD.v = {0.1, 0, 0};
      BOOST_REQUIRE(engine->step(stiff, handle, h, &found));
      const BodyStates after = engine->bodies();
      const Vec3 moved = (after.X_WB[1].p - before.X_WB[1].p) / h;
      // The centre moves by the speed about the body's origin, which turns it a little on the way.
      BOOST_REQUIRE(norm(after.V_WB[1].v - moved) < 1e-3 * norm(moved) + 1e-12);
      const Vec3 turned = to_rotation_vector(after.X_WB[1].R * inverse(before.X_WB[1].R)) / h;
      BOOST_REQUIRE(norm(after.V_WB[1].w - turned) < 1e-3 * norm(turned) + 1e-9);
      const Vec3 gained = 0.2 / h * (after.V_WB[1].v - before.V_WB[1].v);
      const Vec3& force = engine->tool().contact_T_W.force;
      BOOST_TEST(norm(gained + force) < 0.01 * norm(force) + 1e-3);
      before = after;
      if (norm(force) < 0.1) continue;
      ++touching;
      BOOST_TEST(force.x < 0);
      BOOST_REQUIRE(found.count == 1);
      BOOST_TEST(found.pair[0].body == 0);
      BOOST_TEST(found.pair[0].other == 1);
      BOOST_TEST(found.contact[0].n_W.x < -0.9);
      const Contact& c = found.contact[0];
      const Vec3 gap = transform(found.bodies.X_WB[0], c.p_TC) - c.p_WC;
      BOOST_TEST(norm(gap - c.distance * c.n_W) < 1e-9);
    }
    BOOST_TEST(touching > 5);
    BOOST_TEST(before.V_WB[1].v.x > 0.01);
    BOOST_TEST(std::abs(before.V_WB[1].w.z) > 0.01);
  }
}

BOOST_AUTO_TEST_CASE(a_body_off_its_origin_spins_and_bounces_by_the_wrench_that_is_told) {
  constexpr double step = 1e-5;
  const Vec3 half{0.03, 0.01, 0.02}, off{0.03, 0.01, -0.02};
  const auto engine = engine_of(model_file(plane + R"(<body name="tool" pos="0 0 0.3"><freejoint/>
      <geom type="box" size="0.03 0.01 0.02" pos="0.03 0.01 -0.02" mass="0.05"/></body>)",
                                           weightless));
  const Vec3 inertia =
      mass / 3 *
      Vec3{half.y * half.y + half.z * half.z, half.x * half.x + half.z * half.z, half.x * half.x + half.y * half.y};
  const Vec3 told = engine->tool_principal_inertia();
  BOOST_TEST(told.x + told.y + told.z == inertia.x + inertia.y + inertia.z, tt::tolerance(1e-9));
  const Pose place{{0.1, 0.2, 0.032}, from_rotation_vector({0.5, -0.4, 0.3})};
  engine->place_tool(place);
  BOOST_TEST(norm(engine->tool().X_WT.p - place.p) < 1e-12);
  const EngineNumbers at = engine->numbers();
  const std::vector<double> position(at.position.begin(), at.position.end()), zero(6, 0.0);
  // Of the origin in W, then the rotation about the body's axes.
  BOOST_REQUIRE(engine->restore({position, std::vector<double>{0.1, 0, -0.3, 4, -7, 9}, {}, zero}));
  const auto momentum = [&](const EngineTool& tool) {
    const Vec3 w = rotate(inverse(tool.X_WT.R), tool.V_WT.w);
    return rotate(tool.X_WT.R, Vec3{inertia.x * w.x, inertia.y * w.y, inertia.z * w.z});
  };
  BOOST_TEST(norm(engine->tool().V_WT.v -
                  (Vec3{0.1, 0, -0.3} + cross(rotate(place.R, Vec3{4, -7, 9}), rotate(place.R, off)))) < 1e-12);
  int touching = 0;
  for (int i = 0; i < 3000; ++i) {
    const EngineTool before = engine->tool();
    BOOST_REQUIRE(engine->step({}, {}, step, nullptr));
    const EngineTool& after = engine->tool();
    const Vec3 moved = (after.X_WT.p - before.X_WT.p) / step;
    const Vec3 turned = to_rotation_vector(after.X_WT.R * inverse(before.X_WT.R)) / step;
    BOOST_REQUIRE(norm(moved - after.V_WT.v) < 1e-3 * norm(after.V_WT.v));
    BOOST_REQUIRE(norm(turned - after.V_WT.w) < 1e-3 * norm(after.V_WT.w));
    const Wrench& wrench = after.contact_T_W;
    const Vec3 force = mass / step * (after.V_WT.v - before.V_WT.v);
    const Vec3 torque = (momentum(after) - momentum(before)) / step;
    BOOST_REQUIRE(norm(force - wrench.force) < 0.02 * norm(wrench.force) + 1e-3);
    BOOST_REQUIRE(norm(torque - wrench.torque) < 0.02 * norm(wrench.torque) + 1e-5);
    if (norm(wrench.force) < 0.1) continue;
    ++touching;
    BOOST_REQUIRE(wrench.force.z > 0);
  }
  BOOST_TEST(touching > 20);
}

BOOST_AUTO_TEST_CASE(bodies_that_are_not_listed_are_told_by_name_and_contacts_of_what_hangs_on_the_tool_are_the_tools) {
  const std::string world = plane + R"(<body name="tool" pos="0 0 0.1">)" + slides + R"(
      <geom type="sphere" size="0.01" mass="0.05"/>
      <body name="finger" pos="0 0 -0.05"><joint type="hinge" axis="1 0 0"/><geom type="sphere" size="0.01" mass="0.01"/>
      </body></body><body name="door" pos="1 0 0.5"><joint type="hinge" axis="0 0 1"/>
      <geom type="box" size="0.1 0.1 0.1"/><body name="knob"><geom type="sphere" size="0.01"/></body></body>
      <body name="post" pos="2 0 0"><geom type="box" size="0.1 0.1 0.1"/></body>)";
  const auto engine = engine_of(model_file(world, weightless));
  const std::vector<std::string> untold = engine->untold_bodies();
  BOOST_REQUIRE(untold.size() == 1U);
  BOOST_TEST(untold[0] == "door");
  engine->place_tool({{0, 0, 0.0595}, {}});
  DeviceState handle;
  handle.X_WD.p = {0, 0, 0.0595};
  ContactSet found;
  BOOST_REQUIRE(engine->step(stiff, handle, h, &found));
  BOOST_REQUIRE(found.count == 1);
  BOOST_TEST(found.pair[0].body == 0);
  BOOST_TEST(found.pair[0].other == ContactPair::fixed);
  BOOST_TEST(found.contact[0].n_W.z > 0.99);
}

BOOST_AUTO_TEST_CASE(an_engine_has_the_identity_of_its_files_tool_and_keyframe) {
  const std::string tail = R"(<keyframe><key name="a"/><key name="b"/></keyframe>)";
  const auto of = [](const std::filesystem::path& file, const std::string& key = "") {
    return engine_of(file, key)->identity();
  };
  const auto here = model_file(ball(slides), "", tail), copy = model_file(ball(slides), "", tail);
  BOOST_TEST(of(here) == of(copy));
  BOOST_TEST(of(here) != of(model_file(ball(slides, "0 0 1"), "", tail)));
  BOOST_TEST(of(here, "a") != of(here, "b"));
  BOOST_TEST(of(here, "a") != of(here));
}

BOOST_AUTO_TEST_SUITE_END()
