// The base of every device of hardware: what its line shows becomes a state in the scene, and a wrench its efforts.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "devices/hardware/gripper.hpp"
#include "devices/hardware/guarded_line.hpp"
#include "devices/hardware/kinematics.hpp"
#include "devices/hardware/link_runner.hpp"
#include "devices/hardware/state_path.hpp"
#include "devices/hardware/workspace.hpp"
#include "framework/realtime/declare_line.hpp"
#include "framework/realtime/device_node.hpp"
#include "framework/realtime/latency_histogram.hpp"
#include "framework/realtime/pose_filter.hpp"

namespace tactor {

/// The parameters that all devices of hardware have; `declare_hardware` declares them.
struct HardwareParams : DeviceParams, VelocityParams, LineParams {
  Duration link_timeout{50'000'000};        ///< a sample that is older fails the device
  Duration connect_timeout{5'000'000'000};  ///< so long the first sample may take
  double workspace_scale = 1;
  double force_scale = 1;
  std::vector<double> rotation{0, 0, 0};  ///< rad, rotation vector of R_WB
  std::vector<double> origin{0, 0, 0};    ///< m, p_WB
  Duration stuck_after{1'000'000'000};
  GuardChoice guard = GuardChoice::automatic;
};

/// What a concrete device is made of.
struct HardwareParts {
  std::unique_ptr<Link> link;
  std::unique_ptr<Kinematics> kinematics;  ///< null for a device that shows a pose (AxisLimits::pose)
  AxisLimits limits;                 ///< `stuck_after` is taken from the parameters; the line may have tighter ones
  double rate = 1000;                ///< Hz, of the line's cycles
  std::optional<int> buttons;        ///< how many it has; absent: not known
  double resolution = 1e-5;          ///< m, a step of the position at the handle, for the filter of the velocity
  double resolution_angle = 1e-4;    ///< rad
  double resolution_gripper = 1e-5;  ///< m
  Duration delay_in;                 ///< how old a sample is when its cycle begins, as far as it is known
  Duration delay_out;                ///< from the begin of a cycle to its efforts' acting
  int status = 0;                    ///< values of LinkSample::status that the device has, see declare_status
  std::optional<GuardableLink> guardable;  ///< for the guard; absent: the line is a thread of this process
  std::optional<Duration> watchdog;        ///< without a command for so long the device lets go by itself
  AxisValues effort_continuous{};          ///< N or N m that the motors bear for ever; 0: not known
  AxisValues thermal_time{};               ///< s, of their windings
};

/// Whether the line of such a device runs in the guard. Throws ValueError where it is to and cannot.
bool needs_guard(GuardChoice choice, const HardwareParts& parts);

/// A device of hardware. Its line runs on a LinkRunner's thread, here or in the guard; the loop takes the newest sample
/// there is.
///
/// Reading fails, so the gate lets no force through and comes back by its ramp after recovery_time, where the newest
/// sample is older than link_timeout, where the device reports a fault of its own, where an encoder has jumped or is
/// stuck (see Plausibility), where the kinematics knows no pose, and for one tick after every cut of the line (see
/// LinkRunner). The state carries the time of its sample, not that of the tick; between samples it is repeated.
///
/// The velocity is that of a PoseFilter over the samples in the scene, with the departure of the parameters and the
/// noise of a step of resolution, sqrt(1/12) of it. It is a mean of several filters (PoseFilter). At a constant rate
/// 1/T one of order 3 is a third-order low-pass on differences whose poles have the frequency
/// (q / (noise^2 T))^(1/6) / (2 pi). That of the second of order 3, whose departure is that of the parameters, is
/// reported as device.velocity_cutoff_Hz; the calmest of order 3 has a quarter of the departure, so its cutoff is lower
/// by 4^(1/3).
///
/// A wrench goes through the workspace and J^T. The line shortens the efforts to the limits of the axes (AxisLimits),
/// those of the node or those that the line told when it was opened. Outside the workspace of the axes the gate lets
/// go. A command that the line has not seen renewed for two cycles, of the loop or of the line, whichever are longer,
/// has expired: the device gets zero, and the gate comes back from there by its slew limit.
///
/// A line that sets the pace, at about the rate of the node, sets it for the loop too.
///
/// The line runs in tactor-guard where needs_guard says so. Then a command expires after two periods of the loop, at
/// least 2 ms, and goes to zero within 3 ms, whatever becomes of this process.
///
/// In a reference run nothing is driven: the device goes along the states that it showed in the run under test.
class HardwareDevice : public DeviceNode {
 public:
  ~HardwareDevice() override;
  /// Opens the line. Throws InputError where the device asks for something of the user first, and RunError, within
  /// connect_timeout and 1 s, where no attempt to open it succeeds; a line whose first opening takes longer is waited
  /// for by the run.
  void start(StepContext& context) override;
  void follow(const Node& tested) override;
  [[nodiscard]] bool must_be_followed() const override { return true; }
  /// That of DeviceNode, and device.link.*: cycles, errors.KIND (see LinkError), reconnects, skipped,
  /// age_us.p50/p99/max of the sample in use at each tick, cycle_us.p50/p99, expired; device.jumps,
  /// device.stuck, device.limited_ticks: cycles whose efforts were shortened; device.velocity_cutoff_Hz,
  /// device.velocity_mixed_share; and as remarks the failures of the line with the device's name, and what the system
  /// refused to the line's thread.
  void report(Report& report) const override;
  [[nodiscard]] ForceAccount account() const override;
  [[nodiscard]] Pace* pace() override;
  /// Until the newest report; absent in a reference run.
  [[nodiscard]] std::optional<LineTotals> line_totals() const override;
  /// Of the status value `index`: the newest, and the largest of the run; absent where no sample has come.
  [[nodiscard]] std::optional<double> newest_status(std::size_t index) const;
  [[nodiscard]] std::optional<double> most_status(std::size_t index) const;

  // Of devices that declare them (declare_gripper, declare_status).
  Input<GripperForce> gripper_force;
  Output<GripperState> gripper;
  Output<HardwareStatus> status;

 protected:
  HardwareDevice(const HardwareParams& params, const NodeContext& context, HardwareParts parts);

  ReadResult read(Time now, DeviceSample& sample) noexcept final;
  bool write(Time now, const Wrench& commanded_D_W) noexcept final;
  [[nodiscard]] const char* failure() const noexcept final { return failure_.data(); }

 private:
  void take_in(Time now, Instant clock) noexcept;
  [[nodiscard]] ReadResult fail(const char* format, ...) noexcept __attribute__((format(printf, 2, 3)));
  [[nodiscard]] ReadResult not_connected(Instant clock) noexcept;
  [[nodiscard]] ReadResult judged() noexcept;
  void efforts_of(const Wrench& F_D_W, AxisValues& effort) noexcept;
  [[nodiscard]] bool pose_of(const LinkSample& shown, Pose& X_BD) noexcept;
  void tell_status(Time t) noexcept;

  const HardwareParams params_;
  const Workspace workspace_;
  const Vec3 weight_W_;  // N, of the tool
  const Duration period_of_line_;
  std::unique_ptr<Kinematics> kinematics_;
  std::optional<Gripper> gripper_;
  PoseFilter filter_;
  const double cutoff_Hz_;
  std::unique_ptr<DeviceLine> runner_;
  Instant started_;

  LinkReport report_;
  std::uint64_t samples_seen_ = 0;
  std::uint64_t cuts_seen_ = 0;
  std::uint64_t expiries_seen_ = 0;
  bool has_pose_ = false;
  DeviceSample newest_;
  HardwareStatus status_, most_;  // of the newest sample; the largest values
  std::array<char, 320> failure_{};
  std::unique_ptr<LatencyHistogram> age_;

  StatePath path_;                     // what it showed
  std::optional<StatePath> followed_;  // of the run under test, in a reference run
};

}  // namespace tactor
