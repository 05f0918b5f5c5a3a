// effect.impact: when it vibrates, with which forces, and within which limits.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "nodes/effect/impact.hpp"
#include "tests/nodes/effect/stage_rig.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(impact_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr double T = 1e-3;
const DeviceDynamics one_body{.mass = 0.1, .hand_mass = 0.4};

/// A device of 0.5 kg and nothing else, so that force is mass times acceleration.
Impact::Params params_of_mass() {
  auto p = default_params<Impact>();
  static_cast<DeviceDynamics&>(p) = one_body;
  p.effort = 1e-6;
  p.amplitude = 10;
  p.frequency = 80;
  return p;
}

double wanted(double amplitude, double frequency, double decay, double t) {
  return amplitude * std::exp(-t / decay) * std::sin(2 * std::numbers::pi * frequency * t);
}

}  // namespace

BOOST_AUTO_TEST_CASE(means_over_ticks_are_those_of_the_sinusoid) {
  const std::vector<double> means = decaying_sinusoid(10, 80, 0.01, T, 30);
  for (std::size_t n = 0; n < means.size(); ++n) {
    double sum = 0;
    constexpr int parts = 1000;
    for (int i = 0; i < parts; ++i) sum += wanted(10, 80, 0.01, (static_cast<double>(n) + (i + 0.5) / parts) * T);
    BOOST_TEST(std::abs(means[n] - sum / parts) < 1e-5);
  }
}

