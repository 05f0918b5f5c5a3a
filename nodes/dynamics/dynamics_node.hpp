// What every kind of dynamics does: moves the bodies through the recorded samples of the handle.
#pragma once

#include <limits>

#include "framework/core/refusals.hpp"
#include "framework/node/node.hpp"
#include "nodes/dynamics/handle_samples.hpp"
#include "nodes/dynamics/passivity.hpp"
#include "nodes/physics/mechanics/local_patch.hpp"
#include "nodes/physics/mechanics/rigid_step.hpp"

namespace tactor {

/// The parameters of every kind of dynamics.
struct DynamicsParams {
  enum class AdvanceTo { contacts, now };
  double substep = 0;         ///< s
  double stick_velocity = 0;  ///< m/s
  std::int32_t iterations = 0;
  AdvanceTo advance_to = AdvanceTo::contacts;
  bool start_at_device = true;
};

/// Those of the kinds whose bodies all have mass.
struct InertialParams : DynamicsParams {
  bool error_estimate = false;
  double substep_tolerance = 0;                                      ///< m, 0: the sub-step is fixed
  double min_substep = 0;                                            ///< s
  double dissipate_above = std::numeric_limits<double>::infinity();  ///< J
  Integrator integrator = Integrator::implicit_euler;
};

/// How often things happened in the sub-steps of a run.
struct DynamicsCounts {
  std::int64_t steps = 0;
  std::int64_t damped = 0;    ///< Newton's method did not solve them
  std::int64_t stopped = 0;   ///< nothing solved them
  std::int64_t left_out = 0;  ///< contacts that could not be used
};

/// Sub-steps the bodies through the samples of the handle (rigid_step.hpp has the equations). Each interval between two
/// samples is cut into equal sub-steps of at most `substep`, with the handle moving steadily from one to the other.
/// A state is stamped with the time of the last sample it used.
///
/// The error estimate compares each sub-step with two of half its length: the local error of implicit Euler being of
/// second order, the one is off by about twice the difference; of the midpoint rule, of third order, by four thirds of
/// it. That estimate, summed over the sub-steps between two
/// samples of the handle, is the position error of the tool that a sample adds. With a tolerance, a sub-step of a
/// larger estimate is taken anew with a shorter one, down to `min_substep`. The estimate alone changes no result.
class DynamicsNode : public Node, public Refusing {
 public:
  void step(StepContext& context) override;
  [[nodiscard]] const Refusals& refusals() const override { return handle_.refusals(); }
  [[nodiscard]] const DynamicsCounts& counts() const { return counts_; }
  /// The energy that steps and contacts made and lost.
  [[nodiscard]] const PassivityObserver& observer() const { return observer_; }
  /// m, that a sample of the handle adds, estimated; empty if nothing is estimated.
  [[nodiscard]] std::optional<double> position_error_max() const;
  [[nodiscard]] std::optional<double> position_error_mean() const;

  Input<ContactSet> contacts;
  Input<DeviceState> device;
  Input<CouplingParameters> coupling;
  Output<PhysicsState> state;
  Output<LocalPatch> patch;  // nothing: nothing deforms here
  Output<BodyStates> bodies;
  Output<BodyStates> expected;

 protected:
  /// `type`: the node's, for messages. Throws InputError where the scene has no moving body, a moving body's mesh is no
  /// solid, or the bounds of the sub-step are reversed.
  DynamicsNode(std::string type, const InertialParams& params, bool massless, const NodeContext& context);

 private:
  void begin(const Stamped<DeviceState>& sample);
  void advance(const Stamped<DeviceState>& sample, const CouplingParameters& spring, const ContactPlanes& planes);
  void send_expected(const CouplingParameters& spring, const ContactPlanes& planes);
  double sub_step(const CouplingParameters& spring, const ContactPlanes& planes, const DeviceState& from,
                  const DeviceState& to, double h);
  void observe(const CouplingParameters& spring, const ContactPlanes& planes, const DeviceState& handle, double work);
  [[nodiscard]] bool rotates() const { return solver_.model().body[0].rotates; }

  std::string type_;
  InertialParams params_;
  bool massless_;
  RigidStep solver_;
  BodyStates bodies_;
  double substep_;  // s, what the next sub-step is tried with
  HandleSamples handle_;
  Stamped<DeviceState> used_;  // the last sample the bodies were moved to
  bool begun_ = false;
  StepResult last_{.outcome = StepOutcome::converged};
  StepResult tried_;
  double energy_ = 0;  // J, after the last sub-step
  PassivityObserver observer_;
  double error_sum_ = 0, error_max_ = 0;  // m
  std::int64_t samples_ = 0;
  DynamicsCounts counts_;
};

}  // namespace tactor
