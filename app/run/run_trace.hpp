// A trace of a run for its page: force, position and safety gate of the devices, and the scene at the largest force.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/run/envelope.hpp"
#include "framework/core/messages.hpp"
#include "framework/session/session.hpp"

namespace tactor {

/// The moment at which a safety gate began to keep the force out.
struct GateEvent {
  double time_s = 0;
  SafetyCause cause = SafetyCause::none;
};

/// What became of a device over the run. A curve without values is of an output that the device does not have.
struct DeviceTrace {
  std::string device;             ///< the name of its node
  Series force;                   ///< N, norm of the force that it was told to display
  Series displacement;            ///< m, of the handle from where it was first
  Series gate;                    ///< 0 to 1, the part of the force that the safety gate lets through
  std::vector<GateEvent> events;  ///< but for those before the gate was open first
};

/// The largest force that a device was told to display, and where the scene's moving bodies were.
struct LargestForce {
  double time_s = 0;
  Vec3 force_W;            ///< N, on the hand
  std::vector<Pose> X_WB;  ///< of Scene::moving(); fewer where the run does not tell all
};

struct RunTrace {
  std::vector<DeviceTrace> devices;
  std::optional<LargestForce> largest;  ///< none where no force above 0 was told to any device
  std::uint64_t lost = 0;               ///< messages that were not taken in time, and events beyond 1,000 a device
};

/// Follows a session by taps. Made before it starts, and ended before it.
class RunTracer {
 public:
  explicit RunTracer(Session& session);
  /// Takes what has come; to be called at least ten times a second.
  void attend();
  /// What was followed up to the last call of `attend`.
  [[nodiscard]] RunTrace trace() const;

 private:
  using Tap = std::unique_ptr<Session::OutputTap>;
  static constexpr std::size_t pieces_of_curve = 1750;
  struct Device {
    std::string name;
    Tap commanded, state, safety;  // null: it has none
    Envelope force{pieces_of_curve}, displacement{pieces_of_curve}, gate{pieces_of_curve};
    std::optional<Vec3> began_p_W;
    std::vector<GateEvent> events;
    bool was_open = false;
    SafetyCause cause = SafetyCause::none;
  };
  void take_bodies();
  void take(Device& device);
  void take_safety(Device& device, double time_s, const SafetyState& safety);
  void take_force(double time_s, const Vec3& force_W);

  std::vector<Device> devices_;
  Tap bodies_;  // of BodyStates, or of PhysicsState where no node tells more than the tool
  struct Poses {
    double time_s = 0;
    std::vector<Pose> X_WB;
  };
  std::vector<Poses> poses_;  // the last of the call before, and those since
  std::optional<LargestForce> largest_;
  std::uint64_t lost_events_ = 0;
};

}  // namespace tactor
