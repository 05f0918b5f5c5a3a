// forcefield.grid: what it stores where, what it displays when, and what it keeps out.
#include <boost/test/unit_test.hpp>

#include "framework/core/segment.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "nodes/forcefield/grid.hpp"
#include "tests/nodes/forcefield/field_scenes.hpp"
#include "tests/support/dice.hpp"
#include "tests/support/heap_is_counted.hpp"
#include "tests/support/hostile_wrench.hpp"

BOOST_AUTO_TEST_SUITE(grid_force_field_test)

using namespace tactor;
using namespace tactor::test;

namespace {

GridForceField::Params params(double cell = 0.002) {
  auto p = default_params<GridForceField>();
  p.cell = cell;
  p.reach = 2 * cell;
  return p;
}

struct Rig : FieldRig<GridForceField> {
  explicit Rig(const GridForceField::Params& p = params()) : FieldRig(p) {
    node.force.configure({QueuePolicy::drop_oldest, 64});
  }
  void force(double ms, const Vec3& F) {
    const Wrench wrench{F, {}};
    node.force.push(stamp_ms(ms), &wrench);
  }
};

}  // namespace

BOOST_AUTO_TEST_CASE(it_says_nothing_before_a_force_was_felt_somewhere) {
  Rig rig;
  BOOST_TEST(!rig.step(0));
  rig.device(1, {});
  BOOST_TEST(!rig.step(1));
  Rig blind;
  blind.force(1, {1, 0, 0});
  BOOST_TEST(!blind.step(1));
  BOOST_TEST(metrics_of(blind.node)["forcefield.rejected_samples"] == 1.0);
}

BOOST_AUTO_TEST_CASE(a_force_belongs_to_where_the_device_was_at_its_stamp) {
  Rig rig;
  // 0.2 mm a millisecond; the force of 10 ms comes at 25 ms.
  for (int ms = 0; ms <= 25; ++ms) rig.device(ms, {2e-4 * ms, 0, 0});
  rig.force(10, {3, 0, 0});
  BOOST_TEST(rig.step(25));
  BOOST_TEST(rig.last.stamp.valid.ns == stamp_ms(10).valid.ns);
  // Another at 20 ms, so that there is a field along the way: 2 mm and 4 mm.
  rig.force(20, {5, 0, 0});
  rig.step(26);
  for (const double x : {0.002, 0.0025, 0.003, 0.004}) {
    rig.device(30 + 1000 * x, {x, 0, 0});
    BOOST_TEST(rig.step(30 + 1000 * x));
    BOOST_TEST(std::abs(rig.shown().x - (3 + (x - 0.002) / 0.002 * 2)) < 1e-12);
    BOOST_TEST(rig.last.stamp.valid.ns == stamp_ms(20).valid.ns);
  }
  auto metrics = metrics_of(rig.node);
  BOOST_TEST(metrics["forcefield.nodes_stored"] == 2.0);
  BOOST_TEST(metrics["forcefield.stored_ticks"] == 4.0);
  BOOST_TEST(metrics["forcefield.extrapolated_ticks"] == 2.0);
}

