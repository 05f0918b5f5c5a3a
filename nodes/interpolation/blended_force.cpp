#include "nodes/interpolation/blended_force.hpp"

#include <algorithm>
#include <cmath>

#include "nodes/physics/mechanics/coupling_wrench.hpp"

namespace tactor {

namespace {

/// Ticks that the force is carried on for beyond the newest sample, at most.
constexpr double most_lead = 2;

constexpr double weight_memory = 0.05;  // s

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

void CarriedForce::Weight::take(const Vec3& change, const Vec3& foretold, double kept) {
  const double by = dot(change, foretold), length = dot(foretold, foretold);
  if (!std::isfinite(by + length)) return;
  told = kept * told + by;
  square = kept * square + length;
}

double CarriedForce::Weight::value() const {
  return square > 0 ? std::clamp(told / square, 0.0, 1.0) : 1;
}

/// Compares a sample's force with what was foretold of it.
void CarriedForce::take(const ForceState& state, Time time) {
  const double interval = (time - last_time_).seconds();
  if (started_ && interval <= 0) return;
  if (started_) {
    const double kept = std::exp(-interval / weight_memory);
    force_.take(state.value.force - last_.value.force, interval * last_.rate.force, kept);
    torque_weight_.take(state.value.torque - last_.value.torque, interval * last_.rate.torque, kept);
  }
  started_ = true;
  last_ = state;
  last_time_ = time;
}

ForceState CarriedForce::at(Time now, const LocalRollout& rollout, const Twist& a_D) {
  const PhysicsState state = rollout.state();
  const CouplingParameters& coupling = rollout.model().coupling;
  const Twist& a_T = rollout.acceleration();
  ForceState aim{coupling_wrench(coupling, state, torque_), {}, {}};
  aim.rate.force = -coupling.k_t * (state.V_WD.v - state.V_WT.v) - coupling.b_t * (a_D.v - a_T.v);
  if (torque_) aim.rate.torque = -coupling.k_r * (state.V_WD.w - state.V_WT.w) - coupling.b_r * (a_D.w - a_T.w);
  take(aim, rollout.model().time);
  aim.rate.force = force_.value() * aim.rate.force;
  aim.rate.torque = torque_weight_.value() * aim.rate.torque;
  const double ahead = std::min((now - rollout.model().time).seconds(), most_lead * tick_.seconds());
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

}  // namespace tactor
