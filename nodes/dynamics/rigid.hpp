// dynamics.rigid: the virtual tool as a rigid body between the handle's spring and the contacts.
#pragma once

#include "framework/node/info.hpp"
#include "nodes/dynamics/rigid_step.hpp"

namespace tactor {

/// Sub-steps the tool through the recorded device samples (rigid_step.hpp has the equations). Each interval between two
/// samples is cut into equal sub-steps of at most `substep`, with the handle moving steadily from one to the other.
/// A state is stamped with the time of the last sample it used. Throws InputError where the scene has no moving body or
/// the tool's mesh is no solid.
class RigidDynamics final : public Node {
 public:
  enum class AdvanceTo { contacts, now };
  struct Params {
    double substep = 0;         ///< s
    double stick_velocity = 0;  ///< m/s
    std::int32_t iterations = 0;
    AdvanceTo advance_to = AdvanceTo::contacts;
    bool start_at_device = true;
  };
  RigidDynamics(const Params& params, const NodeContext& context);
  static NodeInfo declare();

  void step(StepContext& context) override;
  void report(Report& report) const override;

  Input<ContactSet> contacts;
  Input<DeviceState> device;
  Input<CouplingLaw> law;
  Output<PhysicsState> state;
  Output<BodyStates> bodies;

 private:
  bool take_sample(Time until);
  [[nodiscard]] bool rotates() const { return solver_.model().body[0].rotates; }
  void begin(const Stamped<DeviceState>& sample);
  void advance(const Stamped<DeviceState>& sample, const CouplingLaw& spring, const ContactPlanes& planes);

  Params params_;
  RigidStep solver_;
  BodyStates bodies_;
  Stamped<DeviceState> used_;    // the last sample the tool was moved to
  Stamped<DeviceState> sample_;  // the next one, where `waiting_`
  bool begun_ = false;
  bool waiting_ = false;
  StepResult last_;
  std::int64_t steps_ = 0;
  std::int64_t damped_ = 0;
  std::int64_t stopped_ = 0;
  std::int64_t left_out_ = 0;
  std::int64_t rejected_ = 0;
};

}  // namespace tactor
