// forcefield.rbf: what it was fitted to, what it displays, and what it refuses.
#include <boost/test/unit_test.hpp>

#include "framework/core/segment.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "nodes/collision/primitive.hpp"
#include "nodes/forcefield/rbf.hpp"
#include "tests/nodes/forcefield/field_scenes.hpp"
#include "tests/support/dice.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(rbf_force_field_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr double k_t = 400;                           // N/m
constexpr double series = k_t * 1000 / (k_t + 1000);  // N/m, with two materials of 2000 N/m

/// A box of 60 mm by 60 mm about the floor's origin, from 20 mm below contact to 10 mm above it.
RbfForceField::Params floor_params() {
  auto p = default_params<RbfForceField>();
  p.k_t = k_t;
  p.region = {-0.03, -0.03, -0.01, 0.03, 0.03, 0.02};
  return p;
}

struct Rig : FieldRig<RbfForceField> {
  explicit Rig(const RbfForceField::Params& p = floor_params(), Scene s = floor_and_ball())
      : FieldRig(p, std::move(s)) {
    node.coupling.configure({});
  }
  void push_law() { node.coupling.push({}, &coupling); }
  /// The force displayed with the device there.
  Vec3 at(const Vec3& p) {
    ++ms;
    device(ms, p);
    BOOST_REQUIRE(step(ms));
    return shown();
  }

  CouplingParameters coupling{.k_t = k_t, .b_t = 14, .force_max = 8, .torque_max = 0.3};
  int ms = 0;
};

}  // namespace

BOOST_AUTO_TEST_CASE(on_a_wall_the_force_is_that_of_the_springs_in_series) {
  for (const double spacing : {0.002, 0.001}) {
    auto p = floor_params();
    p.spacing = spacing;
    Rig rig(p);
    rig.push_law();
    Dice dice(1);
    double inside = 0, beside = 0, kink = 0;  // inside: of the force, the others in N
    for (int i = 0; i < 3000; ++i) {
      const Vec3 x{dice(-0.025, 0.025), dice(-0.025, 0.025), dice(-0.005, 0.018)};
      const double depth = 0.01 - x.z, wanted = series * std::max(0.0, depth);
      const double error = norm(rig.at(x) - Vec3{0, 0, wanted});
      if (depth > 2 * spacing) {
        inside = std::max(inside, error / wanted);
      } else {
        double& worst = depth < -2 * spacing ? beside : kink;
        worst = std::max(worst, error);
      }
    }
    BOOST_TEST_MESSAGE("spacing " << spacing << ": " << inside << " of the force inside, " << kink << " N at the kink, "
                                  << beside << " N beside");
    // The kink is rounded over a spacing; a force that is steady between lattice points ripples by some percent.
    BOOST_TEST(inside < 0.04);
    BOOST_TEST(kink < 0.2 * series * spacing);
    BOOST_TEST(beside < 0.1 * series * spacing);
  }
}

BOOST_AUTO_TEST_CASE(on_the_duck_forces_it_was_not_fitted_to_are_those_of_the_contacts) {
  Scene scene;
  scene.gravity_W = {};
  scene.bodies = {field_body("duck", MeshShape{std::filesystem::path(TACTOR_BINARY_DIR) / "meshes/duck.off"}),
                  field_body("tool", SphereShape{0.004}, Motion::translation)};
  auto p = default_params<RbfForceField>();
  p.k_t = k_t;
  Rig rig(p, scene);
  rig.push_law();
  PrimitiveCollision truth(default_params<PrimitiveCollision>(), context_for(rig.scene));
  Dice dice(7);
  ContactSet set;
  double squares = 0, force_squares = 0;
  int count = 0;
  while (count < 2000) {
    const Vec3 x = Vec3{0, 0, 0.03} + dice.in_cube(0.08);
    truth.query({x, {}}, set);
    // As deep as a hand presses; in a groove two sides would share the force.
    if (set.count == 0 || set.contact[0].distance < -0.006) continue;
    const Contact& c = set.contact[0];
    const Vec3 wanted = series * std::max(0.0, -c.distance) * c.n_W;
    const Vec3 error = rig.at(x) - wanted;
    squares += dot(error, error);
    force_squares += dot(wanted, wanted);
    ++count;
  }
  const double rms = std::sqrt(squares / count), force_rms = std::sqrt(force_squares / count);
  BOOST_TEST_MESSAGE("held-out error " << rms << " N of " << force_rms << " N");
  BOOST_TEST(rms < 0.15 * force_rms);
  auto metrics = metrics_of(rig.node);
  BOOST_TEST(metrics["forcefield.solver_residual"] < 1e-6);
  BOOST_TEST(metrics["forcefield.centres"] > 10000);
  BOOST_TEST(metrics["forcefield.residual_median_N"] < 0.1);
  BOOST_TEST(metrics["forcefield.residual_rms_N"] <= metrics["forcefield.residual_max_N"]);
  BOOST_TEST(metrics["forcefield.memory_bytes"] < 5e6);
}

BOOST_AUTO_TEST_CASE(a_tool_of_mass_hangs_on_the_spring_and_a_massless_one_does_not) {
  Scene scene = floor_and_ball();
  scene.gravity_W = {0, 0, -10};
  Rig rig(floor_params(), scene);
  rig.push_law();
  const double weight = 0.05 * 10;
  BOOST_TEST(norm(rig.at({0, 0, 0.019}) - Vec3{0, 0, -weight}) < 0.01);
  // k_t (z_D - z_T) + k (z_0 - z_T) - weight = 0 at 5 mm below z_0.
  const double sag = (k_t * 0.005 + weight) / (k_t + 1000);
  BOOST_TEST(std::abs(rig.at({0, 0, 0.005}).z - k_t * (0.005 - sag)) < 0.03 * series * 0.005);
  rig.coupling.massless = 1;
  rig.push_law();
  BOOST_TEST(norm(rig.at({0, 0, 0.019})) < 0.01);
  BOOST_TEST(std::abs(rig.at({0, 0, 0.005}).z - series * 0.005) < 0.03 * series * 0.005);
}

