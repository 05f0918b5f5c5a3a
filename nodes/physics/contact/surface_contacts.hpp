// The contacts of a scene as a rollout asks for them, and the parameters of nodes that do.
#pragma once

#include <memory>
#include <string>

#include "framework/node/declare.hpp"
#include "nodes/physics/contact/contact_source.hpp"
#include "nodes/physics/contact/scene_contacts.hpp"
#include "nodes/physics/geometry/mesh_distance.hpp"

namespace tactor {

/// Whether a rollout finds its contacts anew at each step, and how.
struct SurfaceOptions : ContactOptions, CellOptions {
  enum class From { surface, anchors };
  From contacts = From::surface;
  std::int32_t most_work = 0;  ///< steps of work of a query (see SampleTree::find)
};

/// The surfaces of the scene; null where the options say anchors.
std::unique_ptr<ContactSource> surface_contacts(const SurfaceOptions& options, const NodeContext& context);

/// Adds the parameters of the query; they are as in the collision node unless a graph gives them. `otherwise`: what
/// happens where a query needs more than `most_work`.
template <class N>
void declare_query(Declare<N>& node, int most_work, const std::string& otherwise) {
  using P = typename N::Params;
  node.template real<double>("margin", &P::margin,
                             {.doc = "surfaces closer than this are found as contacts before they touch",
                              .unit = "m",
                              .default_value = 0.002,
                              .min = 0,
                              .max = 0.1,
                              .as_in = Role::collision})
      .template real<double>("spacing", &P::spacing,
                             {.doc = "how far contact samples may be apart",
                              .unit = "m",
                              .default_value = 0,
                              .min = 0,
                              .max = 1,
                              .as_in = Role::collision})
      .template integer<std::int32_t>(
          "max_contacts", &P::max_contacts,
          {.doc = "most contacts in a step. If there are more, a spread-out subset stands for all of them",
           .default_value = 64,
           .min = 8,
           .max = ContactSet::capacity})
      .template integer<std::int32_t>("resolution", &P::resolution,
                                      {.doc = "cells along the longest side of a mesh",
                                       .default_value = CellOptions{}.resolution,
                                       .min = 8,
                                       .max = 1024,
                                       .as_in = Role::collision})
      .template real<double>("band", &P::band,
                             {.doc = "distance from a mesh's surface within which cells list their nearest faces",
                              .unit = "m",
                              .default_value = CellOptions{}.band,
                              .min = 0,
                              .max = 0.1,
                              .as_in = Role::collision})
      .template integer<std::int32_t>("most_work", &P::most_work,
                                      {.doc = "most looks, at eight samples or at the distance of one sample, that a "
                                              "step may take to find its contacts. If more are needed, " +
                                              otherwise,
                                       .default_value = most_work,
                                       .min = 1,
                                       .max = 1'000'000});
}

/// Adds the choice of the source and the parameters of the query.
template <class N>
void declare_surface(Declare<N>& node, int most_work) {
  using P = typename N::Params;
  node.template choice<SurfaceOptions::From>(
      "contacts", &P::contacts,
      {{"surface", SurfaceOptions::From::surface}, {"anchors", SurfaceOptions::From::anchors}},
      SurfaceOptions::From::surface,
      "surface: each step finds its contacts anew on the surfaces themselves; anchors: it uses the contacts that came "
      "with the result, as planes that bend");
  declare_query(node, most_work, "the contacts that came with the result are used");
  node.unread_when({"margin", "spacing", "max_contacts", "resolution", "band", "most_work"},
                   [](const P& p, const ParamUse&) {
                     return std::string(p.contacts == SurfaceOptions::From::surface ? "" : "contacts is anchors");
                   });
}

}  // namespace tactor
