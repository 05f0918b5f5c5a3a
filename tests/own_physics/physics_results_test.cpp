// Each result that cannot be used is refused, with the name of its field, and nothing of it is sent.
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <functional>
#include <limits>

#include "tests/own_physics/ball.hpp"

BOOST_AUTO_TEST_SUITE(physics_results_test)

using namespace tactor;
using namespace tactor::test;

namespace {

std::string held_graph(const std::string& record = "physics.state, physics.contacts, physics.force") {
  return graph_text("clock: virtual\nduration: 1 s", still_hand, 100, held, record);
}

/// A result with all that there may be, and what it points to.
struct Whole {
  ContactSet contacts;
  BodyStates bodies;
  PhysicsResult result;
  explicit Whole(const PhysicsStep& step) {
    contacts = Ball().contacts();
    bodies.count = 1;
    bodies.X_WB[0].p = {0.001, 0, 0.004};
    contacts.contact[0].p_TC = {-0.001, 0, -0.008};
    result = {.time = step.end,
              .X_WT = bodies.X_WB[0],
              .V_WT = {},
              .felt_D_W = Wrench{{0, 0, 1}, {}},
              .contact_T_W = Wrench{{0, 0, 2}, {}},
              .contacts = &contacts,
              .bodies = &bodies};
  }
  Whole(const Whole&) = delete;
  Whole& operator=(const Whole&) = delete;
};

struct Refused {
  std::function<void(Whole&)> spoil;
  std::string says;
};

constexpr double inf = std::numeric_limits<double>::infinity();

const std::vector<Refused> all_refused{
    {[](Whole& w) { w.result.X_WT->p.y = std::nan(""), w.bodies.X_WB[0].p.y = std::nan(""); }, "bodies\\[0\\].p_WB"},
    {[](Whole& w) { w.result.bodies = nullptr, w.result.X_WT->p.x = inf; }, "tool.p_WT: expected finite numbers"},
    {[](Whole& w) { w.result.bodies = nullptr, w.result.X_WT->R.w = 1.01; },
     "tool.R_WT: .*length 1, found length 1.01"},
    {[](Whole& w) {
       w.result.bodies = nullptr, w.result.X_WT->R = {0, 0, 0, 0};
     },
     "tool.R_WT"},
    {[](Whole& w) { w.result.bodies = nullptr, w.result.V_WT.v.z = inf; }, "tool.v_WT"},
    {[](Whole& w) { w.result.bodies = nullptr, w.result.V_WT.w.x = -inf; }, "tool.w_WT"},
    {[](Whole& w) { w.result.V_WT.v.x = 0.1; }, "bodies\\[0\\]: expected the pose and velocity of `tool`"},
    {[](Whole& w) { w.result.X_WT->p.x = 0.002; }, "bodies\\[0\\]: expected the pose and velocity of `tool`"},
    {[](Whole& w) { w.bodies.V_WB[0].w.z = inf; }, "bodies\\[0\\].w_WB"},
    {[](Whole& w) { w.bodies.count = 2; }, "bodies: expected all moving bodies of the scene, which are 1, found 2"},
    {[](Whole& w) { w.bodies.count = 0; }, "bodies: .*found 0"},
    {[](Whole& w) { w.result.felt_D_W->force.x = std::nan(""); }, "felt.force"},
    {[](Whole& w) { w.result.contact_T_W->torque.x = inf; }, "contact.torque"},
    {[](Whole& w) { w.contacts.count = 129; }, "contacts: expected at most 128 of them, found 129"},
    {[](Whole& w) { w.contacts.count = -1; }, "contacts: expected at most 128"},
    {[](Whole& w) {
       w.contacts.contact[0].n_W = {0, 0, 0.9};
     },
     "contacts\\[0\\].n_W: expected a normal of length 1"},
    {[](Whole& w) { w.contacts.contact[0].H_W[3] = inf; }, "contacts\\[0\\].H_W: expected finite numbers"},
    {[](Whole& w) { w.contacts.contact[0].distance = std::nan(""); }, "contacts\\[0\\].distance"},
    {[](Whole& w) { w.contacts.contact[0].weight = 0; }, "contacts\\[0\\].weight: expected a number above 0"},
    {[](Whole& w) { w.contacts.contact[0].stiffness = -1; },
     "contacts\\[0\\].stiffness: expected a number above 0, found -1"},
    {[](Whole& w) { w.contacts.contact[0].stiffness = 0; },
     "contacts\\[0\\].stiffness: expected a number above 0, found 0"},
    {[](Whole& w) { w.contacts.contact[0].friction = -0.1; }, "contacts\\[0\\].friction"},
    {[](Whole& w) { w.contacts.contact[0].inertia = -1; }, "contacts\\[0\\].inertia: expected 0 or more, found -1"},
    {[](Whole& w) { w.contacts.contact[0].creep = -1; }, "contacts\\[0\\].creep: expected 0 or more, found -1"},
    {[](Whole& w) { w.contacts.contact[0].lift = 1.5; }, "contacts\\[0\\].lift: expected 0 to 1, found 1.5"},
    {[](Whole& w) { w.contacts.contact[0].lift = -0.5; }, "contacts\\[0\\].lift"},
    {[](Whole& w) { w.contacts.contact[0].p_TC.z += 1e-5; }, "contacts\\[0\\].p_TC: .*-0.008 m in the body's frame"},
    {[](Whole& w) { w.contacts.contact[0].p_WC.x = std::nan(""), w.result.without_p_TC.set(0); },
     "contacts\\[0\\].p_WC: expected finite numbers"},
    {[](Whole& w) { w.contacts.pair[0].body = 1; }, "contacts\\[0\\].body: expected a moving body, 0 to 0, found 1"},
    {[](Whole& w) { w.contacts.pair[0].other = 0; }, "contacts\\[0\\].other"},
    {[](Whole& w) { w.result.time = Time{5'000'000'000}; }, "time: expected .*found 5 s"},
    {[](Whole& w) { w.result.time = Time{-1}; }, "time: expected"},
    {[](Whole& w) { w.result.X_WT.reset(), w.result.bodies = nullptr; }, "tool: expected a pose, because contacts"},
    {[](Whole& w) { w.result = {}; }, "tool: expected a pose, or a wrench as `felt`"},
};

}  // namespace

BOOST_AUTO_TEST_CASE(what_is_wrong_is_told_by_its_name_and_not_sent) {
  Session session(planned_text(held_graph()));
  std::vector<Stamped<PhysicsState>> state;
  std::vector<Stamped<ContactSet>> contacts;
  std::vector<Stamped<Wrench>> force;
  keep(session, "physics.state", state);
  keep(session, "physics.contacts", contacts);
  keep(session, "physics.force", force);
  PhysicsLoop loop(session);
  const auto step = loop.next();
  BOOST_REQUIRE(step.has_value());
  for (const Refused& refused : all_refused) {
    Whole whole(*step);
    refused.spoil(whole);
    says_like(refusal_of([&] { loop.result(*step, whole.result); }), "^result: " + refused.says);
  }
  const Whole good(*step);
  loop.result(*step, good.result);
  // The order of results is that of their times.
  says_like(refusal_of([&] {
              Whole late(*step);
              late.result.time = Time{step->end.ns - 1};
              loop.result(*step, late.result);
            }),
            "time: expected 0.01.* s, that of the last result, to .*found 0.00999");
  BOOST_REQUIRE(loop.next().has_value());
  session.finish();
  BOOST_REQUIRE(state.size() == 1U);
  BOOST_REQUIRE(contacts.size() == 1U);
  BOOST_REQUIRE(force.size() == 1U);
  BOOST_TEST(force[0].value.force.z == 1.0);
  BOOST_TEST(state[0].value.contact_T_W.force.z == 2.0);
  BOOST_TEST(state[0].value.damped == 0);
  BOOST_TEST(state[0].value.contacts == 1);
  BOOST_TEST(contacts[0].value.penetrating == 1);
  BOOST_TEST((contacts[0].value.bodies.X_WB[0].p == Vec3{0.001, 0, 0.004}));
}

BOOST_AUTO_TEST_CASE(a_body_that_turns_needs_its_rotation) {
  Session session(planned_text(replaced(held_graph(), "motion: translation", "motion: rigid")));
  PhysicsLoop loop(session);
  const auto step = loop.next();
  BOOST_REQUIRE(step.has_value());
  Whole whole(*step);
  whole.result.without_rotation.set(0);
  says_like(refusal_of([&] { loop.result(*step, whole.result); }), "bodies\\[0\\].R_WB: expected a rotation");
  whole.result.bodies = nullptr;
  says_like(refusal_of([&] { loop.result(*step, whole.result); }), "^result: tool.R_WT: expected a rotation");
  whole.result.without_rotation.reset();
  loop.result(*step, whole.result);
}

BOOST_AUTO_TEST_CASE(an_own_point_that_is_not_told_follows_from_the_rest) {
  Session session(planned_text(held_graph()));
  std::vector<Stamped<ContactSet>> contacts;
  keep(session, "physics.contacts", contacts);
  PhysicsLoop loop(session);
  const auto step = loop.next();
  Whole whole(*step);
  whole.result.bodies = nullptr;
  // A quarter turn about z: the world's x is the body's -y.
  whole.result.X_WT = Pose{{1, 2, 3}, normalized({1, 0, 0, 1})};
  Contact& contact = whole.contacts.contact[0];
  contact.p_WC = {1.5, 2, 3};
  contact.n_W = {-1, 0, 0};
  contact.distance = 0.25;
  whole.result.without_p_TC.set(0);
  loop.result(*step, whole.result);
  BOOST_REQUIRE(loop.next().has_value());
  session.finish();
  BOOST_TEST(norm(contacts.at(0).value.contact[0].p_TC - Vec3{0, -0.25, 0}) < 1e-12);
}

BOOST_AUTO_TEST_CASE(bodies_are_told_whole_or_not_at_all) {
  const BodyStates none{.count = 0, .massless = 0, .X_WB = {}, .V_WB = {}};
  const PhysicsResult result{.felt_D_W = Wrench{}, .bodies = &none};
  says_like(refusal_of([&] { static_cast<void>(physics_messages(result, {}, {}, {})); }),
            "^result: bodies: expected none");
}

BOOST_AUTO_TEST_CASE(contacts_that_the_graph_reads_are_told) {
  Session session(
      planned_text(graph_text("clock: virtual\nduration: 1 s", still_hand, 100, rolled_out, "physics.state")));
  PhysicsLoop loop(session);
  const auto step = loop.next();
  says_like(refusal_of([&] { loop.result(*step, {.X_WT = Pose{}}); }),
            "^result: contacts: expected a list, because the graph reads physics.contacts; found none");
  const ContactSet none;
  loop.result(*step, {.X_WT = Pose{}, .contacts = &none});
}

BOOST_AUTO_TEST_CASE(a_massless_coupling_is_refused) {
  says_like(refusal_of([] { planned_text(replaced(held_graph(), "coupling.dynamic", "coupling.static")); }),
            "massless");
}

BOOST_AUTO_TEST_CASE(a_loop_takes_its_own_steps_alone) {
  Session session(planned_text(held_graph())), other_session(planned_text(held_graph()));
  PhysicsLoop loop(session), other(other_session);
  says_like(refusal_of([&] { const PhysicsLoop second(session); }), "node physics has a loop of physics already");
  const auto step = loop.next(), foreign = other.next();
  says_like(refusal_of([&] { loop.result(*foreign, {.X_WT = Pose{}}); }),
            "^result: step: expected a step of this loop");
  loop.result(*step, {.X_WT = Pose{}});
}

BOOST_AUTO_TEST_CASE(lengths_that_are_nearly_one_become_one) {
  Session session(planned_text(held_graph()));
  std::vector<Stamped<PhysicsState>> state;
  std::vector<Stamped<ContactSet>> contacts;
  keep(session, "physics.state", state);
  keep(session, "physics.contacts", contacts);
  PhysicsLoop loop(session);
  const auto step = loop.next();
  Whole whole(*step);
  whole.result.bodies = nullptr;
  whole.result.X_WT->R = {1.0005, 0, 0, 0};
  whole.contacts.contact[0].n_W = {0, 0, 0.9995};
  loop.result(*step, whole.result);
  BOOST_REQUIRE(loop.next().has_value());
  session.finish();
  near(state.at(0).value.X_WT.R.w, 1, 1e-15);
  near(contacts.at(0).value.contact[0].n_W.z, 1, 1e-15);
}

BOOST_AUTO_TEST_CASE(a_program_may_say_itself_what_is_felt) {
  std::string text = replaced(held_graph("device.commanded"), "coupling.force -> prediction.force",
                              "physics.force -> prediction.force");
  text = replaced(text, "  - coupling.parameters -> physics.coupling\n", "");
  text = replaced(text, "  - physics.state -> coupling.state\n", "");
  Session session(planned_text(text));
  std::vector<Stamped<Wrench>> commanded;
  keep(session, "device.commanded", commanded);
  PhysicsLoop loop(session);
  BOOST_TEST(!loop.has_coupling());
  bool first = true;
  while (const auto step = loop.next()) {
    BOOST_TEST(step->coupling.k_t == 0.0);
    if (std::exchange(first, false)) {
      says_like(refusal_of([&] { loop.result(*step, {.X_WT = Pose{}}); }), "felt: .*physics.force; found none");
    }
    loop.result(*step, {.felt_D_W = Wrench{{0, 0, 0.7}, {}}});
  }
  session.finish();
  BOOST_REQUIRE(!commanded.empty());
  near(commanded.back().value.force.z, 0.7, 1e-9);
}

BOOST_AUTO_TEST_CASE(a_loop_says_which_node_it_wants) {
  const std::string text = held_graph();
  {
    Session session(planned_text(text));
    says_like(refusal_of([&] { PhysicsLoop(session, "physic"); }), "no node physic of type physics.external.*physics");
    const PhysicsLoop named(session, "physics");
    BOOST_TEST(named.node().name == "physics");
    BOOST_TEST(PhysicsLoop::node_of(session.plan()) == "physics");
  }
  {
    Session session(planned("wall/scene.yaml"));
    says_like(refusal_of([&] { const PhysicsLoop loop(session); }), "no node of type physics.external");
  }
  {
    const std::string two =
        replaced(replaced(text, "  coupling: {", "  other: {type: physics.external}\n  coupling: {"),
                 "  - device.state -> physics.device\n",
                 "  - device.state -> physics.device\n  - device.state -> other.device\n");
    Session session(planned_text(replaced(two, "physics.force]", "physics.force, other.state]")));
    says_like(refusal_of([&] { const PhysicsLoop loop(session); }), "several nodes.*name one of");
  }
  {
    Session session(
        planned_text(replaced(text, "  - device.state -> physics.device\n",
                              "  - {from: device.state, to: physics.device, queue: \"queue(8, block)\"}\n")));
    says_like(refusal_of([&] { const PhysicsLoop loop(session); }), "expected another policy than block");
  }
}

BOOST_AUTO_TEST_CASE(outputs_of_a_fed_node_are_feeds_of_their_own) {
  Session session(planned_text(held_graph()));
  BOOST_TEST(session.feed("physics.force").type().name == "Wrench");
  BOOST_TEST(session.feed("coupling.state").type().name == "PhysicsState");
  says_like(refusal_of([&] { static_cast<void>(session.feed("physics")); }), "no feed physics");
}

BOOST_AUTO_TEST_SUITE_END()
