// prediction.local against the dynamics that made the result, gone on with through the same samples of the handle.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "framework/realtime/allocation_watch.hpp"
#include "nodes/dynamics/translation.hpp"
#include "nodes/physics/contact/local_contacts.hpp"
#include "nodes/physics/mechanics/local_model.hpp"
#include "nodes/prediction/local.hpp"
#include "tests/nodes/dynamics/node_rig.hpp"
#include "tests/nodes/physics/mechanics/local_contacts.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(local_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

constexpr double radius = 0.01;
// What the steps of a rollout may leave of their equations (1e-6 of the forces) moves 0.1 kg by far less.
constexpr double rounding = 1e-9;  // m

/// A handle that swings into the wall x = 0 and along it; its samples come at these milliseconds.
DeviceState handle(double ms) {
  const double t = 1e-3 * ms;
  return {{{0.010 - 0.003 * std::sin(20 * t), 0.004 * std::sin(13 * t), 0}, {}},
          {{-0.06 * std::cos(20 * t), 0.052 * std::cos(13 * t), 0}, {}},
          0};
}

/// Dynamics, whose query finds the wall where its tool is.
class Physics {
 public:
  explicit Physics(bool wall, double stiffness = 2000, double friction = 0.3,
                   Integrator integrator = Integrator::implicit_euler)
      : rig_(params(integrator), scene()), wall_(wall), stiffness_(stiffness), friction_(friction) {}
  void sample(int ms, const DeviceState& state) { rig_.node.device.push(stamp_ms(ms), &state); }
  /// Moves on to `ms`; the result.
  const BodyStates& step(int ms) {
    ContactSet set;
    set.bodies = bodies_;
    if (wall_) {
      set.count = 1;
      set.contact[0] = contact(bodies_.X_WB[0]);
    }
    rig_.contacts(ms, set);
    BOOST_REQUIRE(rig_.step(ms) == 1U);
    return bodies_ = sent(rig_.node.bodies);
  }
  /// The last result as the coupling gets it.
  [[nodiscard]] const PhysicsState& state() const { return rig_.state(); }
  /// Of the last result: of the last sample up to its time.
  [[nodiscard]] int valid_ms() const { return static_cast<int>(rig_.valid_ms()); }
  [[nodiscard]] Contact contact(const Pose& X) const {
    return contact_of(plane_at(X.p, {1, 0, 0}, 0, radius), X, radius, stiffness_, 3, friction_);
  }
  [[nodiscard]] const CouplingParameters& coupling() const { return rig_.coupling; }

 private:
  static TranslationDynamics::Params params(Integrator integrator) {
    auto p = default_params<TranslationDynamics>();
    p.integrator = integrator;
    p.substep = 0.02;  // from sample to sample
    p.dissipate_above = 1e6;
    p.start_at_device = false;
    return p;
  }
  static Scene scene() {
    Scene s = ball_scene(Motion::translation);
    s.bodies[0].X_WB.p = {0.02, 0, 0};
    return s;
  }
  NodeRig<TranslationDynamics> rig_;
  bool wall_;
  double stiffness_, friction_;
  BodyStates bodies_ = one_body({0.02, 0, 0});
};

class Subject {
 public:
  explicit Subject(const LocalPredictor::Params& params = default_params<LocalPredictor>(), bool with_contacts = true,
                   bool with_state = false, bool foreign_physics = false)
      : scene_(ball_scene(Motion::translation)), node_(params, context_of(scene_, foreign_physics)) {
    node_.bodies.configure({});
    if (with_contacts) node_.contacts.configure({});
    if (with_state) node_.state.configure({});
    node_.coupling.configure({});
    node_.device.configure({QueuePolicy::drop_oldest, 512});
    node_.coupling.push({}, &coupling);
  }
  void sample(double ms, const DeviceState& state) { node_.device.push(stamp_ms(ms), &state); }
  void contacts(const LocalContacts& local) { node_.contacts.push({}, &local); }
  /// Contacts that came with the result of `stamp`.
  void found(double stamp, const ContactSet& set) {
    if (!node_.found.connected()) node_.found.configure({QueuePolicy::drop_oldest, 8});
    node_.found.push(stamp_ms(stamp), &set);
  }
  void physics(int stamp, const PhysicsState& state) { node_.state.push(stamp_ms(stamp), &state); }
  /// A result of `stamp` that comes at `now`; true where a model is sent.
  bool result(double stamp, int now, const BodyStates& bodies) {
    node_.bodies.push(stamp_ms(stamp, sequence_++), &bodies);
    StepContext context(Time{now * 1'000'000LL});
    node_.step(context);
    const bool any = node_.model.pending() > 0;
    if (any) {
      BOOST_REQUIRE(node_.model.pending_valid(0).ns == at_ms(stamp).ns);
      model = sent(node_.model);
      correct(model.correction, model.contacts);
    }
    node_.model.clear_pending();
    return any;
  }
  [[nodiscard]] std::map<std::string, double> metrics() const { return metrics_of(node_); }
  [[nodiscard]] double metric(const std::string& name) const { return metrics().at(name); }

