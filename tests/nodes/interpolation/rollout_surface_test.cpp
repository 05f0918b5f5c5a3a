// interpolation.rollout with contacts found anew: on a surface that ends, against physics that is elsewhere, slow or
// dead.
#include <boost/test/unit_test.hpp>

#include "tests/nodes/interpolation/rollout_subject.hpp"

BOOST_AUTO_TEST_SUITE(rollout_surface_test)

using namespace tactor;
using namespace tactor::test;

namespace {

/// The ball over a fixed box whose face is x = 0 and whose edge is at y = 0: there the surface ends.
Scene box_scene() {
  Scene scene = ball_scene(0.1);
  Body box;
  box.name = "box";
  box.shape = BoxShape{{0.1, 0.1, 0.1}};
  box.X_WB.p = {-0.05, -0.05, 0};
  box.material = {.stiffness = 2000, .damping = 4, .friction = 0};
  scene.bodies.push_back(box);
  scene.bodies[0].material = {.stiffness = 2000, .damping = 4, .friction = 0};
  return scene;
}

}  // namespace

BOOST_AUTO_TEST_CASE(contacts_that_are_found_anew_need_no_results_after_the_first) {
  // No model has contacts, and the one that comes later has its tool in the wrong place.
  Subject subject(box_scene(), on_surface());
  Truth truth(0);
  double worst = 0, largest = 0;
  for (int ms = 0; ms <= 1500; ++ms) {
    const DeviceState handle{{{Handle::x(1e-3 * ms), -0.03, 0}, {}}, {{Handle::v(1e-3 * ms), 0, 0}, {}}, 0};
    subject.sample(ms, handle);
    if (ms % 20 == 5) {
      const double off = ms == 5 ? 0 : ms % 40 == 5 ? 0.003 : -0.003;
      if (ms == 5) truth.advance(1e-3 * ms);
      const BodyStates bodies = one_body({truth.bodies().X_WB[0].p.x + off, -0.03, 0}, truth.bodies().V_WB[0].v);
      subject.model(ms - 20, ms, model_at(ms, bodies, handle.X_WD.p, {}, handle.V_WD.v));
    }
    if (!subject.tick(ms)) continue;
    truth.advance(1e-3 * (ms + 1));
    if (ms < 100) continue;
    worst = std::max(worst, std::abs(subject.force(ms + 1).x - truth.reaction()));
    largest = std::max(largest, std::abs(truth.reaction()));
  }
  BOOST_TEST(largest > 1.0);
  // What steps of 1 ms make of it, with no result to go back to.
  BOOST_TEST(worst < 0.02 * largest);
  BOOST_TEST(subject.metric("rollout.anchored_steps") == 0.0);
  BOOST_TEST(subject.metric("rollout.disagreements") == 0.0);
}

BOOST_AUTO_TEST_CASE(a_tool_that_slides_off_an_edge_is_let_go_though_no_result_has_said_so) {
  const auto force_beyond = [](const Rollout::Params& params) {
    Subject subject(box_scene(), params);
    const LocalContacts wall = wall_around({{0.009, -0.01, 0}, {0.009, -0.008, 0}});
    double y = 0;
    for (int ms = 0; ms <= 150; ++ms) {
      y = -0.01 + 0.0003 * ms;
      const DeviceState handle{{{0.008, y, 0}, {}}, {{0, 0.3, 0}, {}}, 0};
      subject.sample(ms, handle);
      if (ms == 0)
        subject.model(-10, 0, model_at(0, one_body({0.009, y, 0}, {0, 0.3, 0}), handle.X_WD.p, wall, {0, 0.3, 0}));
      subject.tick(ms);
    }
    BOOST_REQUIRE(y > 0.0195);  // a centre so far beyond the edge, 8 mm above the face, touches nothing
    return norm(subject.force(151));
  };
  BOOST_TEST(force_beyond(on_surface()) < 0.02);
  BOOST_TEST(force_beyond(anchored()) > 0.3);
}