BOOST_AUTO_TEST_CASE(outside_of_the_region_the_force_is_that_of_its_nearest_point) {
  Rig rig;
  rig.push_law();
  const Vec3 edge = rig.at({0.03, 0, 0.004});
  BOOST_TEST(edge.z > 1.0);
  BOOST_TEST(metrics_of(rig.node)["forcefield.outside_ticks"] == 0.0);
  BOOST_TEST(norm(rig.at({0.5, 0, 0.004}) - edge) == 0.0);
  BOOST_TEST(norm(rig.at({1e200, 0, 0.004}) - edge) == 0.0);
  BOOST_TEST(metrics_of(rig.node)["forcefield.outside_ticks"] == 2.0);
}

BOOST_AUTO_TEST_CASE(the_couplings_limit_holds) {
  Rig rig;
  rig.coupling.force_max = 1.5;
  rig.push_law();
  BOOST_TEST(std::abs(norm(rig.at({0, 0, -0.005})) - 1.5) < 1e-12);
}

BOOST_AUTO_TEST_CASE(it_waits_for_device_and_law_and_is_stamped_with_the_device) {
  Rig rig;
  BOOST_TEST(!rig.step(0));
  push_device(rig.node.device, 1, {});
  BOOST_TEST(!rig.step(1));
  rig.push_law();
  BOOST_TEST(rig.step(2));
  BOOST_TEST(rig.last.stamp.valid.ns == stamp_ms(1).valid.ns);
  BOOST_TEST(rig.step(3));
  BOOST_TEST(rig.last.stamp.valid.ns == stamp_ms(1).valid.ns);
}

BOOST_AUTO_TEST_CASE(a_position_that_is_not_finite_is_left_out_and_keeps_nothing_alive) {
  Rig rig;
  rig.push_law();
  rig.ms = 1;
  const Vec3 before = rig.at({0, 0, 0.005});
  const Time valid = rig.last.stamp.valid;
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {std::nan(""), inf, -inf}) {
    BOOST_TEST(norm(rig.at({0, bad, 0.001}) - before) == 0.0);
    BOOST_TEST(rig.last.stamp.valid.ns == valid.ns);
  }
  BOOST_TEST(metrics_of(rig.node)["forcefield.rejected_samples"] == 3.0);
  BOOST_TEST(norm(rig.at({0, 0, 0.001}) - before) > 0.5);
}

BOOST_AUTO_TEST_CASE(a_law_of_another_stiffness_is_an_error_that_names_it) {
  for (const double other : {500.0, 0.0, std::nan("")}) {
    Rig rig;
    rig.coupling.k_t = other;
    rig.push_law();
    push_device(rig.node.device, 1, {});
    const std::string error = input_error([&] { rig.step(1); });
    BOOST_TEST(error.find("made for a coupling with k_t = 400.0") != std::string::npos, error);
    BOOST_TEST(error.find(std::to_string(other) + " N/m; set its k_t to that") != std::string::npos, error);
  }
}

BOOST_AUTO_TEST_CASE(no_step_calls_the_heap, *boost::unit_test::precondition(tactor::test::heap_is_counted)) {
  BOOST_TEST(RbfForceField::declare().realtime_safe);
  Rig rig;
  rig.push_law();
  Dice dice(3);
  for (int i = 0; i < 3; ++i) rig.at(dice.in_cube(0.03));
  std::int64_t calls = 0;
  for (int i = 0; i < 1000; ++i) {
    push_device(rig.node.device, 10 + i, dice.in_cube(0.03));
    StepContext context(stamp_ms(10 + i).valid);
    const std::int64_t before = thread_heap_calls();
    rig.node.step(context);
    calls += thread_heap_calls() - before;
    BOOST_REQUIRE(rig.node.segment.pending() == 1U);
    rig.node.segment.clear_pending();
  }
  BOOST_TEST(calls == 0);
}

BOOST_AUTO_TEST_CASE(what_cannot_be_fitted_is_refused_with_what_to_do) {
  const auto refusal = [](const RbfForceField::Params& p, const Scene& scene) {
    return input_error([&] { RbfForceField node(p, context_for(scene)); });
  };
  const auto says = [](const std::string& text, const std::string& part) {
    BOOST_TEST(text.find(part) != std::string::npos, text);
    BOOST_TEST(text.find("forcefield.rbf: ") == 0U, text);
  };
  const Scene scene = floor_and_ball();
  auto p = floor_params();
  p.region.clear();
  says(refusal(p, scene), "the fixed body 'floor' is a plane, which has no end; give region");
  p = floor_params();
  p.region.pop_back();
  says(refusal(p, scene), "region: expected six lengths");
  p = floor_params();
  std::swap(p.region[1], p.region[4]);
  says(refusal(p, scene), "region: expected six lengths");
  p = floor_params();
  p.region[3] = 1e9;
  says(refusal(p, scene), "raise the spacing or most_points");
  p = floor_params();
  p.most_points = 1000;
  says(refusal(p, scene), "more than 1000 points");
  Scene turning = scene;
  turning.bodies[1].motion = Motion::rigid;
  says(refusal(floor_params(), turning), "the tool 'tool' rotates");
}

BOOST_AUTO_TEST_SUITE_END()
