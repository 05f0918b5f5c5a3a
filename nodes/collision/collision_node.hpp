// What every collision node does and declares; what differs is its query.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "nodes/collision/materials.hpp"
#include "nodes/scene/body_mesh.hpp"

namespace tactor {

/// Queries where the moving bodies last were (before the first message where the scene puts them) each time the device
/// triggers it, sends the contacts stamped with the start of the query, and counts those that penetrate as its work.
/// The contacts are to serve for as long as the last ones did: since the last query, or since the bodies were there,
/// where that is longer, up to 0.1 s.
/// One moving body is the tool, which `state` tells of; of several `bodies` must tell.
class CollisionNode : public Node {
 public:
  static constexpr double longest_period = 0.1;  ///< s, that a query is to serve for

  void step(StepContext& context) final;

  /// The contacts where the moving bodies are, which are to serve while the bodies move on for `period` seconds.
  virtual void query(const BodyStates& bodies, double period, ContactSet& set) = 0;
  /// The contacts at a pose of the tool at rest, the other bodies being where the scene puts them.
  void query(const Pose& X_WT, ContactSet& set);

  Input<DeviceState> device;
  Input<PhysicsState> state;
  Input<BodyStates> bodies;
  Output<ContactSet> contacts;

 protected:
  /// Throws InputError where nothing moves.
  explicit CollisionNode(const Scene& scene);

 private:
  std::optional<Time> take_poses();

  std::string names_;  // of the moving bodies
  BodyStates start_;   // where the scene puts them
  BodyStates at_;      // where they last were
  std::optional<Time> last_query_;
  ContactSet set_;
};

/// `2 bodies move: tool, block`; empty where one does or none.
std::string several_move(const Scene& scene);

/// Adds the ports and the margin to the declaration of collision node N.
template <class N>
void declare_collision(Declare<N>& declaration) {
  // The template arguments let pointers to the members of base classes convert.
  declaration.template input<DeviceState>("device", &N::device, {.doc = "says when to query", .trigger = Trigger::yes})
      .template input<PhysicsState>(
          "state", &N::state,
          {.doc = "the last tool pose; before the first the tool is where the scene puts it", .required = false})
      .template input<BodyStates>(
          "bodies", &N::bodies,
          {.doc = "the last poses of all moving bodies, instead of `state`; required where several move",
           .required = false})
      .needed_when(several_move)
      .template output<ContactSet>("contacts", &N::contacts,
                                   "the contacts at that pose, stamped with the start of the query")
      .template real<double>("margin", &N::Params::margin,
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
