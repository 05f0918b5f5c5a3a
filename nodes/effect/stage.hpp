// What effects share: the displayed force that they add to, tick by tick.
#pragma once

#include <limits>
#include <optional>

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "nodes/interpolation/force_state.hpp"

namespace tactor {

/// The segments that come in, and what goes out where an effect adds something to them.
class EffectStage {
 public:
  explicit EffectStage(Duration tick) : tick_(tick) {}

  /// Takes what has come; false where nothing has.
  bool take(const Input<ForceSegment>& segment) {
    const Stamped<ForceSegment>* newest = segment.latest();
    if (newest == nullptr) return false;
    base_ = *newest;
    return true;
  }
  /// True for the first step of each tick: metrics count ticks, and a segment that comes in between makes a step too.
  bool is_first_of_tick(Time now) {
    const std::int64_t tick = now.ns / tick_.ns;
    const bool first = tick != counted_;
    counted_ = tick;
    return first;
  }
  /// The force that would be displayed at t without the effect.
  [[nodiscard]] Vec3 force(Time t) const { return evaluate(base_.value, t).force; }
  [[nodiscard]] bool is_usable(Time now) const { return is_finite(evaluate(base_.value, now)); }

  /// Sends the segment as it came, where it is new or an effect was added to it at the tick before.
  void pass_on(Output<ForceSegment>& out) {
    if (!added_ && sent_ == base_.stamp.sequence) return;
    sent_ = base_.stamp.sequence;
    added_ = false;
    out.send(base_.stamp.valid, base_.value);
  }
  /// Sends the curve of the tick that begins at `now`, with `begin` and `end` (N, W) added at its ends; no longer than
  /// `force_max` (N), or than the force that came where that is longer. Stamped and trusted as what came. Returns
  /// whether the limit was reached.
  bool add(Time now, const Vec3& begin, const Vec3& end, double force_max, Output<ForceSegment>& out) {
    ForceState from = displayed(base_.value, now), to = displayed(base_.value, now + tick_);
    const double was = norm(from.value.force);
    const Vec3 wanted = from.value.force + begin, later = to.value.force + end;
    from.value.force = limited(wanted, std::max(force_max, was));
    to.value.force = limited(later, std::max(force_max, norm(to.value.force)));
    // Between the ends the rate is that of the line between them: what is added has no other.
    from.rate = to.rate = (1 / tick_.seconds()) * (to.value - from.value);
    ForceSegment shown = cubic_between(now, tick_, from, to);
    shown.trust_time = base_.value.trust_time;
    sent_ = base_.stamp.sequence;
    added_ = true;
    out.send(base_.stamp.valid, shown);
    return norm(from.value.force - wanted) > 1e-12;
  }

 private:
  Duration tick_;
  Stamped<ForceSegment> base_;
  std::uint64_t sent_ = std::numeric_limits<std::uint64_t>::max();  // sequence number
  bool added_ = false;
  std::int64_t counted_ = -1;
};

/// What every effect has: `segment`, `device` and perhaps `contact` in, `segment` out, from which force on it touches
/// (N) and the largest force (N) of all together.
template <class N>
Declare<N>& declare_stage(Declare<N>& node) {
  return node.realtime_safe()
      .role(Role::interpolation)
      .input("segment", &N::base, {.doc = "the force to add to", .trigger = Trigger::yes})
      .input("device", &N::device, {.doc = "the newest sample of the handle"})
      .input("contact", &N::contact,
             {.doc = "whether the tool touches, and with which force; without this input, `segment` decides",
              .required = false})
      .output("segment", &N::segment, "the same force with the effect added; unchanged while there is no effect")
      .real("force_max", &N::Params::force_max,
            {.doc = "largest sum of force and vibration",
             .unit = "N",
             .default_value = 8,
             .min = 0,
             .above_min = true,
             .as_in = Role::device});
}

}  // namespace tactor