  [[nodiscard]] const Refusals& refusals() const { return node_.refusals(); }

  CouplingParameters coupling{.k_t = 500, .b_t = 14, .k_r = 1, .b_r = 0.01, .force_max = 8, .torque_max = 0.3};
  LocalModel model;

 private:
  static NodeContext context_of(const Scene& scene, bool foreign_physics) {
    NodeContext context = context_for(scene);
    context.foreign_physics = foreign_physics;
    return context;
  }

  Scene scene_;
  LocalPredictor node_;
  std::uint64_t sequence_ = 0;
};

/// The wall as a query at one pose finds it.
LocalContacts wall_for_one(const Physics& physics, const BodyStates& bodies) {
  return around({bodies}, {}, [&](const BodyStates& at) { return physics.contact(at.X_WB[0]); });
}

LocalContacts wall_for(const Physics& physics, const Vec3& p) {
  std::vector<BodyStates> anchors{one_body(p), one_body(p + Vec3{-0.002, 0.001, 0}), one_body(p + Vec3{0.03, 0, 0})};
  return around(anchors, {}, [&](const BodyStates& bodies) { return physics.contact(bodies.X_WB[0]); });
}

}  // namespace

namespace {

void check_against_dynamics(bool wall, Integrator integrator) {
  Physics physics(wall, 2000, 0.3, integrator), ahead(wall, 2000, 0.3, integrator);
  LocalPredictor::Params params = default_params<LocalPredictor>();
  params.integrator = integrator;
  Subject subject(params, wall);
  int results = 0, touching = 0;
  double moved = 0;
  for (int ms = 0; ms <= 900; ++ms) {
    // One in nine samples is lost, and each third one is followed by one of the past.
    if (ms % 9 != 4) {
      physics.sample(ms, handle(ms));
      ahead.sample(ms, handle(ms));
      subject.sample(ms, handle(ms));
      if (ms % 3 == 0) subject.sample(ms - 2, handle(ms - 2));
    }
    if (ms < 30 || ms % 20 != 0) continue;
    // A result of 17 ms ago comes now.
    const BodyStates then = physics.step(ms - 17);
    const BodyStates& now = ahead.step(ms);
    if (wall) subject.contacts(wall_for(physics, then.X_WB[0].p));
    BOOST_REQUIRE(subject.result(physics.valid_ms(), ms, then));
    ++results;
    BOOST_TEST(norm(subject.model.bodies.X_WB[0].p - now.X_WB[0].p) < rounding);
    BOOST_TEST(norm(subject.model.bodies.V_WB[0].v - now.V_WB[0].v) < 1000 * rounding);
    const int newest = ms % 9 != 4 ? ms : ms - 1;
    BOOST_TEST(subject.model.time.ns == newest * 1'000'000LL);
    BOOST_TEST(norm(subject.model.device.X_WD.p - handle(newest).X_WD.p) == 0.0);
    moved = std::max(moved, norm(now.X_WB[0].p - then.X_WB[0].p));
    touching += now.X_WB[0].p.x < radius ? 1 : 0;
  }
  BOOST_TEST(moved > 0.001);
  if (wall) BOOST_TEST(touching > 10);
  BOOST_TEST(subject.metric("prediction.rejected_results") == 0.0);
  BOOST_TEST(subject.metric("prediction.failed_steps") == 0.0);
  BOOST_TEST(std::abs(subject.metric("prediction.resimulated_steps") - 17 * 8.0 / 9) < 1);
  BOOST_TEST(subject.metric("prediction.rejected_samples") > 250);  // those of the past
}

}  // namespace

