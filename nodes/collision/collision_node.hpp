// What every collision node does and declares; what differs is its query.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "nodes/collision/materials.hpp"
#include "nodes/scene/body_mesh.hpp"

namespace tactor {

/// Queries at the tool's last pose (before the first where the scene puts it) each time the device triggers it, sends
/// the contacts stamped with the start of the query, and counts those that penetrate as its work.
class CollisionNode : public Node {
 public:
  void step(StepContext& context) final;

  /// The contacts at a pose of the tool.
  virtual void query(const Pose& X_WT, ContactSet& set) = 0;

  Input<DeviceState> device;
  Input<PhysicsState> state;
  Output<ContactSet> contacts;

 protected:
  Pose X_WT_start_;  ///< where the scene puts the tool

 private:
  ContactSet set_;
};

/// Adds the ports and the margin to the declaration of collision node N.
template <class N>
void declare_collision(Declare<N>& declaration) {
  // The template arguments let pointers to the members of the base class convert.
  declaration.template input<DeviceState>("device", &N::device, {.doc = "says when to query", .trigger = Trigger::yes})
      .template input<PhysicsState>(
          "state", &N::state,
          {.doc = "the last tool pose; before the first the tool is where the scene puts it", .required = false})
      .template output<ContactSet>("contacts", &N::contacts,
                                   "the contacts at that pose, stamped with the start of the query")
      .real("margin", &N::Params::margin,
            {.doc = "distance below which contacts are reported before they touch",
             .unit = "m",
             .default_value = 0.002,
             .min = 0,
             .max = 0.1})
      .on_thread("physics")
      .check_bodies(check_body_meshes)
      .unneeded(nothing_to_hit);
}

}  // namespace tactor
