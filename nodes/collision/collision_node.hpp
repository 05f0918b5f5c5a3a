// What every collision node does and declares; what differs is its query.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "nodes/physics/contact/local_contacts.hpp"
#include "nodes/physics/contact/materials.hpp"
#include "nodes/physics/mesh/body_mesh.hpp"

namespace tactor {

/// Queries where the moving bodies last were (before the first message where the scene puts them) each time the device
/// triggers it, sends the contacts stamped with the start of the query, and counts those that penetrate as its work.
/// One moving body is the tool, which `state` tells of; of several `bodies` must tell.
class CollisionNode : public Node {
 public:
  void step(StepContext& context) final;

  /// The contacts where the moving bodies are; velocities do not count.
  virtual void query(const BodyStates& bodies, ContactSet& set) = 0;
  /// The contacts on the way that the bodies take from `age` s ago, where they were at `bodies`, if they keep their
  /// velocities; none by default.
  virtual void query_ahead(const BodyStates& bodies, double age, LocalContacts& around);
  /// The contacts at a pose of the tool, the other bodies being where the scene puts them.
  void query(const Pose& X_WT, ContactSet& set);

  Input<DeviceState> device;
  Input<PhysicsState> state;
  Input<BodyStates> bodies;
  Input<BodyStates> expected;
  Output<ContactSet> contacts;
  Output<LocalContacts> local;

  /// Steps, and those of them whose contacts penetrate.
  [[nodiscard]] std::uint64_t queries() const { return queries_; }
  [[nodiscard]] std::uint64_t touching_queries() const { return touching_queries_; }

 protected:
  /// Throws InputError where nothing moves.
  explicit CollisionNode(const Scene& scene);

 private:
  void take_poses(Time now);

  std::string names_;  // of the moving bodies
  BodyStates start_;   // where the scene puts them
  BodyStates at_;      // where they last were
  double age_ = 0;     // s, of that
  ContactSet set_;
  LocalContacts local_;
  std::uint64_t queries_ = 0, touching_queries_ = 0;
};

/// Throws InputError where nothing moves.
void require_moving_body(const Scene& scene);

/// `2 bodies move: tool, block`; empty where one does or none.
std::string several_move(const Scene& scene);

/// Adds the ports and the margin to the declaration of collision node N.
template <class N>
void declare_collision(Declare<N>& declaration) {
  // The template arguments let pointers to the members of base classes convert.
  declaration
      .template input<DeviceState>("device", &N::device,
                                   {.doc = "each message starts a query", .trigger = Trigger::yes})
      .template input<PhysicsState>(
          "state", &N::state,
          {.doc = "the last tool pose; until one arrives, the tool is where the scene puts it", .required = false})
      .template input<BodyStates>(
          "bodies", &N::bodies,
          {.doc = "the last poses of all moving bodies, instead of `state`; required if several bodies move",
           .required = false})
      .needed_when(several_move)
      .template input<BodyStates>(
          "expected", &N::expected,
          {.doc = "where the moving bodies are expected to be by now; the query then uses these poses instead",
           .required = false,
           .in_reference = false})
      .template output<LocalContacts>("local", &N::local,
                                      "the contacts at that pose and along the expected motion, for prediction.local. "
                                      "They are computed only if something reads them")
      .template output<ContactSet>("contacts", &N::contacts,
                                   "the contacts at the pose of the query, stamped with the start of the query")
      .template real<double>("margin", &N::Params::margin,
                             {.doc = "surfaces closer than this are reported as contacts before they touch",
                              .unit = "m",
                              .default_value = 0.002,
                              .min = 0,
                              .max = 0.1})
      .role(Role::collision)
      .scene_law()
      .on_thread("physics")
      .unneeded(nothing_to_hit);
}

}  // namespace tactor