BOOST_AUTO_TEST_CASE(where_contacts_are_exact_the_model_is_where_dynamics_itself_comes_to) {
  for (const Integrator integrator : {Integrator::implicit_euler, Integrator::midpoint}) {
    for (const bool wall : {true, false}) check_against_dynamics(wall, integrator);
  }
}

BOOST_AUTO_TEST_CASE(contacts_that_physics_tells_serve_as_one_anchor_of_the_same_law) {
  Physics physics(true);
  const BodyStates then = one_body({0.0095, 0, 0}, {-0.02, 0.03, 0});
  Contact law = physics.contact(then.X_WB[0]);
  law.inertia = 0.3, law.creep = 0.01, law.lift = 1;
  ContactSet set;
  set.bodies = then;
  set.count = 1;
  set.contact[0] = law;
  Subject told(default_params<LocalPredictor>(), false), around_it, alone(default_params<LocalPredictor>(), false);
  told.found(3, set);
  around_it.contacts(around({then}, {}, [&](const BodyStates&) { return law; }));
  for (Subject* subject : {&told, &around_it, &alone}) {
    for (int ms = 0; ms <= 20; ++ms) subject->sample(ms, handle(ms));
    BOOST_REQUIRE(subject->result(3, 20, then));
  }
  BOOST_TEST(told.model.contacts.count == 1);
  BOOST_TEST(told.model.contacts.contact[0][0].lift == 1.0);
  BOOST_TEST((told.model.bodies.X_WB[0] == around_it.model.bodies.X_WB[0]));
  BOOST_TEST(norm(told.model.bodies.X_WB[0].p - alone.model.bodies.X_WB[0].p) > 1e-5);
}

BOOST_AUTO_TEST_CASE(a_result_older_than_all_samples_goes_through_all_of_them) {
  Subject subject;
  for (const int ms : {50, 60}) subject.sample(ms, handle(ms));
  const BodyStates start = one_body({0.02, 0, 0});
  BOOST_REQUIRE(subject.result(45, 60, start));
  // In free space, by hand: implicit steps of 5 and 10 ms.
  Vec3 x = start.X_WB[0].p, v;
  double before = 0.045;
  for (const int ms : {50, 60}) {
    const double h = 1e-3 * ms - before, m = 0.1;
    const DeviceState d = handle(ms);
    v = 1 / (m + h * subject.coupling.b_t + h * h * subject.coupling.k_t) *
        (m * v + h * subject.coupling.k_t * (d.X_WD.p - x) + h * subject.coupling.b_t * d.V_WD.v);
    x += h * v;
    before = 1e-3 * ms;
  }
  BOOST_TEST(norm(subject.model.bodies.X_WB[0].p - x) < rounding);
  BOOST_TEST(norm(subject.model.bodies.V_WB[0].v - v) < 1000 * rounding);
  BOOST_TEST(subject.metric("prediction.resimulated_steps") == 2.0);
  // One newer than all samples goes through none.
  BOOST_REQUIRE(subject.result(65, 66, start));
  BOOST_TEST(subject.model.time.ns == 65'000'000);
  BOOST_TEST((subject.model.bodies.X_WB[0].p == start.X_WB[0].p));
}

BOOST_AUTO_TEST_CASE(the_model_of_physics_of_another_law_says_that_nobody_knows_what_the_law_gets_wrong) {
  for (const bool fit : {true, false}) {
    for (const bool foreign : {true, false}) {
      auto params = default_params<LocalPredictor>();
      params.fit = fit;
      Subject subject(params, true, true, foreign);
      subject.sample(50, handle(50));
      BOOST_REQUIRE(subject.result(45, 50, one_body({0.02, 0, 0})));
      BOOST_TEST(subject.model.law_unknown == (foreign ? 1 : 0));
    }
  }
}