BOOST_AUTO_TEST_CASE(a_tool_that_physics_keeps_having_elsewhere_goes_there_when_patience_ends) {
  auto params = on_surface();
  params.patience = Duration::from_seconds(0.25);
  for (const bool same_way : {true, false}) {
    Subject subject(box_scene(), params);
    const Vec3 handle{0.03, -0.03, 0};
    int sent = 0;
    for (int ms = 0; ms <= 600; ++ms) {
      subject.sample(ms, handle);
      if (ms % 20 == 0) {
        const double off = same_way || ++sent % 2 == 0 ? 0.002 : -0.002;
        subject.model(ms - 20, ms + 1, model_at(ms, one_body({0.03 + (ms == 0 ? 0 : off), -0.03, 0}), handle, {}));
      }
      subject.tick(ms);
    }
    // The first that is off comes at 20 ms, the last at 600 ms; patience is 250 ms here, and after each time it begins
    // anew.
    BOOST_TEST(subject.metric("rollout.disagreements") == (same_way ? 2.0 : 0.0));
  }
}

BOOST_AUTO_TEST_CASE(a_tool_that_physics_has_far_away_goes_there_at_once) {
  for (const double off : {0.019, 0.021}) {
    Subject subject(box_scene(), default_params<Rollout>());
    const Vec3 handle{0.06, -0.03, 0};
    for (int ms = 0; ms <= 45; ++ms) {
      subject.sample(ms, handle);
      if (ms % 20 == 0)
        subject.model(ms - 20, ms + 1, model_at(ms, one_body({0.06 + (ms == 40 ? off : 0), -0.03, 0}), handle, {}));
      subject.tick(ms);
    }
    BOOST_TEST(subject.metric("rollout.disagreements") == (off > 0.02 ? 1.0 : 0.0));
  }
}

BOOST_AUTO_TEST_CASE(a_hold_is_displayed_where_it_has_been_nearer_to_physics_than_the_rollout) {
  // A tool on the box, and physics that feels another force there: of a law that the rollout does not know.
  const auto ticks = [](const Vec3& felt, double law_error, double worse) {
    auto params = default_params<Rollout>();
    params.worse = worse;
    Subject subject(box_scene(), params);
    const Vec3 handle{0.008, -0.03, 0};
    for (int ms = 0; ms <= 1000; ++ms) {
      subject.sample(ms, handle);
      if (ms % 20 == 0) {
        LocalModel m = model_at(ms, one_body({0.028 / 3, -0.03, 0}), handle, {});
        m.wrench_result.force = felt;
        m.law_error = law_error;
        subject.model(ms - 20, ms + 1, m);
      }
      subject.tick(ms);
    }
    if (subject.metric("rollout.outdone_ticks") > 0) BOOST_TEST(norm(subject.force(1001) - felt) < 1e-3);
    return subject.metric("rollout.outdone_ticks");
  };
  BOOST_TEST(ticks({3, 0, 0}, 2, 1.2) > 700.0);  // from the eighth result on
  BOOST_TEST(ticks({3, 0, 0}, 2, 1e6) == 0.0);
  BOOST_TEST(ticks({3, 0, 0}, 0.1, 1.2) == 0.0);  // the law is the same: it is physics' steps that are coarse
  BOOST_TEST(ticks({500.0 * 1000 / 1500 * 0.002, 0, 0}, 2, 1.2) == 0.0);  // springs in series, 2 mm deep together
}

BOOST_AUTO_TEST_CASE(physics_of_another_law_is_compared_by_the_forces_alone_and_between_samples_too) {
  const auto ticks = [](bool of_another_law, double after_sample) {
    auto params = default_params<Rollout>();
    Subject subject(box_scene(), params);
    const Vec3 handle{0.008, -0.03, 0};
    for (int ms = 0; ms <= 1000; ++ms) {
      subject.sample(ms, handle);
      if (ms % 20 == 0) {
        LocalModel m = model_at(ms, one_body({0.028 / 3, -0.03, 0}), handle, {});
        m.wrench_result.force = {3, 0, 0};
        m.law_unknown = of_another_law ? 1 : 0;
        subject.model(ms - 20 + after_sample, ms + 1, m);
      }
      subject.tick(ms);
    }
    if (subject.metric("rollout.outdone_ticks") > 0) BOOST_TEST(norm(subject.force(1001) - Vec3{3, 0, 0}) < 1e-3);
    return subject.metric("rollout.outdone_ticks");
  };
  BOOST_TEST(ticks(true, 0) > 700.0);
  BOOST_TEST(ticks(true, 0.5) > 700.0);
  BOOST_TEST(ticks(false, 0) == 0.0);
  BOOST_TEST(ticks(false, 0.5) == 0.0);
}

