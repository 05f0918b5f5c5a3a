// What every device does at a tick: read, evaluate the segment, pass the safety gate, write, and tell what happened.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "framework/core/messages.hpp"
#include "framework/node/node.hpp"
#include "framework/realtime/flight_record.hpp"
#include "framework/realtime/line_energy.hpp"
#include "framework/realtime/safety_gate.hpp"

namespace tactor {

/// The parameters that every device has; `declare_device` declares them.
struct DeviceParams : SafetyLimits {
  double rate = 1000;  ///< Hz, of the ticks
  /// 1 for the first bit of DeviceState::buttons; 0: there is none; absent: the first one, where the device has one.
  std::optional<std::int32_t> dead_man_button;
  Duration failure_timeout{1'000'000'000};  ///< a device that fails for longer ends the run
  Duration sample_age_max{500'000'000};     ///< a force that was made from an older device sample is not fresh
};

/// What a device shows of itself.
struct DeviceSample {
  DeviceState state;
  Time time;  ///< of the state
  bool in_workspace = true;
  bool expired = false;  ///< since the last reading the motors have let go of a command that was not renewed in time
};

/// The causes that each have a metric of their own.
inline constexpr std::array<SafetyCause, 9> reported_causes{
    SafetyCause::not_finite,   SafetyCause::overspeed,         SafetyCause::read_failed,
    SafetyCause::write_failed, SafetyCause::time_reversed,     SafetyCause::dead_man,
    SafetyCause::time_gap,     SafetyCause::outside_workspace, SafetyCause::expired};

enum class ReadResult : std::uint8_t {
  sample,   ///< there is a sample
  not_yet,  ///< there has never been one; after the first it counts as failed
  failed,
};

/// The base of every device: a step is one tick, with the wrench passed through the safety gate between the newest
/// fresh segment and the device.
///
/// A segment is used where its message is newer than every one before, in time of production and in sequence, and where
/// its times make sense: begin <= end, and all of them within a minute of now. Other messages are counted and not used.
/// It is fresh, and keeps the wrench from being faded out, where it was made from a newer device sample than every one
/// before, which its time of validity tells, became visible less than stale_after ago and is
/// not older than sample_age_max. Where it states a trust_time, it is fresh until that sample is as old as that, and no
/// longer than stale_after: a pipeline can shorten what the device grants, and never lengthen it. A translation-only
/// scene gets no torque.
///
/// A step allocates, locks and waits for nothing, if `read` and `write` do not. It throws in one case: RunError, after
/// zero has been commanded, where the device could not be read or written for failure_timeout.
class DeviceNode : public Node {
 public:
  void step(StepContext& context) final;
  /// The largest force and torque from now on (see SafetyGate::set_largest); the other parameters stay.
  void tune(const DeviceParams& params) noexcept { gate_.set_largest(params.force_max, params.torque_max); }
  /// Its safety gate, asked after a run.
  [[nodiscard]] const SafetyGate& gate() const { return gate_; }
  /// Messages that were no fresh segments.
  [[nodiscard]] std::uint64_t rejected_segments() const { return rejected_segments_; }
  /// True where no button stops the force and the parameters do not ask for that.
  [[nodiscard]] bool lacks_dead_man() const { return lacks_dead_man_; }
  /// What became of its force so far; asked after a run.
  [[nodiscard]] virtual ForceAccount account() const;
  /// What was counted on its line so far; absent where nothing is.
  [[nodiscard]] virtual std::optional<LineTotals> line_totals() const { return std::nullopt; }

  Input<ForceSegment> segment;
  Output<DeviceState> state;
  Output<Wrench> interpolated;
  Output<Wrench> commanded;
  Output<SafetyState> safety;

 protected:
  /// `buttons`: how many the device has; absent where nobody knows. Throws InputError where the limits cannot be, or
  /// the device has no such dead-man button.
  DeviceNode(const DeviceParams& params, const NodeContext& context, std::optional<int> buttons = {});

  /// Reads the device, or the newest sample that is there; returns at once.
  virtual ReadResult read(Time now, DeviceSample& sample) noexcept = 0;
  /// Gives the device its wrench (N, N m, on the device, in W); returns at once, false where it was not taken. Called
  /// every tick, and with zero as well where the device could not be read.
  virtual bool write(Time now, const Wrench& commanded_D_W) noexcept = 0;
  /// Why the last read or write failed, in the words of the device.
  [[nodiscard]] virtual const char* failure() const noexcept = 0;

  /// True where torque has a meaning.
  [[nodiscard]] bool rotates() const { return rotates_; }

 private:
  DeviceHealth read_device(Time now);
  /// How long the segment that has come stays fresh; zero: none has come, or it is not fresh.
  Duration take_segment(Time now);
  void end_if_it_failed_for_long(Time now, DeviceHealth health);
  void tell(FlightDevice& flight, const SafetyInput& input, const SafetyOutput& output, Phase phase) const;

  std::string name_;
  bool rotates_;
  std::int32_t dead_man_button_;
  bool lacks_dead_man_;
  Duration failure_timeout_;
  Duration stale_after_;
  Duration sample_age_max_;
  SafetyGate gate_;

  DeviceSample sample_;
  bool any_sample_ = false;
  bool write_failed_ = false;  // at the last tick
  std::optional<Time> failing_since_;

  ForceSegment newest_;
  bool any_segment_ = false;
  Stamp used_;         // of the segment in use
  Time newest_valid_;  // of the newest fresh segment
  Stamp seen_;         // of the newest message
  bool any_seen_ = false;
  std::uint64_t segments_ = 0, rejected_segments_ = 0, stale_segments_ = 0;
};

}  // namespace tactor