BOOST_AUTO_TEST_CASE(a_faster_device_makes_a_result_cost_no_more_steps) {
  const BodyStates start = one_body({0.02, 0, 0});
  // From 9 ms to 40 ms: samples each ms, and each quarter of one up to 40.25 ms.
  const auto rolled = [&start](double period, double last, Duration min_step) {
    auto params = default_params<LocalPredictor>();
    params.min_step = min_step;
    Subject subject(params, false);
    for (int k = 0; k * period <= last; ++k) subject.sample(k * period, handle(k * period));
    BOOST_REQUIRE(subject.result(9, 41, start));
    return std::pair(subject.model, subject.metric("prediction.resimulated_steps"));
  };
  const Duration least = default_params<LocalPredictor>().min_step;
  const auto [slow, slow_steps] = rolled(1, 40, least);
  const auto [fast, fast_steps] = rolled(0.25, 40.25, least);
  const auto [each, each_steps] = rolled(0.25, 40.25, Duration{});
  BOOST_TEST(slow_steps == 31);
  BOOST_TEST(fast_steps == 32);  // the last one, a quarter of a millisecond, to the newest sample
  BOOST_TEST(each_steps == 125);
  BOOST_TEST(fast.time.ns == 40'250'000);
  BOOST_TEST((fast.device.X_WD.p == handle(40.25).X_WD.p));
  // The tool goes 10 mm after the handle; longer steps of an implicit Euler are off by about a hundredth of that.
  BOOST_TEST(norm(fast.bodies.X_WB[0].p - each.bodies.X_WB[0].p) < 2e-4);
}

BOOST_AUTO_TEST_CASE(poor_samples_are_left_out_and_poor_results_send_nothing) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  Subject clean, subject;
  BOOST_TEST(!subject.result(0, 1, one_body({0.02, 0, 0})));  // no sample yet
  for (int ms = 0; ms <= 30; ++ms) {
    clean.sample(ms, handle(ms));
    subject.sample(ms, handle(ms));
    if (ms == 30) break;
    DeviceState poor = handle(ms);
    switch (ms % 5) {
      case 0:
        poor.X_WD.p.x = std::nan("");
        break;
      case 1:
        poor.V_WD.v.y = inf;
        break;
      case 2:
        poor.X_WD.R = {0, 0, 0, 0};
        break;
      case 3:
        poor.V_WD.w.z = std::nan("");
        break;
      default:
        poor.X_WD.R.x = std::nan("");
        break;
    }
    subject.sample(ms + 0.5, poor);
  }
  const BodyStates good = one_body({0.02, 0, 0});
  BOOST_REQUIRE(clean.result(10, 30, good));
  BOOST_REQUIRE(subject.result(10, 30, good));
  BOOST_TEST((subject.model.bodies.X_WB[0].p == clean.model.bodies.X_WB[0].p));
  BOOST_TEST(subject.metric("prediction.rejected_samples") == 30.0);

  BodyStates bad = good;
  bad.X_WB[0].p.y = std::nan("");
  BOOST_TEST(!subject.result(20, 31, bad));
  bad = good;
  bad.count = 2;
  BOOST_TEST(!subject.result(21, 32, bad));
  LocalContacts foreign = wall_around({{0.02, 0, 0}});
  for (const int count : {-1, LocalContacts::capacity + 1, 1 << 30}) {
    foreign.count = count;
    subject.contacts(foreign);
    BOOST_TEST(!subject.result(22, 33, good));
  }
  BOOST_TEST(subject.metric("prediction.rejected_results") == 5.0);
  // Why, for who asks why no force came.
  const Refusals& refusals = subject.refusals();
  BOOST_TEST(refusals.came() == 6U);
  BOOST_TEST(refusals.refused(RefusalReason::not_finite) == 1U);
  BOOST_TEST(refusals.refused(RefusalReason::another_scene) == 1U);
  BOOST_TEST(refusals.refused(RefusalReason::too_many) == 3U);
  BOOST_TEST(refusals.found() == 1 << 30);
  BOOST_TEST(refusals.room() == LocalContacts::capacity);
  subject.contacts({});
  BOOST_TEST(subject.result(23, 34, good));
}

BOOST_AUTO_TEST_CASE(a_result_between_two_samples_meets_the_handle_between_them) {
  const BodyStates bodies = one_body({0.02, 0, 0}, {0.05, 0, 0});
  const auto wrench_of = [&](double ms, const DeviceState& d) {
    Subject subject(default_params<LocalPredictor>(), false);
    for (int k = 0; k <= 30; ++k) subject.sample(k, handle(k));
    BOOST_REQUIRE(subject.result(ms, 30, bodies));
    const CouplingParameters& c = subject.coupling;
    const Vec3 expected = -c.k_t * (d.X_WD.p - bodies.X_WB[0].p) - c.b_t * (d.V_WD.v - bodies.V_WB[0].v);
    BOOST_TEST(norm(subject.model.wrench_result.force - expected) < 1e-12);
  };
  wrench_of(10, handle(10));
  DeviceState between_samples;
  between_samples.X_WD.p = 0.75 * handle(10).X_WD.p + 0.25 * handle(11).X_WD.p;
  between_samples.V_WD.v = 0.75 * handle(10).V_WD.v + 0.25 * handle(11).V_WD.v;
  wrench_of(10.25, between_samples);
}

