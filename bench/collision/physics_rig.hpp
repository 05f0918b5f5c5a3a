// One step of physics after another by the project's nodes: the tool of a scene on a coupling, and what it touches.
#pragma once

#include <filesystem>

#include "framework/core/messages.hpp"
#include "nodes/collision/sdf.hpp"
#include "nodes/coupling/adaptive.hpp"
#include "nodes/dynamics/rigid.hpp"

namespace tactor::bench {

/// The bodies of graphs/bunny/scene.yaml: one mesh as the fixed body, whose frame is W, and as the tool.
Scene two_of(const std::filesystem::path& mesh);

/// Where the handle must rest for the coupling to balance the springs of the penetrating contacts on a tool at rest at
/// X_WT.
Pose balancing_handle(const CouplingParameters& coupling, const Pose& X_WT, const ContactSet& set);

/// Where the tool is first.
enum class Start { at_handle, where_the_scene_says };

/// dynamics.rigid and coupling.adaptive with the defaults of their parameters.
class DynamicsRig {
 public:
  explicit DynamicsRig(const Scene& scene, Start start = Start::at_handle);

  /// Moves the tool through a sample of the handle at time t with the contacts of a query then.
  const PhysicsState& advance(Time t, const DeviceState& device, const ContactSet& set);
  /// The force of the coupling in the last state.
  const Wrench& force();

  [[nodiscard]] const CouplingParameters& coupling() const { return parameters_; }
  [[nodiscard]] const PhysicsState& state() const { return state_; }

 private:
  NodeContext context_;
  RigidDynamics dynamics_;
  AdaptiveCoupling coupling_;
  CouplingParameters parameters_;
  Time now_;
  PhysicsState state_;
};

/// The handle at each pose, moving steadily from the one before.
DeviceState device_at(const Pose& X_WD, const Pose& before, double period);

}  // namespace tactor::bench
