#include "nodes/interpolation/rollout.hpp"

#include <cmath>

#include "framework/core/segment.hpp"
#include "nodes/mechanics/coupling_wrench.hpp"
#include "nodes/mechanics/scene_model.hpp"

namespace tactor {

namespace {
SystemModel model_of(const Rollout::Params& params, const NodeContext& context) {
  SystemModel model = scene_model("interpolation.rollout", *context.scene, context.notes);
  model.iterations = params.iterations;
  model.stick_velocity = params.stick_velocity;
  return model;
}
}  // namespace

NodeInfo Rollout::declare() {
  return Declare<Rollout>("interpolation.rollout", "Goes on with a local model tick by tick.")
      .realtime_safe()
      .input("model", &Rollout::model, {.doc = "what to go on from"})
      .input("device", &Rollout::device, {.doc = "every sample of the handle", .queue = {QueuePolicy::drop_oldest, 64}})
      .output("segment", &Rollout::segment, "the force over one tick")
      .real("blend_time", &Params::blend_time, {.doc = "time constant of a correction", .unit = "s", .default_value = 0.002, .min = 0, .max = 1, .above_min = true})
      .integer<std::int32_t>("iterations", &Params::iterations, {.doc = "Newton iterations a step, at most", .default_value = 30, .min = 1, .max = 200})
      .real("stick_velocity", &Params::stick_velocity, {.doc = "sliding speed below which friction is viscous", .unit = "m/s", .default_value = 1e-4, .min = 0, .max = 1, .above_min = true})
      .boolean("lead", &Params::lead, true, "extrapolate")
      .rate("rate", &Params::rate, {.doc = "ticks a second", .default_value = 1000})
      .info();
}

Rollout::Rollout(const Params& params, const NodeContext& context)
    : params_(params), torque_(context.torque), rollout_(model_of(params, context)), tick_(Duration::from_rate(params.rate)) {}

Twist Rollout::acceleration() const {
  constexpr std::size_t span = 5;
  if (count_ <= span) return {};
  const Stamped<DeviceState>&a = track_[(count_ - 1 - span) % track_.size()], &b = track_[(count_ - 1) % track_.size()];
  const double h = (b.stamp.valid - a.stamp.valid).seconds();
  if (h <= 0) return {};
  return {(1 / h) * (b.value.V_WD.v - a.value.V_WD.v), (1 / h) * (b.value.V_WD.w - a.value.V_WD.w)};
}

void Rollout::step(StepContext& context) {
  Stamped<DeviceState> sample;
  const std::size_t before = count_;
  while (new_states_.next(device, sample)) track_[count_++ % track_.size()] = sample;
  const Stamped<LocalModel>* newest = model.latest();
  if (newest == nullptr || count_ == 0) return;
  const Time now = context.now();
  const bool fresh = !running_ || newest->stamp.sequence != used_.sequence;
  std::size_t from = before;
  if (fresh) {
    used_ = newest->stamp;
    rollout_.restart(newest->value);
    from = count_ > track_.size() ? count_ - track_.size() : 0;
  }
  for (std::size_t i = from; i < count_; ++i) rollout_.advance(track_[i % track_.size()]);
  const PhysicsState state = rollout_.state();
  const CouplingLaw& law = rollout_.model().law;
  const Wrench F = coupling_wrench(law, state, torque_);
  Wrench rate;
  if (params_.lead) {
    const Twist a_D = acceleration();
    const Twist& a_T = rollout_.acceleration();
    rate.force = -law.k_t * (state.V_WD.v - state.V_WT.v) - law.b_t * (a_D.v - a_T.v);
    if (torque_) rate.torque = -law.k_r * (state.V_WD.w - state.V_WT.w) - law.b_r * (a_D.w - a_T.w);
  }
  // F holds for the time of the newest sample.
  const double age = (now - rollout_.model().time).seconds();
  const Wrench F_now = F + age * rate;
  const double tau = params_.blend_time.seconds(), h = (now - last_).seconds();
  if (fresh && running_) {
    d_ = evaluate(shown_, now) - F_now;
    d_rate_ = evaluate_rate(shown_, Time{now.ns - 1}) - rate;
  } else if (running_) {
    const double decay = std::exp(-h / tau);
    const Wrench slope = d_rate_ + (1.0 / tau) * d_;
    const Wrench d = decay * (d_ + h * slope);
    d_rate_ = decay * (d_rate_ - (h / tau) * slope);
    d_ = d;
  }
  running_ = true;
  last_ = now;
  const double T = tick_.seconds();
  const double decay = std::exp(-T / tau);
  const Wrench slope = d_rate_ + (1.0 / tau) * d_;
  const Wrench d_end = decay * (d_ + T * slope);
  const Wrench start = F_now + d_, end = F_now + T * rate + d_end;
  shown_ = {now, now + tick_, {start, end - start}};
  segment.send(used_.valid, shown_);
}

}  // namespace tactor