BOOST_AUTO_TEST_CASE(contacts_that_came_with_a_result_are_gone_on_from_where_no_query_tells_others) {
  const BodyStates bodies = one_body({0.0098, 0, 0}, {-0.02, 0, 0});
  const Physics physics(true);
  const auto started = [&](bool with_contacts) {
    auto subject = std::make_unique<Subject>(default_params<LocalPredictor>(), with_contacts);
    for (int ms = 0; ms <= 30; ++ms) subject->sample(ms, handle(ms));
    return subject;
  };
  const auto queried = started(true), told = started(false), untold = started(false);
  queried->contacts(wall_for_one(physics, bodies));
  ContactSet set;
  set.bodies = bodies;
  set.count = 1;
  set.contact[0] = physics.contact(bodies.X_WB[0]);
  ContactSet older = set;
  older.contact[0].distance = 1;
  told->found(9, older);
  told->found(10, set);
  for (const auto* subject : {&queried, &told, &untold}) BOOST_REQUIRE((*subject)->result(10, 30, bodies));
  BOOST_TEST((told->model.bodies.X_WB[0].p == queried->model.bodies.X_WB[0].p));
  BOOST_TEST(norm(told->model.bodies.X_WB[0].p - untold->model.bodies.X_WB[0].p) > 1e-5);
  BOOST_TEST(told->model.contacts.count == 1);
  // Of more than a rollout takes, those that are nearest.
  set.count = LocalContacts::capacity + 1;
  for (std::size_t i = 1; i <= LocalContacts::capacity; ++i) {
    set.contact[i] = set.contact[0];
    set.contact[i].distance = 1;
  }
  std::swap(set.contact[0], set.contact[LocalContacts::capacity]);
  told->found(11, set);
  BOOST_REQUIRE(told->result(11, 31, bodies));
  const LocalContacts& kept = told->model.contacts;
  BOOST_TEST(kept.count == LocalContacts::capacity);
  BOOST_TEST(kept.contact[LocalContacts::capacity - 1][0].distance < 1);
}

BOOST_AUTO_TEST_CASE(a_result_whose_own_contacts_have_not_come_is_refused) {
  const BodyStates bodies = one_body({0.0098, 0, 0}, {-0.02, 0, 0});
  Subject subject(default_params<LocalPredictor>(), false);
  for (int ms = 0; ms <= 30; ++ms) subject.sample(ms, handle(ms));
  ContactSet empty;
  empty.bodies = bodies;
  for (const double stamp : {9.0, 10.5}) subject.found(stamp, empty);
  BOOST_TEST(!subject.result(10, 30, bodies));
  BOOST_TEST(subject.refusals().refused(RefusalReason::incomplete) == 1U);
  BOOST_TEST(subject.metric("prediction.rejected_results") == 1.0);
  subject.found(11, empty);
  BOOST_TEST(subject.result(11, 31, bodies));
  BOOST_TEST(subject.model.contacts.count == 0);
  BOOST_TEST(subject.refusals().refused() == 1U);
}

BOOST_AUTO_TEST_CASE(a_sample_whose_quaternion_is_not_of_length_one_is_that_rotation) {
  Subject subject;
  DeviceState state = handle(5);
  state.X_WD.R = {2, 0, 0, 1};
  subject.sample(5, state);
  BOOST_REQUIRE(subject.result(0, 5, one_body({0.02, 0, 0})));
  const Quat& R = subject.model.device.X_WD.R;
  BOOST_TEST(R.w == 2 / std::sqrt(5.0), tt::tolerance(1e-15));
  BOOST_TEST(R.z == 1 / std::sqrt(5.0), tt::tolerance(1e-15));
}

