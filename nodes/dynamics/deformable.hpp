// dynamics.deformable: elastic bodies and the rigid ones that touch them.
#pragma once

#include <memory>
#include <optional>

#include "framework/core/refusals.hpp"
#include "framework/node/declare.hpp"
#include "nodes/dynamics/dynamics_node.hpp"
#include "nodes/physics/contact/patch_contacts.hpp"
#include "nodes/physics/deformable/condensation.hpp"
#include "nodes/physics/mesh/deformed_surfaces.hpp"

namespace tactor {

/// Steps deformable and rigid bodies together (DeformableStep) through the samples of the handle: in equal steps of at
/// most `substep` from the sample used last to the newest one in time, but in no more than `most_substeps`, so that
/// slow physics does not make itself slower. Nothing is done until that sample is `min_step` later. A state is stamped
/// with the time of the last sample it used. Throws InputError where nothing deforms or nothing moves as a whole, and
/// RunError at the first coupling of a massless tool.
class DeformableDynamics final : public Node, public Refusing {
 public:
  struct Params : DynamicsParams, SoftContactOptions, DeformableOptions {
    Integrator integrator = Integrator::implicit_euler;
    bool settle = true;
    std::int32_t most_substeps = 0;
    Duration min_step;
  };
  DeformableDynamics(const Params& params, const NodeContext& context);
  ~DeformableDynamics() override;
  static NodeInfo declare();
  void step(StepContext& context) override;
  [[nodiscard]] const Refusals& refusals() const override { return handle_.refusals(); }
  [[nodiscard]] const DynamicsCounts& counts() const { return counts_; }

  Input<ContactSet> contacts;
  Input<DeviceState> device;
  Input<CouplingParameters> coupling;
  Output<PhysicsState> state;
  Output<LocalPatch> patch;
  Output<DeformedSurfaces> surfaces;
  Output<BodyStates> bodies;
  Output<BodyStates> expected;

 private:
  static void declare_metrics(Declare<DeformableDynamics>& d);
  [[nodiscard]] double mean_of_a_step(std::int64_t count) const;
  bool take_samples(Time until);
  void begin(const CouplingParameters& spring);
  void advance(const CouplingParameters& spring, const ContactPlanes& planes);
  void send();
  void send_expected();

  Params params_;
  std::unique_ptr<SoftScene> soft_;
  std::unique_ptr<ContactBody> tool_;
  std::unique_ptr<SoftContacts> soft_contacts_;
  std::optional<DeformableStep> step_;
  std::optional<Condensation> condensation_;
  std::optional<ArrayPool<ShownPoint>> surface_pool_;
  BodyStates bodies_;
  HandleSamples handle_;
  Stamped<DeviceState> used_;    // the last sample the bodies were moved to
  Stamped<DeviceState> newest_;  // the newest one in time
  bool begun_ = false, has_newest_ = false;
  StepResult last_{.outcome = StepOutcome::converged};
  DynamicsCounts counts_;
  std::int64_t unsent_ = 0;
};

}  // namespace tactor
