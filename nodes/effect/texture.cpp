#include "nodes/effect/texture.hpp"

#include <algorithm>
#include <cmath>

#include "framework/core/value_error.hpp"
#include "framework/yaml/yaml_values.hpp"

namespace tactor {

namespace {

/// After a gap no more samples are made than this; those of the gap are left out.
constexpr std::int64_t most_samples_a_tick = 16;
/// A rate is met up to this share.
constexpr double rate_rounding = 1e-9;
constexpr double no_motion = 1e-9;  // m/s

TextureModel model_for(const Texture::Params& params) {
  TextureModel model = TextureModel::read(params.file);
  if (params.rate < model.rate() * (1 - rate_rounding)) {
    throw ValueError("file",
                     "effect.texture: " + params.file.string() + " has " + number_text(model.rate()) +
                         " samples a second and the haptic loop " + number_text(params.rate) +
                         " ticks; expected no more samples than ticks: raise the graph's rate, or make the model "
                         "for a lower one");
  }
  return model;
}

}  // namespace

NodeInfo Texture::declare() {
  Declare<Texture> d("effect.texture",
                     "Adds the vibration of sliding over a rough surface, by auto-regressive models.");
  d.details(
      "While the tool touches, the node takes the direction of the surface's force as the surface normal, and its size "
      "as the normal force. The speed is the handle's speed across the normal. The force comes from the input "
      "`contact`. Without that input, the node takes the incoming force above `threshold`, which includes the weight "
      "and the inertia of a displayed tool. The file holds auto-regressive models of the tool's acceleration over a "
      "grid of speeds and forces. White noise, filtered by a model interpolated between the four neighbours, gives the "
      "acceleration; times `mass` it is the force that is added. The node interpolates the acceleration's deviation "
      "and the reflection coefficients, so every filter in between is stable. The filter is a normalised lattice, "
      "which stays bounded while its coefficients change. A tool at rest makes no "
      "vibration.\ngraphs/renderers/textures has two models of our own. docs/howto/renderers.md describes the format "
      "of the file.\nAfter Romano and Kuchenbecker, Creating Realistic Virtual Textures from Contact Acceleration Data "
      "(2012), and Culbertson, Unwin, Kuchenbecker, Modeling and Rendering Realistic Textures from Unconstrained "
      "Tool-Surface Interactions (2014). They interpolate on a Delaunay triangulation.");
  declare_stage(d)
      .file("file", &Params::file, true, "the model, a YAML file")
      .choice("along", &Params::along,
              {{"normal", Along::normal}, {"motion", Along::motion}, {"across", Along::across}},
              std::optional(Along::normal),
              "normal: along the surface's force; motion: along the sliding; across: across both")
      .real("gain", &Params::gain,
            {.doc = "factor on the model's acceleration", .default_value = 1, .min = 0, .max = 1000})
      .real("mass", &Params::mass,
            {.doc = "mass of the handle, which gets the acceleration",
             .unit = "kg",
             .default_value = 0.1,
             .min = 0.001,
             .max = 100,
             .as_in = Role::device})
      .real("threshold", &Params::threshold,
            {.doc = "without the input `contact`: smaller forces do not count as contact",
             .unit = "N",
             .default_value = 0.05,
             .min = 0,
             .max = 10})
      .haptic_rate(&Params::rate, {.doc = "ticks per second"})
      .metric("texture.sliding_ticks", "1", "ticks with contact and motion", Better::neither, &Texture::ticks_)
      .metric("texture.rms_N", "N", "RMS of what was added at those", Better::neither,
              [](const Texture& self) {
                return self.ticks_ > 0 ? std::sqrt(self.squares_ / static_cast<double>(self.ticks_)) : 0.0;
              })
      .metric("texture.peak_N", "N", "largest that was added", Better::neither, &Texture::largest_)
      .metric("texture.limited_ticks", "1", "ticks at which the sum was cut at `force_max`", Better::lower,
              &Texture::limited_ticks_);
  return d.info();
}

Texture::Texture(const Params& params, const NodeContext& context)
    : params_(params), model_(model_for(params)), stage_(Duration::from_rate(params.rate)), engine_(context.seed) {
  std::array<double, Reflection::most_order> errors{};
  for (double& e : errors) e = noise_(engine_);
  lattice_.set_errors(errors);
}

/// The samples that are due by now.
void Texture::make_samples(Time now, double speed, double force) {
  const auto due = static_cast<std::int64_t>(std::floor(now.seconds() * model_.rate() * (1 + rate_rounding)));
  const TextureState state = model_.at(speed, force);
  samples_ = std::max(samples_, due - most_samples_a_tick);
  for (; samples_ < due; ++samples_) acceleration_ = state.deviation * lattice_.next(state.reflection, noise_(engine_));
}

Vec3 Texture::direction(const Vec3& n, const Vec3& sliding) const {
  if (params_.along == Along::normal) return n;
  const Vec3 t = sliding / norm(sliding);
  return params_.along == Along::motion ? t : cross(n, t);
}

void Texture::step(StepContext& context) {
  const Time now = context.now();
  if (!stage_.take(base)) return;
  const Stamped<DeviceState>* state = device.latest();
  if (state == nullptr || !is_finite(state->value.V_WD.v) || !stage_.is_usable(now)) return stage_.pass_on(segment);
  const Touch touch = touch_of(contact, device, stage_.force(now), params_.threshold);
  const double size = norm(touch.force_W);
  if (!touch.touches || !(size > 0)) return stage_.pass_on(segment);
  const Vec3 n = touch.force_W / size, v = state->value.V_WD.v, sliding = v - dot(v, n) * n;
  const double speed = norm(sliding);
  if (speed < no_motion) return stage_.pass_on(segment);
  make_samples(now, speed, size);
  const Vec3 added = (params_.gain * params_.mass * acceleration_) * direction(n, sliding);
  const bool limited = stage_.add(now, added, added, params_.force_max, segment);
  if (!stage_.is_first_of_tick(now)) return;
  ++ticks_;
  squares_ += dot(added, added);
  largest_ = std::max(largest_, norm(added));
  if (limited) ++limited_ticks_;
}

}  // namespace tactor
