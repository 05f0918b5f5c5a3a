// device.simulated: a haptic device and the hand on it, in software.
#pragma once

#include <optional>
#include <vector>

#include "devices/simulated/encoder.hpp"
#include "devices/simulated/handle.hpp"
#include "devices/simulated/line.hpp"
#include "devices/simulated/response.hpp"
#include "framework/core/messages.hpp"
#include "framework/node/info.hpp"
#include "framework/realtime/declare_line.hpp"
#include "framework/realtime/device_node.hpp"

namespace tactor {

/// The device: each tick it moves the handle and shows its state through the encoders. What is commanded is what
/// DeviceNode lets through.
///
/// Loop open: the handle is where the target says. Loop closed: handle and hand are a body, or two with a transmission
/// or a grip between, or three with both (see `Handle`), that the commanded wrench, held from tick to tick, and the
/// hand move. The encoders are on the motor side; `truth` is the handle, where the hand holds. In an open loop there is
/// neither transmission nor grip.
///
/// Lines: the state of tick n is that of tick n - d_in, the command of tick n acts from tick n + d_out on, both a whole
/// number of ticks (see `delay_in_ticks`), whatever time lies between the ticks. A state is stamped with the time of
/// reading, because the host of a real device does not know how old it is. Before the first state has come over the
/// line it shows the first one, before the first command it holds zero.
///
/// A command that is not renewed for `command_ticks` has expired, as it does on the line of a real device: the motors
/// have zero from then on until the next tick, and what was on the line is gone.
///
/// Its line counts the energy at the host's end, with what it knows of its own delays, and bounds it where the graph
/// says `energy_bound` (see LineEnergy).
///
/// In a reference run the loop is not closed a second time: the handle goes along the path of the run under test, so
/// that both runs are judged on one motion. The path is that of the handle, not of the motor side: it is what the hand
/// feels. The reference's encoders are there too, without steps, noise and delay. What is judged is the commanded
/// force; amplifiers, limits and delays reach it by the motion that they make. The reference's `motors` give what is
/// commanded.
class SimulatedDevice final : public DeviceNode {
 public:
  enum class Loop { open, closed };
  struct Params : DeviceParams, VelocityParams, LineParams {
    Loop loop = Loop::open;
    double encoder_step = 0;             ///< m
    double encoder_step_angle = 0;       ///< rad
    double mass = 0;                     ///< kg, of the handle
    double damping = 0;                  ///< N s/m
    double friction = 0;                 ///< N
    double hand_mass = 0;                ///< kg
    double hand_damping = 0;             ///< N s/m
    double hand_stiffness = 0;           ///< N/m
    double grip_stiffness = 0;           ///< N/m; with grip_damping 0: rigid
    double grip_damping = 0;             ///< N s/m
    double inertia = 0;                  ///< kg m^2, of the handle
    double damping_angle = 0;            ///< N m s/rad
    double friction_angle = 0;           ///< N m
    double hand_inertia = 0;             ///< kg m^2
    double hand_damping_angle = 0;       ///< N m s/rad
    double hand_stiffness_angle = 0;     ///< N m/rad
    double grip_stiffness_angle = 0;     ///< N m/rad; with grip_damping_angle 0: rigid
    double grip_damping_angle = 0;       ///< N m s/rad
    double sub_step = 0;                 ///< s
    double amplifier_bandwidth = 0;      ///< Hz; 0: no pole
    double motor_force_max = 0;          ///< N; 0: none
    double motor_torque_max = 0;         ///< N m; 0: none
    double cogging = 0;                  ///< N, amplitude
    double cogging_period = 0;           ///< m
    double breakaway = 0;                ///< N
    double stribeck_velocity = 0;        ///< m/s
    double breakaway_angle = 0;          ///< N m
    double stribeck_velocity_angle = 0;  ///< rad/s
    double mode_frequency = 0;           ///< Hz; 0: motor side and handle are one
    double mode_damping = 0;             ///< ratio
    double motor_share = 0;              ///< of `mass`
    double backlash = 0;                 ///< m, the whole gap
    double encoder_noise = 0;            ///< m, root of the mean square
    double encoder_noise_angle = 0;      ///< rad
    double delay_in = 0;                 ///< s
    double delay_out = 0;                ///< s
    std::int32_t command_ticks = 2;      ///< for which a command acts that is not renewed; 0: for ever
  };

  SimulatedDevice(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void follow(const Node& tested) override;
  [[nodiscard]] bool must_be_followed() const override { return params_.loop == Loop::closed; }
  /// That of DeviceNode; device.saturated_ticks where the motors have a limit; and in closed loop:
  /// device.energy_generated_J, the most energy that the motors had given to the device, net, at any time of the run
  /// (passivity observer at the port; 0 for a passive rendering), device.max_speed_m_per_s of the handle, and
  /// device.unkept_path_samples, ticks beyond the two million whose path is kept: a reference run does not know where
  /// the handle was then.
  void report(Report& report) const override;
  /// Of the line, in closed loop.
  [[nodiscard]] std::optional<LineTotals> line_totals() const override;

  Input<Target> target;
  Output<DeviceState> truth;
  Output<Wrench> motors;

 protected:
  ReadResult read(Time now, DeviceSample& sample) noexcept override;
  bool write(Time now, const Wrench& commanded_D_W) noexcept override;
  [[nodiscard]] const char* failure() const noexcept override;

 private:
  /// Whether the energy of its port and its path count: in closed loop, and not where it follows another run.
  [[nodiscard]] bool observes_port() const { return params_.loop == Loop::closed && !follows_; }
  struct Sample {
    Time t;
    MotionState motion;
  };

  [[nodiscard]] MotionState target_at(Time now) const;
  [[nodiscard]] std::optional<Time> expiry(Time now) const;
  void move_handle(Time now, const MotionState& to);
  [[nodiscard]] MotionState followed_at(Time now);
  void keep_on_path(Time now);

  Params params_;
  Handle handle_;
  Encoder encoder_;
  SimulatedLine line_;
  bool started_ = false;
  Time last_;
  MotionState target_state_;     // of the last tick
  MotionState motion_;           // of the handle, true
  MotionState encoded_;          // of where the encoders are, true
  double energy_generated_ = 0;  // J, the largest that the motors had given
  std::uint64_t saturated_ticks_ = 0;
  double max_speed_ = 0;      // m/s
  std::vector<Sample> path_;  // closed loop: the true motion, for the reference run; never beyond its reserve
  std::uint64_t unkept_ = 0;  // samples for which that had no room
  bool follows_ = false;
  std::vector<Sample> followed_;
  std::size_t followed_leg_ = 0;
};

/// The linear part of the device with those parameters, for its frequency response (`position_response`).
LinearDevice linear_device(const SimulatedDevice::Params& params);

}  // namespace tactor
