// What the nodes exact, sdf and primitive share: the contacts of a scene, with their parameters.
#pragma once

#include "nodes/collision/collision_node.hpp"
#include "nodes/physics/contact/local_contacts.hpp"
#include "nodes/physics/contact/scene_contacts.hpp"

namespace tactor {

/// Sends what SceneContacts finds.
class PairCollision : public CollisionNode {
 public:
  using CollisionNode::query;
  void query(const BodyStates& at, ContactSet& set) final { contacts_.find(at, set); }
  void query_ahead(const BodyStates& at, double age, LocalContacts& around) final {
    contacts_.find_ahead(at, age, around);
  }

 protected:
  PairCollision(const ContactOptions& options, const NodeContext& context, const MakeMeshDistance& make_distance);

  /// How many queries there were, and how many met penetrating contacts; that none did is said in words.
  void report(Report& report) const override;

 private:
  SceneContacts contacts_;
};

/// Adds what all these nodes have to the declaration of N.
template <class N>
void declare_pairs(Declare<N>& declaration) {
  declare_collision(declaration);
  declaration.template real<double>(
      "spacing", &N::Params::spacing,
      {.doc = "how far apart contact samples may be; 0 lets the shape decide. On a mesh, every surface point has a "
              "sample on its own side within this distance, so at most this much depth is missed, and far less where "
              "faces lie on each other. With 0, a mesh uses all vertices, and points between them on edges longer than "
              "an eighth of the mesh's longest side. On a box or a capsule, this is the largest distance between "
              "neighbouring samples. With 0, a box takes an eighth of its longest edge, and a capsule 0.28 of its "
              "radius. Where both bodies have samples, those of the finer one count",
       .unit = "m",
       .default_value = 0,
       .min = 0,
       .max = 1});
  declaration.template integer<std::int32_t>("max_contacts", &N::Params::max_contacts,
                                             {.doc = "most contacts that are sent. If there are more, a spread-out "
                                                     "subset is sent. It is weighted to give the same force and torque",
                                              .default_value = ContactSet::capacity,
                                              .min = 8,
                                              .max = ContactSet::capacity});
  declaration.template integer<std::int32_t>(
      "local_contacts", &N::Params::local_contacts,
      {.doc = "most contacts that are sent on the output `local`, chosen in the same way",
       .default_value = 24,
       .min = 4,
       .max = LocalContacts::capacity,
       .in_reference = 24});  // nothing reads `local` there: one reference run serves all values
  declaration.template integer<std::int32_t>("anchors", &N::Params::anchors,
                                             {.doc = "number of poses at which contacts for `local` are found: the "
                                                     "present pose, and those that the velocities lead to",
                                              .default_value = 3,
                                              .min = 1,
                                              .max = LocalContacts::max_anchors,
                                              .in_reference = 3});
  declaration.template real<double>("anchor_time", &N::Params::anchor_time,
                                    {.doc = "time between these poses. Choose about the physics period in contact: a "
                                            "result is in use from one to two periods after its query",
                                     .unit = "s",
                                     .default_value = 0.015,
                                     .min = 0,
                                     .max = 0.1});
  using P = typename N::Params;
  declaration
      .unread_when({"local_contacts", "anchors", "anchor_time"},
                   [](const P&, const ParamUse& use) {
                     return std::string(use.is_read("local") ? "" : "nothing reads the output local");
                   })
      .unread_when({"spacing"}, [](const P&, const ParamUse& use) {
        return std::string(has_spaced_samples(*use.scene) ? "" : "no body has contact samples that are spaced apart");
      });
  declaration.coarser("margin", {1e-3, 5e-4, 2e-4})
      .coarser("spacing", {5e-4, 1e-3, 2e-3, 4e-3, 8e-3})
      .coarser("max_contacts", {std::int64_t{64}, std::int64_t{32}, std::int64_t{16}, std::int64_t{8}})
      .coarser("local_contacts", {std::int64_t{12}, std::int64_t{8}, std::int64_t{4}})
      .coarser("anchors", {std::int64_t{2}, std::int64_t{1}});
  declaration
      .metric("collision.queries", "1", "contact queries", Better::neither,
              [](const N& self) { return self.queries(); })
      .metric("collision.touching_queries", "1", "contact queries that found a penetrating contact", Better::neither,
              [](const N& self) { return self.touching_queries(); });
}

}  // namespace tactor