BOOST_AUTO_TEST_CASE(slow_physics_is_trusted_for_three_of_its_periods_and_dead_physics_is_not) {
  const auto fallbacks = [](int period, int last) {
    Subject subject(box_scene(), on_surface());
    const Vec3 handle{0.03, -0.03, 0};
    for (int ms = 0; ms <= 2000; ++ms) {
      subject.sample(ms, handle);
      if (ms % period == 0 && ms <= last) subject.model(ms, ms, model_at(ms, one_body(handle), handle, {}));
      subject.tick(ms);
    }
    return subject.metric("fallbacks");
  };
  BOOST_TEST(fallbacks(300, 2000) == 50.0);     // from 250 ms on, until the second result at 300 ms tells the period
  BOOST_TEST(fallbacks(300, 900) == 251.0);     // and from 900 + 900 ms on
  BOOST_TEST(fallbacks(20, 900) == 851.0);      // from 900 + 250 ms on
  BOOST_TEST(fallbacks(600, 1800) == 350.0);    // from 250 to 600 ms, then none up to 1 s of age
  BOOST_TEST(fallbacks(1500, 2000) == 1501.0);  // longer than trust_time_max: as if it had died
}

BOOST_AUTO_TEST_CASE(segments_state_for_how_long_their_result_is_trusted) {
  const auto trust_ms = [](int period, int late, int results) {
    Subject subject(box_scene(), default_params<Rollout>());
    const Vec3 handle{0.03, -0.03, 0};
    for (int ms = 0; ms <= late + period * (results - 1); ++ms) {
      subject.sample(ms, handle);
      if (ms >= late && (ms - late) % period == 0) {
        subject.model(ms - late, ms, model_at(ms - late, one_body(handle), handle, {}));
      }
      subject.tick(ms);
    }
    return subject.shown().trust_time.ns / 1'000'000;
  };
  BOOST_TEST(trust_ms(20, 20, 3) == 250);    // the parameter
  BOOST_TEST(trust_ms(125, 125, 1) == 375);  // the first result was as long in the making
  BOOST_TEST(trust_ms(125, 0, 1) == 250);    // that told nothing
  BOOST_TEST(trust_ms(125, 0, 2) == 375);    // three periods
  BOOST_TEST(trust_ms(400, 0, 2) == 1000);   // trust_time_max
  BOOST_TEST(trust_ms(1500, 0, 2) == 250);   // longer than that: as if it had died
}

BOOST_AUTO_TEST_CASE(where_finding_contacts_is_too_much_work_those_of_the_model_serve_and_are_counted) {
  auto params = on_surface();
  Scene scene = box_scene();
  scene.bodies[0].shape = BoxShape{{0.02, 0.02, 0.02}};
  const auto steps_on_anchors = [&](int work) {
    params.most_work = work;
    Subject subject(scene, params);
    for (int ms = 0; ms <= 100; ++ms) {
      const Vec3 handle{0.008, -0.03, 0};
      subject.sample(ms, handle);
      if (ms == 0)
        subject.model(-10, 0, model_at(0, one_body({0.0095, -0.03, 0}), handle, wall_around({{0.0095, -0.03, 0}})));
      subject.tick(ms);
    }
    BOOST_TEST(subject.force(101).x > 0.3);
    return subject.metric("rollout.anchored_steps");
  };
  BOOST_TEST(steps_on_anchors(1) == 100.0);
  BOOST_TEST(steps_on_anchors(100'000) == 0.0);
}

BOOST_AUTO_TEST_SUITE_END()