BOOST_AUTO_TEST_CASE(the_tick_response_is_that_of_small_steps_of_the_equations) {
  const std::vector<DeviceDynamics> devices{one_body,
                                            {.mass = 0.1,
                                             .damping = 0.5,
                                             .hand_mass = 0.3,
                                             .hand_damping = 6,
                                             .hand_stiffness = 200,
                                             .amplifier_bandwidth = 200},
                                            {.mass = 0.2,
                                             .damping = 0.3,
                                             .hand_mass = 0.55,
                                             .hand_damping = 6.5,
                                             .hand_stiffness = 135,
                                             .amplifier_bandwidth = 1100,
                                             .mode_frequency = 86,
                                             .mode_damping = 0.05,
                                             .motor_share = 0.4},
                                            {.mass = 0.1,
                                             .damping = 0.5,
                                             .hand_mass = 0.3,
                                             .hand_damping = 6,
                                             .hand_stiffness = 200,
                                             .grip_stiffness = 900,
                                             .grip_damping = 2},
                                            {.mass = 0.2,
                                             .damping = 0.3,
                                             .hand_mass = 0.55,
                                             .hand_damping = 6.5,
                                             .hand_stiffness = 135,
                                             .grip_damping = 3,
                                             .amplifier_bandwidth = 1100,
                                             .mode_frequency = 86,
                                             .mode_damping = 0.05,
                                             .motor_share = 0.4}};
  for (const DeviceDynamics& d : devices) {
    const std::vector<double> response = tick_response(d, T, 60);
    constexpr int steps = 2000;
    const double h = T / steps;
    const bool grip = d.grip_stiffness > 0 || d.grip_damping > 0;
    const double m_1 = d.motor_share * d.mass, rest = d.mode_frequency > 0 ? d.mass - m_1 : d.mass;
    const double m_2 = grip ? rest : rest + d.hand_mass;
    const double turn = 2 * std::numbers::pi * d.mode_frequency, reduced = m_1 * (d.mass - m_1) / d.mass;
    const double k = turn * turn * reduced, c = 2 * d.mode_damping * turn * reduced;
    double x_1 = 0, v_1 = 0, x_2 = 0, v_2 = 0, x_h = 0, v_h = 0, f = 0;
    double largest = 0;
    for (const double r : response) largest = std::max(largest, std::abs(r));
    for (std::size_t n = 0; n < response.size(); ++n) {
      const double before = v_2;
      for (int i = 0; i < steps; ++i) {
        const double u = n == 0 ? 1 : 0;
        f = d.amplifier_bandwidth > 0 ? f + h * 2 * std::numbers::pi * d.amplifier_bandwidth * (u - f) : u;
        // What the hand does to the handle.
        double hand = -d.hand_damping * v_2 - d.hand_stiffness * x_2;
        if (grip) {
          hand = d.grip_stiffness * (x_h - x_2) + d.grip_damping * (v_h - v_2);
          v_h += h * (-hand - d.hand_damping * v_h - d.hand_stiffness * x_h) / d.hand_mass;
          x_h += h * v_h;
        }
        if (d.mode_frequency > 0) {
          const double s = k * (x_2 - x_1) + c * (v_2 - v_1);
          v_1 += h * (f - d.damping * v_1 + s) / m_1;
          v_2 += h * (hand - s) / m_2;
          x_1 += h * v_1;
        } else {
          v_2 += h * (f - d.damping * v_2 + hand) / m_2;
        }
        x_2 += h * v_2;
      }
      BOOST_TEST(std::abs(response[n] - (v_2 - before) / T) < 2e-3 * largest);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_mass_is_pushed_by_mass_times_acceleration_scaled_by_the_impact) {
  StageRig<Impact> rig(params_of_mass());
  const Vec3 n = Vec3{1, 2, 2} / 3.0;
  const double speed = 0.15;
  for (int ms = 0; ms < 100; ++ms) BOOST_TEST(norm(rig.tick(ms, {}, -speed * n)) == 0.0);
  const std::vector<double> means = decaying_sinusoid(10, 80, 0.01, T, 40);
  const Vec3 base = 0.5 * n;
  for (int k = 0; k < 40; ++k) {
    // Sideways speed does not count, and that of later ticks neither.
    const Vec3 velocity = k == 0 ? -speed * n + Vec3{0.3, 0, -0.15} : Vec3{};
    const Vec3 added = rig.tick(100 + k, base, velocity) - base;
    BOOST_TEST(norm(added - (0.5 * speed * means[static_cast<std::size_t>(k)]) * n) < 1e-5);
    BOOST_TEST(rig.valid.ns == stamp_ms(100 + k).valid.ns);
    BOOST_TEST(rig.last.trust_time.ns == 7'000'000);
  }
  BOOST_TEST(rig.metrics()["impact.events"] == 1.0);
  BOOST_TEST(rig.metrics()["impact.match_error"] < 1e-5);
}

BOOST_AUTO_TEST_CASE(a_recorded_profile_takes_the_place_of_the_sinusoid) {
  auto p = params_of_mass();
  p.profile = {2, {0, 0, 0.002, 8, 0.005, -4, 0.008, 0}};
  StageRig<Impact> rig(p);
  rig.tick(0, {}, {});
  // Between rows it is straight: the mean over a tick is the value at its middle, but where a row lies in it.
  const std::vector<double> means{2, 6, 6, 2, -2, -10.0 / 3, -2, -2.0 / 3, 0};
  for (std::size_t k = 0; k < means.size(); ++k) {
    const Vec3 added = rig.tick(100 + static_cast<int>(k), {0, 0, 1}, {0, 0, -0.2}) - Vec3{0, 0, 1};
    BOOST_TEST(std::abs(added.z - 0.5 * 0.2 * means[k]) < 1e-5);
  }
}

BOOST_AUTO_TEST_CASE(without_a_contact_that_begins_fast_everything_passes_as_it_came) {
  StageRig<Impact> rig(params_of_mass());
  // Slow; away from the surface; and a force that was there a moment ago.
  rig.tick(0, {}, {});
  for (int ms = 1; ms < 60; ++ms) BOOST_TEST(rig.tick(ms, {0, 0, 1}, {0, 0, -0.01}).z == 1.0);
  for (int ms = 200; ms < 260; ++ms) rig.tick(ms, {}, {0, 0, -0.5});
  for (int ms = 260; ms < 300; ++ms) BOOST_TEST(rig.tick(ms, {0, 0, 1}, {0, 0, 0.5}).z == 1.0);
  for (int ms = 300; ms < 340; ++ms) rig.tick(ms, {}, {0, 0, -0.5});
  for (int ms = 340; ms < 360; ++ms) BOOST_TEST(rig.tick(ms, {0, 0, 1}, {0, 0, -0.5}).z == 1.0);
  BOOST_TEST(rig.metrics()["impact.events"] == 0.0);
  // A segment that came before is not sent again.
  StepContext step(stamp_ms(360).valid);
  rig.node.step(step);
  BOOST_TEST(rig.node.segment.pending() == 0U);
}

BOOST_AUTO_TEST_CASE(the_weight_and_inertia_of_a_tool_are_no_contact_where_physics_tells_of_contact) {
  const Vec3 weight{0, 0, -0.5}, up{0, 0, 0.3};
  // By the force alone, a tool that is lifted up quickly has met something.
  StageRig<Impact> by_force(params_of_mass());
  by_force.tick(0, {}, {});
  for (int ms = 100; ms < 110; ++ms) by_force.tick(ms, weight, up);
  BOOST_TEST(by_force.metrics()["impact.events"] == 1.0);

  StageRig<Impact> rig(params_of_mass());
  rig.touch(0, {}, {});
  for (int ms = 0; ms < 300; ++ms) {
    const Vec3 inertia{0, 0, ms % 100 < 50 ? 0 : 0.8};
    BOOST_TEST(norm(rig.tick(ms, weight + inertia, up) - weight - inertia) == 0.0);
  }
  // Physics tells of a surface with the normal n. What it takes for its handle may be a wave, and counts for nothing.
  const Vec3 n = Vec3{2, -1, 2} / 3.0;
  const double speed = 0.2;
  const Vec3 wave = -5 * n, approach = -speed * n + Vec3{0.3, 0, -0.3};
  rig.touch(300, 0.3 * n, wave);
  const std::vector<double> means = decaying_sinusoid(10, 80, 0.01, T, 40);
  for (int k = 0; k < 40; ++k) {
    const Vec3 added = rig.tick(300 + k, weight, k == 0 ? approach : Vec3{}) - weight;
    BOOST_TEST(norm(added - (0.5 * speed * means[static_cast<std::size_t>(k)]) * n) < 1e-5);
  }
  // It is pushed out and touches again: the same contact, until the surface has been left for a while.
  rig.touch(340, {}, {});
  for (int ms = 340; ms < 380; ++ms) rig.tick(ms, weight, {});
  rig.touch(380, 0.3 * n, wave);
  rig.tick(380, weight, approach);
  BOOST_TEST(rig.metrics()["impact.events"] == 1.0);
  rig.touch(381, {}, {});
  for (int ms = 381; ms < 440; ++ms) rig.tick(ms, weight, {});
  rig.touch(440, 0.3 * n, wave);
  rig.tick(440, weight, approach);
  BOOST_TEST(rig.metrics()["impact.events"] == 2.0);
  // What is not finite is no contact.
  rig.touch(500, {std::nan(""), 0, 0}, wave);
  rig.tick(500, weight, approach);
  rig.touch(600, 0.3 * n, wave);
  rig.tick(600, weight, {0, 0, -std::numeric_limits<double>::infinity()});
  BOOST_TEST(rig.metrics()["impact.events"] == 2.0);
}

BOOST_AUTO_TEST_CASE(the_speed_of_an_impact_is_that_of_the_handle_when_it_led_to_the_contact) {
  const std::vector<double> means = decaying_sinusoid(10, 80, 0.01, T, 40);
  for (const int late : {0, 12, 110}) {
    StageRig<Impact> rig(params_of_mass());
    rig.touch(0, {}, {});
    // Ever slower, and standing in the end.
    const auto speed = [](int ms) { return std::max(0.0, 0.5 - 0.001 * ms); };
    for (int ms = 0; ms < 300; ++ms) rig.tick(ms, {}, {0, 0, -speed(ms)});
    rig.touch(300 - late, {0, 0, 1}, {0, 0, 7});
    for (int k = 0; k < 40; ++k) {
      const double added = rig.tick(300 + k, {}, {0, 0, -speed(300 + k)}).z;
      BOOST_TEST(std::abs(added - 0.5 * speed(300 - late) * means[static_cast<std::size_t>(k)]) < 1e-5);
    }
  }
  // Nobody knows how fast it was before the first sample that is kept.
  StageRig<Impact> rig(params_of_mass());
  rig.touch(0, {}, {});
  for (int ms = 0; ms < 2000; ++ms) rig.tick(ms, {}, {0, 0, -0.2});
  rig.touch(500, {0, 0, 1}, {});
  rig.tick(2000, {}, {0, 0, -0.2});
  BOOST_TEST(rig.metrics()["impact.events"] == 0.0);
}

BOOST_AUTO_TEST_CASE(before_physics_has_spoken_nothing_touches) {
  StageRig<Impact> rig(params_of_mass());
  rig.node.contact.configure({QueuePolicy::latest, 1});
  for (int ms = 0; ms < 20; ++ms) BOOST_TEST(rig.tick(ms, {0, 0, 1}, {0, 0, -0.5}).z == 1.0);
  BOOST_TEST(rig.metrics()["impact.events"] == 0.0);
}

BOOST_AUTO_TEST_CASE(it_ends_within_the_slew_limit_too) {
  // What holds the hand where it has come to must not drop at once: after a slow push, after one that breaks off, and
  // after a vibration whose steps are small all along; each on a device of one body and on a soft one.
  std::vector<Impact::Params> all(3, params_of_mass());
  Table& slow = all[0].profile;
  slow.columns = 2;
  for (int i = 0; i <= 50; ++i) {
    slow.values.push_back(0.002 * i);
    slow.values.push_back(20 * std::sin(std::numbers::pi * i / 50));
  }
  all[1].profile = {2, {0, 20, 0.03, 20}};
  all[2].frequency = 30;
  all[2].decay = Duration::from_seconds(0.066);
  const DeviceDynamics stiff{
      .mass = 0.1, .damping = 0.2, .hand_mass = 0.55, .hand_damping = 6.5, .hand_stiffness = 135};
  DeviceDynamics soft = stiff;
  soft.amplifier_bandwidth = 500;
  soft.mode_frequency = 54;
  soft.mode_damping = 0.1;
  for (Impact::Params& p : all) {
    for (const DeviceDynamics& device : {stiff, soft}) {
      static_cast<DeviceDynamics&>(p) = device;
      p.effort = 0.02;
      for (const double speed : {0.03, 0.3, 3.0}) {
        StageRig<Impact> rig(p);
        rig.tick(0, {}, {});
        double last = 0, steepest = 0, peak = 0;
        int end = 0;
        for (int k = 0; k < 500; ++k) {
          rig.tick(100 + k, {0, 0, 0.1}, {0, 0, -speed});
          // A device that evaluates a curve at its begin.
          const double added = evaluate(rig.last, stamp_ms(100 + k).valid).force.z - 0.1;
          if (k > 0) steepest = std::max(steepest, std::abs(added - last));
          peak = std::max(peak, std::abs(added));
          if (std::abs(added) > 1e-12) end = k;
          last = added;
        }
        BOOST_TEST(peak > 0.05);
        BOOST_TEST(steepest <= 0.8 * p.force_slew * T + 1e-9);
        BOOST_TEST(end < 400 + 25);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(whatever_the_impact_force_and_steps_stay_within_the_device) {
  auto p = params_of_mass();
  p.force_max = 3;
  p.force_slew = 800;
  p.amplitude = 200;
  for (const double speed : {0.05, 0.5, 5.0}) {
    StageRig<Impact> rig(p);
    rig.tick(0, {}, {});
    double last = 0, steepest = 0;
    for (int k = 0; k < 80; ++k) {
      const double base = std::min(2.9, 0.1 + 0.05 * k);
      const double shown = rig.tick(100 + k, {0, 0, base}, {0, 0, -speed}).z;
      BOOST_TEST(std::abs(shown) <= 3 + 1e-9);
      if (k > 0) steepest = std::max(steepest, std::abs(shown - last));
      last = shown;
    }
    BOOST_TEST(steepest <= 0.8 + 1e-9);
    BOOST_TEST(rig.metrics()["impact.events"] == 1.0);
    BOOST_TEST(rig.metrics()["impact.limited_events"] == 1.0);
  }
  // A force that is larger than the limit by itself is the gate's to cut.
  StageRig<Impact> rig(p);
  rig.tick(0, {}, {});
  for (int k = 0; k < 20; ++k) BOOST_TEST(rig.tick(100 + k, {0, 0, 5}, {0, 0, -1}).z <= 5 + 1e-9);
}

BOOST_AUTO_TEST_CASE(what_is_not_finite_goes_on_to_the_gate_and_changes_nothing_else) {
  StageRig<Impact> rig(params_of_mass());
  rig.tick(0, {}, {});
  BOOST_TEST(std::isnan(rig.tick(1, {std::nan(""), 0, 0}, {}).x));
  for (int ms = 2; ms < 60; ++ms) BOOST_TEST(norm(rig.tick(ms, {}, {})) == 0.0);
  const double inf = std::numeric_limits<double>::infinity();
  BOOST_TEST(rig.tick(60, {0, 0, 1}, {0, 0, -inf}).z == 1.0);
  BOOST_TEST(rig.metrics()["impact.events"] == 0.0);
}

BOOST_AUTO_TEST_CASE(a_hand_without_mass_in_a_grip_is_refused) {
  auto p = params_of_mass();
  p.hand_mass = 0;
  StageRig<Impact> without_a_grip(p);
  p.grip_damping = 1;
  BOOST_CHECK_EXCEPTION(StageRig<Impact> rig(p), InputError, [](const InputError& e) {
    return std::string(e.what()).find("expected at least 0.001 kg where grip_stiffness or grip_damping") !=
           std::string::npos;
  });
}

BOOST_AUTO_TEST_CASE(profiles_that_are_none_are_refused) {
  for (const Table& table : {Table{2, {0, 1}}, Table{2, {0, 1, 0, 2}}, Table{2, {0.001, 1, 0.002, 2}},
                             Table{2, {0, 1, 0.001, std::nan("")}}}) {
    auto p = params_of_mass();
    p.profile = table;
    BOOST_CHECK_THROW(StageRig<Impact> rig(p), InputError);
  }
}

BOOST_AUTO_TEST_CASE(no_step_calls_the_heap, *boost::unit_test::precondition(tactor::test::heap_is_counted)) {
  StageRig<Impact> rig(params_of_mass());
  rig.tick(0, {}, {});
  const std::int64_t before = thread_heap_calls();
  for (int ms = 1; ms < 1000; ++ms) rig.tick(ms, {0, 0, ms % 200 > 100 ? 1.0 : 0.0}, {0, 0, -0.2});
  BOOST_TEST(thread_heap_calls() - before == 0);
  BOOST_TEST(rig.metrics()["impact.events"] == 5.0);
}

BOOST_AUTO_TEST_SUITE_END()