BOOST_AUTO_TEST_CASE(a_linear_field_visited_before_is_displayed_without_the_lateness_of_physics) {
  Rig rig;
  const auto field = [](const Vec3& p) { return Vec3{100 * p.x, -40 * p.x + 1, 300 * p.x}; };
  int ms = 0;
  for (int pass = 0; pass < 2; ++pass) {
    for (int k = 0; k <= 100; ++k, ++ms) {
      const Vec3 p{1e-4 * (pass == 0 ? k : 100 - k), 0, 0};
      rig.device(ms, p);
      // Physics is at the nodes, and 15 ms late.
      if (pass == 0 && k % 20 == 0) rig.force(ms, field(p));
      const bool shown = rig.step(ms);
      if (pass == 1) {
        BOOST_TEST(shown);
        BOOST_TEST(norm(rig.shown() - field(p)) < 1e-12);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(where_nothing_is_known_the_newest_force_is_held) {
  Rig rig;
  rig.device(0, {});
  rig.force(0, {1, 0, 0});
  rig.step(0);
  rig.device(1, {0.05, 0, 0});
  BOOST_TEST(rig.step(1));
  BOOST_TEST(rig.shown().x == 1.0);
  BOOST_TEST(metrics_of(rig.node)["forcefield.held_ticks"] == 1.0);
}

BOOST_AUTO_TEST_CASE(a_physics_that_has_died_is_seen_by_the_stamps) {
  Rig rig;
  rig.device(0, {});
  rig.force(0, {1, 0, 0});
  for (int ms = 0; ms < 500; ++ms) {
    rig.device(ms, {1e-5 * ms, 0, 0});
    BOOST_TEST(rig.step(ms));
    BOOST_TEST(rig.last.stamp.valid.ns == 0);
  }
}

BOOST_AUTO_TEST_CASE(what_is_not_finite_is_kept_out_and_counted_and_keeps_nothing_alive) {
  Rig with, without;
  Dice dice(5);
  const double inf = std::numeric_limits<double>::infinity();
  int bad = 0;
  for (int ms = 0; ms < 400; ++ms) {
    const Vec3 p = dice.in_cube(0.01), F = dice.in_cube(3);
    for (Rig* rig : {&with, &without}) {
      rig->device(ms, p);
      if (ms % 10 == 0) rig->force(ms, F);
    }
    if (ms % 10 == 5) {
      with.force(ms, {std::nan(""), 0, 0});
      with.force(ms, {0, ms % 20 == 5 ? inf : 1e200, 0});
      with.device(ms + 0.5, {0, 0, -inf});
      bad += 2;
    }
    BOOST_TEST(with.step(ms) == without.step(ms));
    BOOST_TEST(norm(with.shown() - without.shown()) == 0.0);
    BOOST_TEST(with.last.stamp.valid.ns == without.last.stamp.valid.ns);
  }
  BOOST_TEST(metrics_of(with.node)["forcefield.rejected_samples"] == bad);
  BOOST_TEST(metrics_of(without.node)["forcefield.rejected_samples"] == 0.0);
}

BOOST_AUTO_TEST_CASE(whatever_comes_what_is_displayed_is_finite_and_within_the_limit) {
  for (int kind = 0; kind < hostile_kinds; ++kind) {
    Rig rig;
    Dice draw(static_cast<std::uint64_t>(kind) + 1);
    for (int ms = 0; ms < 2000; ++ms) {
      rig.device(ms, draw.normal_vector(std::exp(draw(-12, ms % 7 == 0 ? 20 : -3))));
      if (ms % 8 == 0) rig.force(ms - draw(0, 20), hostile(kind, ms / 8, draw).force);
      if (!rig.step(ms)) continue;
      BOOST_REQUIRE(is_finite(rig.shown()));
      BOOST_REQUIRE(norm(rig.shown()) <= 8 + 1e-9);
      BOOST_REQUIRE(norm(evaluate(rig.last.value, stamp_ms(ms).valid).torque) == 0.0);
    }
  }
}

BOOST_AUTO_TEST_CASE(no_step_calls_the_heap, *boost::unit_test::precondition(tactor::test::heap_is_counted)) {
  BOOST_TEST(GridForceField::declare().realtime_safe);
  auto small = params();
  small.nodes = 64;  // soon full
  Rig rig(small);
  Dice draw(3);
  const auto feed = [&](int ms) {
    rig.device(ms, draw.normal_vector(0.01));
    if (ms % 10 == 0) rig.force(ms, draw.normal_vector());
    rig.step(ms);
  };
  for (int ms = 0; ms < 20; ++ms) feed(ms);
  const std::int64_t before = thread_heap_calls();
  for (int ms = 20; ms < 2000; ++ms) feed(ms);
  BOOST_TEST(thread_heap_calls() - before == 0);
  BOOST_TEST(metrics_of(rig.node)["forcefield.nodes_evicted"] > 0.0);
}

BOOST_AUTO_TEST_CASE(a_reach_of_more_than_three_cells_is_refused) {
  const Scene scene = floor_and_ball();
  auto p = params(0.001);
  p.reach = 0.0031;
  const std::string error = input_error([&] { GridForceField node(p, context_for(scene)); });
  BOOST_TEST(error.find("forcefield.grid: reach (0.0031") != std::string::npos, error);
  p.reach = 0.003;
  BOOST_TEST(input_error([&] { GridForceField node(p, context_for(scene)); }).empty());
}

BOOST_AUTO_TEST_SUITE_END()
