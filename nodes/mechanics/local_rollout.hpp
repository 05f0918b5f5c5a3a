// Moves the bodies of a scene on from a physics result, against contacts that are held, with the device's motion.
#pragma once

#include "framework/core/messages.hpp"
#include "nodes/mechanics/rigid_step.hpp"

namespace tactor {

/// The local rollout: dynamics' own step (RigidStep) on contacts that follow the surfaces' curvature, from device
/// sample to device sample. Allocates nothing and throws nothing; its work is bounded by contacts and iterations.
class LocalRollout {
 public:
  explicit LocalRollout(const SystemModel& model) : model_(model), step_(model) {}

  /// Goes on from here: from `model.bodies` at `model.time`, with the handle as `model.device` shows it.
  void restart(const LocalModel& model);
  /// Moves the bodies on to the time of `sample`, in one step; those not later than the last are left out. False where
  /// the step failed: then the bodies are where they were.
  bool advance(const Stamped<DeviceState>& sample);

  [[nodiscard]] const LocalModel& model() const { return local_; }
  [[nodiscard]] const Twist& acceleration() const { return acceleration_; }
  /// The tool and the handle, with the contacts' force of the last step.
  [[nodiscard]] PhysicsState state() const;

 private:
  void find_planes();

  std::array<Contact, LocalContacts::capacity> planes_;
  SystemModel model_;
  RigidStep step_;
  LocalModel local_;
  StepResult last_;
  Twist acceleration_;  // of the tool in the last step
};

}  // namespace tactor
