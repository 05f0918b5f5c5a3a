#include "framework/realtime/device_node.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/core/segment.hpp"
#include "framework/core/value_error.hpp"

namespace tactor {

namespace {

constexpr std::int64_t minute_ns = 60'000'000'000;

/// True where the times are less than a minute apart.
bool near(Time a, Time b) {
  std::int64_t ns = 0;
  return !__builtin_sub_overflow(a.ns, b.ns, &ns) && ns > -minute_ns && ns < minute_ns;
}

bool is_finite(const DeviceState& s) {
  const Quat& R = s.X_WD.R;
  return is_finite(s.X_WD.p) && is_finite(s.V_WD.v) && is_finite(s.V_WD.w) && std::isfinite(R.w) &&
         std::isfinite(R.x) && std::isfinite(R.y) && std::isfinite(R.z);
}

FlightVector flight_vector(const Vec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

bool same(const Stamp& a, const Stamp& b) {
  return a.valid == b.valid && a.produced == b.produced && a.sequence == b.sequence;
}

/// How long the pipeline still stands for a segment whose sample is `age` old, less than a minute. No trust is counted
/// beyond a minute, so that the difference does not overflow.
Duration trusted_for(const ForceSegment& segment, Duration age) {
  if (segment.trust_time <= Duration{}) return SafetyInput::longest;
  return std::min(segment.trust_time, Duration{minute_ns}) - age;
}

/// The button that must be held, which has to be one that there is; 0: none.
std::int32_t dead_man_button_of(const DeviceParams& params, std::optional<int> buttons) {
  if (!params.dead_man_button) return buttons.value_or(0) > 0 ? 1 : 0;
  const std::int32_t button = *params.dead_man_button;
  if (!buttons || button <= *buttons) return button;
  throw ValueError("dead_man_button", "dead_man_button: expected " +
                                          (*buttons == 0 ? "0, because the device has no buttons"
                                                         : "a button of the device, 1 to " + std::to_string(*buttons) +
                                                               ", or 0 for none") +
                                          ", found " + std::to_string(button));
}

}  // namespace

DeviceNode::DeviceNode(const DeviceParams& params, const NodeContext& context, std::optional<int> buttons)
    : name_(context.name),
      rotates_(context.torque),
      dead_man_button_(dead_man_button_of(params, buttons)),
      lacks_dead_man_(dead_man_button_ == 0 && !params.dead_man_button),
      failure_timeout_(params.failure_timeout),
      stale_after_(params.stale_after),
      sample_age_max_(params.sample_age_max),
      gate_(params, Duration::from_seconds(std::clamp(1.0 / params.rate, 1e-9, 3600.0))) {}

DeviceHealth DeviceNode::read_device(Time now) {
  DeviceSample sample;
  switch (read(now, sample)) {
    case ReadResult::sample:
      if (!is_finite(sample.state)) return DeviceHealth::read_failed;
      sample_ = sample;
      any_sample_ = true;
      state.send(sample.time, sample.state);
      return write_failed_ ? DeviceHealth::write_failed : DeviceHealth::ok;
    case ReadResult::not_yet:
      if (!any_sample_) return DeviceHealth::not_ready;
      break;
    case ReadResult::failed:
      sample_.expired = sample.expired;
      break;
  }
  return DeviceHealth::read_failed;
}

Duration DeviceNode::take_segment(Time now) {
  const Stamped<ForceSegment>* message = segment.latest();
  if (message == nullptr) return {};
  const Stamp& stamp = message->stamp;
  if (any_seen_ && same(stamp, seen_)) return {};
  any_seen_ = true;
  seen_ = stamp;
  ++segments_;
  const ForceSegment& s = message->value;
  const bool newer = !any_segment_ || (stamp.produced > used_.produced && stamp.sequence > used_.sequence);
  const bool plausible =
      s.begin <= s.end && near(s.begin, now) && near(s.end, now) && near(stamp.produced, now) && near(stamp.valid, now);
  if (!newer || !plausible) {
    ++rejected_segments_;
    return {};
  }
  // A filter may go on sending what it knew when the physics behind it has died: only a newer sample is fresh.
  // So is one that has lain here, as after a gap in time, no longer.
  const Duration age = now - stamp.valid;
  const Duration left = trusted_for(s, age);
  const bool fresh = (!any_segment_ || stamp.valid > newest_valid_) && now - stamp.produced < stale_after_ &&
                     age < sample_age_max_ && left > Duration{};
  if (fresh) newest_valid_ = stamp.valid;
  if (!fresh) ++stale_segments_;
  any_segment_ = true;
  used_ = stamp;
  newest_ = s;
  return fresh ? left : Duration{};
}

void DeviceNode::end_if_it_failed_for_long(Time now, DeviceHealth health) {
  if (health != DeviceHealth::read_failed && !write_failed_) {
    failing_since_.reset();
    return;
  }
  if (!failing_since_) failing_since_ = now;
  const Duration failing = now - *failing_since_;
  if (failing < failure_timeout_ || !gate_.at_rest()) return;
  throw RunError("device " + name_ + " could not be " + (health == DeviceHealth::read_failed ? "read" : "written") +
                 " for " + std::to_string(failing.seconds()) + " s: " + failure() +
                 "; its parameter failure_timeout (" + std::to_string(failure_timeout_.seconds()) +
                 " s) says how long that may last");
}

void DeviceNode::step(StepContext& context) {
  const Time now = context.now();
  const DeviceHealth health = read_device(now);

  SafetyInput input;
  input.now = now;
  input.fresh_for = take_segment(now);
  input.fresh_segment = input.fresh_for > Duration{};
  if (any_segment_) {
    Wrench wanted_D_W = evaluate(newest_, now);
    if (!rotates_) wanted_D_W.torque = {};
    interpolated.send(now, wanted_D_W);
    input.wanted_D_W = wanted_D_W;
  }
  input.V_WD = sample_.state.V_WD;
  if (!rotates_) input.V_WD.w = {};
  input.health = health;
  input.dead_man_held =
      dead_man_button_ == 0 || (static_cast<std::uint32_t>(sample_.state.buttons) >> (dead_man_button_ - 1) & 1U) != 0;
  input.in_workspace = sample_.in_workspace;
  input.expired = std::exchange(sample_.expired, false);
  input.permitted = context.phase() == Phase::running;

  const SafetyOutput output = gate_.tick(input);
  write_failed_ = !write(now, output.commanded_D_W);
  commanded.send(now, output.commanded_D_W);
  safety.send(now, output.safety);
  if (context.phase() == Phase::stopping && !gate_.at_rest()) context.not_at_rest();
  if (FlightDevice* const flight = context.flight()) tell(*flight, input, output, context.phase());
  end_if_it_failed_for_long(now, health);
}

void DeviceNode::tell(FlightDevice& flight, const SafetyInput& input, const SafetyOutput& output, Phase phase) const {
  constexpr float none = std::numeric_limits<float>::quiet_NaN();
  constexpr FlightVector no_vector{none, none, none};
  flight.p_WD = any_sample_ ? flight_vector(sample_.state.X_WD.p) : no_vector;
  flight.v_WD = any_sample_ ? flight_vector(sample_.state.V_WD.v) : no_vector;
  flight.wanted_force = input.wanted_D_W ? flight_vector(input.wanted_D_W->force) : no_vector;
  flight.wanted_torque = input.wanted_D_W ? flight_vector(input.wanted_D_W->torque) : no_vector;
  flight.commanded_force = flight_vector(output.commanded_D_W.force);
  flight.commanded_torque = flight_vector(output.commanded_D_W.torque);
  flight.result_age_s = any_segment_ ? static_cast<float>((input.now - used_.valid).seconds()) : none;
  flight.sample_age_s = any_sample_ ? static_cast<float>((input.now - sample_.time).seconds()) : none;
  flight.gain = static_cast<float>(output.safety.gain);
  const std::optional<LineTotals> totals = line_totals();
  flight.generated_J = totals ? static_cast<float>(totals->generated_J) : none;
  flight.allowed_J = totals ? static_cast<float>(totals->allowed_J) : none;
  flight.engagement = static_cast<std::uint8_t>(output.safety.engagement);
  flight.cause = static_cast<std::uint8_t>(output.safety.cause);
  flight.health = static_cast<std::uint8_t>(input.health);
  flight.phase = static_cast<std::uint8_t>(phase);
}

ForceAccount DeviceNode::account() const {
  ForceAccount account;
  account.gate = gate_.account();
  account.dead_man_button = dead_man_button_;
  account.fed = segment.connected();
  account.segments = segments_;
  account.refused = rejected_segments_;
  account.not_fresh = stale_segments_;
  return account;
}

}  // namespace tactor