BOOST_AUTO_TEST_CASE(without_resimulation_the_bodies_of_the_result_meet_the_newest_sample) {
  auto params = default_params<LocalPredictor>();
  params.resimulate = false;
  Subject subject(params);
  for (int ms = 0; ms <= 30; ++ms) subject.sample(ms, handle(ms));
  const BodyStates bodies = one_body({0.011, 0, 0}, {0.1, 0, 0});
  BOOST_REQUIRE(subject.result(10, 30, bodies));
  BOOST_TEST((subject.model.bodies.X_WB[0].p == bodies.X_WB[0].p));
  BOOST_TEST((subject.model.bodies.V_WB[0].v == bodies.V_WB[0].v));
  BOOST_TEST(subject.model.time.ns == 30'000'000);
  BOOST_TEST((subject.model.device.X_WD.p == handle(30).X_WD.p));
  BOOST_TEST(subject.metric("prediction.resimulated_steps") == 0.0);
}

BOOST_AUTO_TEST_CASE(scales_are_those_of_dynamics_with_such_a_wall) {
  auto params = default_params<LocalPredictor>();
  params.stiffness_scale = 0.5;
  params.friction_scale = 2;
  Physics other(true, 1000, 0.6);
  Subject subject(params), as_is, unscaled;
  for (int ms = 0; ms <= 100; ++ms) {
    for (Subject* s : {&subject, &as_is, &unscaled}) s->sample(ms, handle(ms));
  }
  const BodyStates start = one_body({0.0095, 0, 0}, {-0.05, 0.05, 0});
  Physics physics(true);
  subject.contacts(wall_for(physics, start.X_WB[0].p));
  unscaled.contacts(wall_for(physics, start.X_WB[0].p));
  // Damping goes with stiffness.
  LocalContacts halved = wall_for(other, start.X_WB[0].p);
  for (Contact& c : halved.contact[0]) c.damping = 1.5;
  as_is.contacts(halved);
  for (Subject* s : {&subject, &as_is, &unscaled}) BOOST_REQUIRE(s->result(60, 100, start));
  BOOST_TEST(norm(subject.model.bodies.X_WB[0].p - as_is.model.bodies.X_WB[0].p) < 1e-15);
  BOOST_TEST(norm(subject.model.bodies.X_WB[0].p - unscaled.model.bodies.X_WB[0].p) > 1e-5);
  BOOST_TEST(subject.model.contacts.contact[0][2].stiffness == 1000.0);
}

namespace {

/// How far a model of the wall that is wrong by these factors is from dynamics, m: the mean over results while the tool
/// touches, but for the first two. `state`: what becomes of physics' contact force.
enum class State { none, there, late, not_finite, damped };
struct Run {
  double error = 0;
  Contact last;
  std::map<std::string, double> metrics;
};
Run wrong_wall(double stiffness, double friction, State state, bool fit = true) {
  auto params = default_params<LocalPredictor>();
  params.stiffness_scale = stiffness;
  params.friction_scale = friction;
  params.fit = fit;
  Physics physics(true), ahead(true);
  Subject subject(params, true, state != State::none);
  Run run;
  int touching = 0;
  for (int ms = 0; ms <= 900; ++ms) {
    physics.sample(ms, handle(ms));
    ahead.sample(ms, handle(ms));
    subject.sample(ms, handle(ms));
    if (ms < 30 || ms % 20 != 0) continue;
    const BodyStates then = physics.step(ms - 17);
    const BodyStates& now = ahead.step(ms);
    PhysicsState told = physics.state();
    const bool touches = told.contacts > 0;
    if (state == State::not_finite) told.contact_T_W.force.x = std::nan("");
    if (state == State::damped) told.damped = 1;
    if (state != State::none) subject.physics(physics.valid_ms() - (state == State::late ? 1 : 0), told);
    subject.contacts(wall_for(physics, then.X_WB[0].p));
    BOOST_REQUIRE(subject.result(physics.valid_ms(), ms, then));
    if (!touches || ++touching <= 2) continue;
    run.error += norm(subject.model.bodies.X_WB[0].p - now.X_WB[0].p);
  }
  BOOST_REQUIRE(touching > 10);
  run.error /= touching - 2;
  run.last = subject.model.contacts.contact[0][2];
  run.metrics = subject.metrics();
  return run;
}

}  // namespace

