#include "nodes/interpolation/select.hpp"

#include <algorithm>

#include "framework/core/check.hpp"
#include "framework/node/declare.hpp"

namespace tactor {

namespace {

/// After so many time constants nothing that can be felt is left of a difference: 20 N are 2e-6 N.
constexpr std::int64_t blend_times = 20;

constexpr std::array<const char*, 4> names{"first", "second", "third", "fourth"};

bool is_finite(const ForceSegment& segment) {
  return std::all_of(segment.c.begin(), segment.c.end(), [](const Wrench& c) { return tactor::is_finite(c); });
}

}  // namespace

NodeInfo Select::declare() {
  const auto optional = [](const char* doc) {
    return InputOptions{.doc = doc, .trigger = Trigger::yes, .required = false};
  };
  return Declare<Select>("interpolation.select", "Displays one of several curves, and changes over without a jump.")
      .details(
          "Use it to compare methods side by side in one graph. Each method has its own predictor and interpolator, "
          "and `use` names the one that is displayed. Set `use` while a session runs. The displayed force then stays "
          "as it is, and its difference from the new curve decays by tau^2 e'' + 2 tau e' + e = 0, where tau is the "
          "`blend_time`. So force and slope are continuous. After 20 tau the new curve passes unchanged. An input that "
          "has had no segment yet comes into use with its first one.")
      .realtime_safe()
      .input("first", &Select::first, optional("the curve of `use: first`"))
      .input("second", &Select::second, optional("the curve of `use: second`"))
      .input("third", &Select::third, optional("the curve of `use: third`"))
      .input("fourth", &Select::fourth, optional("the curve of `use: fourth`"))
      .output("segment", &Select::segment, "the curve to display")
      .choice("use", &Params::use,
              {{"first", Use::first}, {"second", Use::second}, {"third", Use::third}, {"fourth", Use::fourth}},
              std::optional(Use::first), "the input whose curve is displayed")
      .real("blend_time", &Params::blend_time,
            {.doc = "tau, the time constant of each of the two equal poles of the decay after a change",
             .unit = "s",
             .default_value = 0.02,
             .min = 0,
             .max = 1,
             .above_min = true})
      .tunable({"use", "blend_time"})
      .haptic_rate(&Params::rate, {.doc = "ticks per second while it changes over"})
      .role(Role::interpolation)
      .info();
}

Select::Select(const Params& params, const NodeContext&) : params_(params), tick_(Duration::from_rate(params.rate)) {}

const Input<ForceSegment>& Select::input(Use use) const {
  switch (use) {
    case Use::first:
      return first;
    case Use::second:
      return second;
    case Use::third:
      return third;
    case Use::fourth:
      break;
  }
  return fourth;
}

std::string Select::refuses(const Params& params) const {
  if (input(params.use).connected()) return {};
  return std::string("use: ") + names[static_cast<std::size_t>(params.use)] + ": no edge ends at that input";
}

void Select::start(StepContext& /*context*/) {
  if (const std::string why = refuses(params_); !why.empty()) throw InputError(why);
}

void Select::show(Time valid, const ForceSegment& next) {
  shown_ = next;
  segment.send(valid, next);
}

void Select::step(StepContext& context) {
  const Time now = context.now();
  const Stamped<ForceSegment>* newest = input(params_.use).latest();
  if (newest != nullptr && in_use_ != params_.use) {
    if (in_use_ && is_finite(shown_)) blended_until_ = now + params_.blend_time * blend_times;
    in_use_ = params_.use;
    passed_.reset();
  }
  // Until the input in use has a segment the one before is displayed.
  if (!in_use_) return;
  newest = input(*in_use_).latest();
  // What is not finite goes through as it is, so that the safety gate sees it.
  if (!is_finite(newest->value) || (blended_until_ && now >= *blended_until_)) blended_until_.reset();
  if (!blended_until_) {
    if (passed_ == newest->stamp.sequence) return;
    passed_ = newest->stamp.sequence;
    return show(newest->stamp.valid, newest->value);
  }
  const ForceState from = displayed(shown_, now);
  const ForceState difference = from - displayed(newest->value, now);
  const ForceState aim =
      displayed(newest->value, now + tick_) + decayed_twice(difference, tick_.seconds(), params_.blend_time.seconds());
  ForceSegment changing = cubic_between(now, tick_, from, aim);
  changing.trust_time = newest->value.trust_time;
  show(newest->stamp.valid, changing);
}

}  // namespace tactor
