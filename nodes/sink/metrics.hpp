// The judge of a run: what the device was told to display against what an ideal run would have displayed.
#pragma once

#include <cstdint>
#include <vector>

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/new_messages.hpp"
#include "nodes/sink/run_stability.hpp"

namespace tactor {

/// sink.metrics: stores what arrives while the run goes on and computes its metrics afterwards (see declare()). Of a
/// run until stopped it stores the newest minute, and up to two: its memory does not grow, and the judged interval lies
/// there.
class Metrics final : public Node {
 public:
  struct Params {
    Duration settle;
    double jnd_force = 0;     // N
    double jnd_torque = 0;    // N m
    double jnd_fraction = 0;  // of the reference
    double handle_mass = 0;   // kg
    Duration max_delay;
    double loss_force = 0;   // N
    double loss_torque = 0;  // N m
    Duration loss_window;
    Duration rest;
    double rest_peak_to_peak = 0;   // m
    double encoder_step = 0;        // m
    double encoder_step_angle = 0;  // rad
    bool tool_weight = true;        // the method displays it
    double delay_in = 0;            // s, of the device's line
    double delay_out = 0;           // s
  };
  Metrics(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  void report(Report& report) const override;

  Input<Wrench> commanded;
  Input<Wrench> force;
  Input<Forecast> forecast;
  Input<PhysicsState> state;
  Input<DeviceState> device;
  Input<DeviceState> true_device;  ///< the port `truth`

 private:
  struct Contacts {
    Time produced;
    Time valid;
    std::int32_t count = 0;
  };
  /// One part of a wrench, with the name, the unit and the thresholds its metrics have.
  struct Part {
    const char* name;
    const char* unit;
    Vec3 Wrench::*member;
    double jnd;
    double loss;
  };

  /// Errors of the first step predicted, in N or N m.
  struct OneStep {
    std::vector<double> time;       ///< s, of the physics force that was predicted
    std::vector<double> predicted;  ///< the norm of the error
    std::vector<double> held;       ///< of a hold instead
  };

  /// What was displayed, and what the reference run wanted then; `wanted` is empty without one.
  struct Delivered {
    std::vector<double> time;  ///< s
    std::vector<Vec3> shown, wanted;
  };

  [[nodiscard]] Part force_part() const {
    return {"force", "N", &Wrench::force, params_.jnd_force, params_.loss_force};
  }
  [[nodiscard]] Part torque_part() const {
    return {"torque", "Nm", &Wrench::torque, params_.jnd_torque, params_.loss_torque};
  }
  /// Takes out what is older than the newest minute, once that makes two.
  void forget(Time now);
  /// When the judged interval begins: all nodes are warm, `settle` has passed since, and nothing later was forgotten.
  [[nodiscard]] Time begin_of(const Report& report) const;
  /// Of commands in [from, until), none after the reference run's end.
  [[nodiscard]] Delivered delivered(const Part& part, Time from, Time until) const;
  /// Of forecasts stamped in [from, until).
  [[nodiscard]] OneStep one_step(const Part& part, Time from, Time until) const;
  void report_interval(Report& report) const;
  void report_cold_start(Report& report) const;
  void report_delivered(Report& report, const Part& part) const;
  void report_one_step(Report& report, const Part& part, bool series) const;
  void report_physics(Report& report) const;
  void report_physics_error(Report& report, const Part& part) const;
  void report_contacts(Report& report) const;
  void report_displacement(Report& report) const;
  void report_stability(Report& report) const;
  void report_port(Report& report) const;

  Params params_;
  bool torque_;
  bool whole_;      // the run has an end of its own
  Time kept_from_;  // what is older has been forgotten
  std::uint64_t physics_steps_ = 0;
  double mass_ = 0;  // kg, of the tool
  Vec3 gravity_W_;   // m/s^2
  NewMessages<Wrench> new_commanded_;
  NewMessages<Wrench> new_force_;
  NewMessages<Forecast> new_forecast_;
  NewMessages<PhysicsState> new_state_;
  NewMessages<DeviceState> new_device_;
  NewMessages<DeviceState> new_truth_;
  std::vector<Stamped<Wrench>> commands_;
  std::vector<Stamped<Wrench>> forces_;
  std::vector<Stamped<Forecast>> forecasts_;
  std::vector<Contacts> contacts_;
  std::vector<ToolSample> tools_;
  std::vector<HandleSample> positions_;
  std::vector<HandleSample> true_positions_;
};

}  // namespace tactor