BOOST_AUTO_TEST_CASE(with_physics_force_a_wrong_model_of_the_wall_comes_to_where_dynamics_does) {
  const struct { double stiffness, friction; } models[] = {{0.5, 1}, {2, 1}, {1, 0}, {1, 2}, {0.5, 2}};
  for (const auto& m : models) {
    const Run wrong = wrong_wall(m.stiffness, m.friction, State::none);
    const Run fitted = wrong_wall(m.stiffness, m.friction, State::there);
    BOOST_TEST(wrong.error > 1e-6);
    BOOST_TEST(fitted.error < wrong.error / 10);
    BOOST_TEST(fitted.last.stiffness == 2000, tt::tolerance(0.03));
    BOOST_TEST(fitted.last.damping == 3, tt::tolerance(0.03));
    BOOST_TEST(std::abs(fitted.last.friction - 0.3) < 0.03);
    BOOST_TEST(fitted.metrics.at("local.fit.stiffness_scale") == 1 / m.stiffness, tt::tolerance(0.03));
    BOOST_TEST(std::abs(fitted.metrics.at("local.fit.friction_excess") - 0.3 * (1 - m.friction)) < 0.03);
    BOOST_TEST(fitted.metrics.at("local.fit.results") > 10.0);
    BOOST_TEST(fitted.metrics.at("local.fit.left_out") == 0.0);
  }
  const Run exact = wrong_wall(1, 1, State::there);
  BOOST_TEST(exact.error < rounding);
  BOOST_TEST(std::abs(exact.metrics.at("local.fit.stiffness_scale") - 1) < 1e-3);
}

BOOST_AUTO_TEST_CASE(a_force_of_another_time_or_law_or_not_finite_or_that_is_not_asked_for_is_not_used) {
  const Run without = wrong_wall(0.5, 1, State::none);
  for (const State state : {State::late, State::not_finite, State::damped}) {
    const Run run = wrong_wall(0.5, 1, state);
    BOOST_TEST(run.error == without.error);
    BOOST_TEST(run.last.stiffness == 1000);
    BOOST_TEST(run.metrics.at("local.fit.left_out") > 10.0);
    BOOST_TEST(run.metrics.at("local.fit.results") == 0.0);
  }
  const Run off = wrong_wall(0.5, 1, State::there, false);
  BOOST_TEST(off.error == without.error);
  BOOST_TEST(off.last.stiffness == 1000);
  BOOST_TEST(!off.metrics.contains("local.fit.stiffness_scale"));
}

BOOST_AUTO_TEST_CASE(without_curvature_contacts_are_planes) {
  auto params = default_params<LocalPredictor>();
  params.curvature = false;
  Subject subject(params);
  for (int ms = 0; ms <= 20; ++ms) subject.sample(ms, handle(ms));
  LocalContacts round = wall_around({{0.009, 0, 0}, {0.008, 0, 0}});
  for (Contact& c : round.contact[0]) c.H_W = {0, 0, 0, 30, 0, 30};
  subject.contacts(round);
  BOOST_REQUIRE(subject.result(10, 20, one_body({0.009, 0, 0})));
  for (std::size_t j = 0; j < 2; ++j) BOOST_TEST((subject.model.contacts.contact[0][j].H_W == std::array<double, 6>{}));
}

BOOST_AUTO_TEST_CASE(no_step_calls_the_heap, *boost::unit_test::precondition(tactor::test::heap_is_counted)) {
  Subject subject(default_params<LocalPredictor>(), true, true);
  subject.contacts(wall_around({{0.009, 0, 0}, {0.0088, 0, 0}, {0.0086, 0, 0}}));
  PhysicsState state;
  state.contact_T_W.force = {0.9, -0.2, 0};
  state.contacts = 1;
  std::int64_t calls = 0;
  for (int ms = 0; ms < 700; ++ms) {
    subject.sample(ms, handle(ms));
    if (ms % 10 != 9) continue;
    const BodyStates bodies = one_body({0.0095, 0, 0}, {0, 0.05, 0});
    subject.physics(ms - 9, state);
    const std::int64_t before = thread_heap_calls();
    subject.result(ms - 9, ms, bodies);
    calls += thread_heap_calls() - before;
  }
  BOOST_TEST(calls == 0);
  BOOST_TEST(subject.metric("local.fit.results") == 70.0);
}

BOOST_AUTO_TEST_CASE(integrator_and_stick_velocity_are_those_of_dynamics_unless_a_graph_gives_them) {
  const NodeInfo info = LocalPredictor::declare();
  for (const std::string name : {"integrator", "stick_velocity"}) {
    const auto param =
        std::find_if(info.params.begin(), info.params.end(), [&](const ParamInfo& p) { return p.name == name; });
    BOOST_REQUIRE((param != info.params.end()));
    BOOST_TEST((param->as_in == Role::dynamics));
  }
}

BOOST_AUTO_TEST_SUITE_END()
