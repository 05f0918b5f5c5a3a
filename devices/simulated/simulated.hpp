// device.simulated: a haptic device and the hand on it, in software.
#pragma once

#include <vector>

#include "devices/simulated/encoder.hpp"
#include "devices/simulated/handle.hpp"
#include "framework/core/messages.hpp"
#include "framework/node/info.hpp"
#include "framework/realtime/device_node.hpp"

namespace tactor {

/// The device: each tick it moves the handle and shows its state through the encoders. What is commanded is what
/// DeviceNode lets through.
///
/// Loop open: the handle is where the target says. Loop closed: handle and hand are a body (see `Handle`) that the
/// commanded wrench, held from tick to tick, and the hand move. In a reference run the loop is not closed a second
/// time: the handle goes along the path of the run under test, so that both runs are judged on one motion.
class SimulatedDevice final : public DeviceNode {
 public:
  enum class Loop { open, closed };
  struct Params : DeviceParams {
    Loop loop = Loop::open;
    double encoder_step = 0;              ///< m
    double encoder_step_angle = 0;        ///< rad
    double velocity_departure = 0;        ///< m, in 10 ms
    double velocity_departure_angle = 0;  ///< rad, in 10 ms
    double mass = 0;                      ///< kg, of the handle
    double damping = 0;                   ///< N s/m
    double friction = 0;                  ///< N
    double hand_mass = 0;                 ///< kg
    double hand_damping = 0;              ///< N s/m
    double hand_stiffness = 0;            ///< N/m
    double inertia = 0;                   ///< kg m^2, of the handle
    double damping_angle = 0;             ///< N m s/rad
    double friction_angle = 0;            ///< N m
    double hand_inertia = 0;              ///< kg m^2
    double hand_damping_angle = 0;        ///< N m s/rad
    double hand_stiffness_angle = 0;      ///< N m/rad
    double sub_step = 0;                  ///< s
  };

  SimulatedDevice(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void follow(const Node& tested) override;
  [[nodiscard]] bool must_be_followed() const override { return params_.loop == Loop::closed; }
  /// That of DeviceNode, and in closed loop: device.energy_generated_J, the most energy that the commanded wrench had
  /// given to the handle, net, at any time of the run (passivity observer at the port; 0 for a passive rendering),
  /// device.max_speed_m_per_s, and device.unkept_path_samples, ticks beyond the two million whose path is kept: a
  /// reference run does not know where the handle was then.
  void report(Report& report) const override;

  Input<Target> target;
  Output<DeviceState> truth;

 protected:
  ReadResult read(Time now, DeviceSample& sample) noexcept override;
  bool write(Time now, const Wrench& commanded_D_W) noexcept override;
  [[nodiscard]] const char* failure() const noexcept override;

 private:
  struct Sample {
    Time t;
    MotionState motion;
  };

  [[nodiscard]] MotionState target_at(Time now) const;
  void move_handle(Time now);
  [[nodiscard]] MotionState followed_at(Time now);
  void keep_on_path(Time now);

  Params params_;
  Handle handle_;
  Encoder encoder_;
  bool started_ = false;
  Time last_;
  MotionState target_state_;     // of the last tick
  MotionState motion_;           // of the handle, true
  Wrench held_D_W_;              // commanded at the last tick, held since
  double energy_ = 0;            // J, given to the handle so far
  double energy_generated_ = 0;  // J, the largest of it
  double max_speed_ = 0;         // m/s
  std::vector<Sample> path_;     // closed loop: the true motion, for the reference run; never beyond its reserve
  std::uint64_t unkept_ = 0;     // samples for which that had no room
  bool follows_ = false;
  std::vector<Sample> followed_;
  std::size_t followed_leg_ = 0;
};

}  // namespace tactor
