// interpolation.rollout as tests feed it, and a ball against a wall integrated apart from it.
#pragma once

#include <boost/test/unit_test.hpp>

#include <cmath>
#include <string>

#include "framework/core/segment.hpp"
#include "nodes/interpolation/rollout.hpp"
#include "nodes/physics/contact/local_contacts.hpp"
#include "nodes/physics/mechanics/local_model.hpp"
#include "tests/nodes/physics/mechanics/local_contacts.hpp"
#include "tests/support/nodes.hpp"

namespace tactor::test {

inline constexpr double radius = 0.01;
inline constexpr double tau = 0.002;  // s, the blend's default
inline const CouplingParameters spring{
    .k_t = 500, .b_t = 14, .k_r = 0.5, .b_r = 0.005, .force_max = 8, .torque_max = 0.3};

inline Scene ball_scene(double mass, int count = 1) {
  Scene scene;
  scene.gravity_W = {};
  for (int i = 0; i < count; ++i) {
    Body body;
    body.name = "ball" + std::to_string(i);
    body.shape = SphereShape{radius};
    body.motion = Motion::translation;
    body.mass = mass;
    scene.bodies.push_back(body);
  }
  return scene;
}

/// The rollout is displayed whatever physics feels, of which most models here tell nothing.
inline Rollout::Params on_surface() {
  auto params = default_params<Rollout>();
  params.worse = 1e6;
  return params;
}

/// The same, but the contacts of the models serve, and each model is gone back to.
inline Rollout::Params anchored() {
  auto params = on_surface();
  params.contacts = SurfaceOptions::From::anchors;
  params.restart = Rollout::Params::Restart::always;
  return params;
}

/// The node, fed with samples and models, and a device that shows the newest segment.
class Subject {
 public:
  explicit Subject(double mass = 0.1, const Rollout::Params& params = anchored(), bool with_forecast = false)
      : Subject(ball_scene(mass), params, with_forecast) {}
  Subject(const Scene& scene, const Rollout::Params& params, bool with_forecast = false)
      : scene_(scene), node_(params, context_for(scene_)) {
    node_.model.configure({});
    node_.device.configure({QueuePolicy::drop_oldest, 64});
    if (with_forecast) node_.forecast.configure({});
  }
  void sample(double ms, const DeviceState& state) { node_.device.push({at_ms(ms), at_ms(ms), samples_++}, &state); }
  void sample(double ms, const Vec3& p, const Vec3& v = {}) { sample(ms, {{p, {}}, {v, {}}, 0}); }
  /// A model that comes at `ms`, of a result of `stamp_ms`.
  void model(double stamp_ms, double ms, const LocalModel& m) {
    node_.model.push({at_ms(stamp_ms), at_ms(ms), models_++}, &m);
  }
  void forecast(double stamp_ms, double ms, const Forecast& f) {
    node_.forecast.push({at_ms(stamp_ms), at_ms(ms), models_++}, &f);
  }
  /// Ticks at `ms`; false where nothing is sent.
  bool tick(double ms) {
    StepContext context(at_ms(ms));
    node_.step(context);
    if (node_.segment.pending() == 0) return false;
    BOOST_REQUIRE(node_.segment.pending() == 1U);
    before_ = shown_;
    shown_ = sent(node_.segment);
    stamp = node_.segment.pending_valid(0);
    node_.segment.clear_pending();
    return true;
  }
  /// What a device shows.
  [[nodiscard]] Vec3 force(double ms) const { return evaluate(shown_, at_ms(ms)).force; }
  [[nodiscard]] const ForceSegment& shown() const { return shown_; }
  /// How far value and rate of the newest segment are from those that the one before ends with.
  [[nodiscard]] double jump() const { return norm(shown_.c[0].force - displayed(before_, shown_.begin).value.force); }
  [[nodiscard]] double kink() const {
    return norm(evaluate_rate(shown_, shown_.begin).force - displayed(before_, shown_.begin).rate.force);
  }
  [[nodiscard]] double metric(const std::string& name) const { return metrics_of(node_).at(name); }

  Time stamp;

 private:
  Scene scene_;
  Rollout node_;
  ForceSegment shown_, before_;
  std::uint64_t samples_ = 0, models_ = 0;
};

inline LocalModel model_at(double ms, const BodyStates& bodies, const Vec3& handle, const LocalContacts& contacts,
                           const Vec3& speed = {}) {
  LocalModel m;
  m.time = at_ms(ms);
  m.device.X_WD.p = handle;
  m.device.V_WD.v = speed;
  m.bodies = bodies;
  m.p_WT_result = bodies.X_WB[0].p;
  m.coupling = spring;
  m.contacts = contacts;
  return m;
}

/// A handle that goes into the wall x = 0 and out of it, along x.
struct Handle {
  static double x(double t) { return 0.012 - 0.008 * (1 - std::cos(12 * t)); }
  static double v(double t) { return -0.096 * std::sin(12 * t); }
};

/// The ball of 0.1 kg on the spring against a wall of 1000 N/m and 2 N s/m, by explicit steps of 1 us.
class Truth {
 public:
  explicit Truth(double t) : t_(t), x_(Handle::x(t)), v_(Handle::v(t)) {}
  void advance(double until) {
    constexpr double h = 1e-6, mass = 0.1;
    for (; t_ < until - h / 2; t_ += h) {
      const double wall = 1000 * (radius - x_) - 2 * v_;
      // The damper meets a point that approaches above the surface, and the wall does not pull.
      v_ += h * (std::max(0.0, wall) - reaction()) / mass;
      x_ += h * v_;
    }
  }
  [[nodiscard]] double reaction() const {
    return -spring.k_t * (Handle::x(t_) - x_) - spring.b_t * (Handle::v(t_) - v_);
  }
  [[nodiscard]] BodyStates bodies() const { return one_body({x_, 0, 0}, {v_, 0, 0}); }

 private:
  double t_, x_, v_;
};

}  // namespace tactor::test
