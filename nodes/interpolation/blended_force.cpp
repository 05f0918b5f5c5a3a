#include "nodes/interpolation/blended_force.hpp"

#include <algorithm>
#include <cmath>

#include "nodes/physics/mechanics/coupling_wrench.hpp"

namespace tactor {

namespace {

/// Ticks that the force is carried on for beyond the newest sample, at most.
constexpr double most_lead = 2;

constexpr double weight_memory = 0.05;  // s
constexpr double change_memory = 1;     // s, of the largest change
constexpr double most_catch_up = 0.25;  // of the largest change

/// Limits the rate of a difference, axis by axis, so that it decays without growing or changing its sign: between 0 and
/// -e / tau.
void settle(ForceState& e, double tau) {
  const auto axis = [tau](double value, double& rate) {
    rate = value > 0 ? std::clamp(rate, -value / tau, 0.0) : std::clamp(rate, 0.0, -value / tau);
  };
  for (int i = 0; i < 3; ++i) {
    axis(e.value.force[i], e.rate.force[i]);
    axis(e.value.torque[i], e.rate.torque[i]);
  }
}

}  // namespace

Wrench limited(const Wrench& wrench, const CouplingParameters& coupling, double share) {
  return {tactor::limited(wrench.force, share * coupling.force_max),
          tactor::limited(wrench.torque, share * coupling.torque_max)};
}

Vec3 CarriedForce::Foretold::rate(const Vec3& value, const Vec3& rate, double interval) {
  const Vec3 change = value - last_, foretold = interval * last_rate_;
  last_ = value;
  last_rate_ = rate;
  if (!started_) {
    started_ = true;
    return shown_rate_ = rate;
  }
  const double kept = std::exp(-interval / weight_memory);
  largest_ = std::max(std::exp(-interval / change_memory) * largest_, norm(change));
  const double size = dot(change, change) + dot(foretold, foretold);
  if (size > 0 && std::isfinite(size)) {
    told_ = kept * told_ + dot(change, foretold) / size;
    square_ = kept * square_ + dot(foretold, foretold) / size;
  }
  const double weight = square_ > 0 ? std::clamp(told_ / square_, 0.0, 1.0) : 1;
  const double most = most_catch_up * std::max(largest_ / interval, norm(shown_rate_));
  shown_rate_ += tactor::limited(weight * rate - shown_rate_, most);
  // One that is not finite would stay for ever.
  if (!is_finite(shown_rate_)) shown_rate_ = rate;
  return shown_rate_;
}

ForceState CarriedForce::at(Time now, const LocalRollout& rollout, const Twist& a_D) {
  return at(now, rollout.model().time, rollout.state(), rollout.model().coupling, rollout.acceleration(), a_D);
}

ForceState CarriedForce::at(Time now, Time sampled, const PhysicsState& state, const CouplingParameters& coupling,
                            const Twist& a_T, const Twist& a_D) {
  ForceState aim{coupling_wrench(coupling, state, torque_), {}, {}};
  const double interval = (sampled - last_).seconds();
  if (interval > 0) {
    const Vec3 rate = -coupling.k_t * (state.V_WD.v - state.V_WT.v) - coupling.b_t * (a_D.v - a_T.v);
    rate_.force = force_.rate(aim.value.force, rate, interval);
    const Vec3 turning = -coupling.k_r * (state.V_WD.w - state.V_WT.w) - coupling.b_r * (a_D.w - a_T.w);
    if (torque_) rate_.torque = turning_.rate(aim.value.torque, turning, interval);
    last_ = sampled;
  }
  aim.rate = rate_;
  const double ahead = std::clamp((now - sampled).seconds(), 0.0, most_lead * tick_.seconds());
  aim.value = limited(aim.value + ahead * aim.rate, coupling);
  return aim;
}

ForceState one_tick_later(const ForceState& aim, Duration tick, const CouplingParameters& coupling) {
  return {limited(aim.value + tick.seconds() * aim.rate, coupling), aim.rate, {}};
}

const ForceSegment& BlendedForce::go_on(Time now, const ForceState& aim, const ForceState& later, bool changed) {
  if (shown_any_ && changed) {
    difference_ = displayed(shown_, now) - aim;
    difference_.curvature = {};
    settle(difference_, tau_);
  } else if (shown_any_) {
    difference_ = decayed_twice(difference_, (now - shown_.begin).seconds(), tau_);
  }
  shown_any_ = true;
  const ForceState rest = decayed_twice(difference_, tick_.seconds(), tau_);
  shown_ = cubic_between(now, tick_, {aim.value + difference_.value, aim.rate + difference_.rate, {}},
                         {later.value + rest.value, later.rate + rest.rate, {}});
  return shown_;
}

void BlendedForce::count_correction() {
  ++corrections_;
  const Vec3& jump = difference_.value.force;
  correction_sum_ += dot(jump, jump);
}

double BlendedForce::correction_rms() const {
  return corrections_ > 0 ? std::sqrt(correction_sum_ / static_cast<double>(corrections_)) : 0.0;
}

}  // namespace tactor
