// prediction.local: goes back to the stamp of each physics result and simulates from there to now.
#pragma once

#include <array>
#include <memory>

#include "framework/core/messages.hpp"
#include "framework/core/refusals.hpp"
#include "framework/node/declare.hpp"
#include "nodes/physics/contact/patch_contacts.hpp"
#include "nodes/physics/mechanics/contact_fit.hpp"
#include "nodes/physics/mechanics/handle_track.hpp"
#include "nodes/physics/mechanics/local_model.hpp"
#include "nodes/physics/mechanics/local_rollout.hpp"

namespace tactor {

/// The newest contact sets of an input, for results that come with them or later.
class ContactSetTrack {
 public:
  void take(Input<ContactSet>& input) {
    while (input.connected() && input.pop(sets_[taken_ % sets_.size()])) ++taken_;
  }
  /// The contacts of the result of that time: the first set whose query began no earlier; null where there is none.
  [[nodiscard]] const ContactSet* of(Time result) const;
  /// The set of exactly that time; null where there is none.
  [[nodiscard]] const ContactSet* at(Time result) const;

 private:
  std::array<Stamped<ContactSet>, 8> sets_;  // a ring
  std::size_t taken_ = 0;
};

/// For each physics result: puts the bodies where it has them, moves them through the device samples since its stamp
/// against the contacts around them (LocalRollout), and sends what to go on from. A step is `min_step` long at least,
/// but for the last, so that a device of a higher rate does not make a result cost more. What deforms around the tool
/// is moved together with it. With physics' own contact force it learns how stiff and how rough these are (ContactFit),
/// and corrects them before they are used.
class LocalPredictor final : public Node, public Refusing {
 public:
  struct Params : SoftContactOptions {
    std::int32_t iterations = 0;
    double stick_velocity = 0;  // m/s
    Integrator integrator = Integrator::implicit_euler;
    bool resimulate = true;
    bool curvature = true;
    bool fit = true;
    Duration min_step;
    double stiffness_scale = 0;
    double friction_scale = 0;
  };
  LocalPredictor(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  [[nodiscard]] const Refusals& refusals() const override { return refused_; }

  Input<BodyStates> bodies;
  Input<LocalContacts> contacts;
  Input<LocalPatch> patch;
  Input<ContactSet> found;
  Input<ContactSet> used;
  Input<PhysicsState> state;
  Input<CouplingParameters> coupling;
  Input<DeviceState> device;
  Output<LocalModel> model;

 private:
  static void declare_metrics(Declare<LocalPredictor>& node);
  [[nodiscard]] bool take_contacts(Time result);
  [[nodiscard]] bool take_found(Time result);
  [[nodiscard]] bool take_patch(Time result);
  bool send(Time result);
  [[nodiscard]] RefusalReason take_result(const Stamped<BodyStates>& result, const CouplingParameters& spring);
  [[nodiscard]] std::size_t next_step(std::size_t sample) const;
  void fit_contacts(const Stamped<BodyStates>& result);

  Params params_;
  std::unique_ptr<SoftContactSource> soft_;  // null where nothing deforms
  LocalRollout rollout_;
  std::unique_ptr<ArrayPool<PatchMode>> modes_;
  ContactFit fit_;
  ContactSetTrack found_sets_, used_sets_;
  LocalModel start_;
  HandleTrack<2048> track_;
  Refusals refused_{"results", "contacts"};
  std::int64_t results_ = 0, resimulated_ = 0, left_out_of_fit_ = 0;
};

}  // namespace tactor
