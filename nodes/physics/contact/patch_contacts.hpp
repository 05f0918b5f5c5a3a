// The tool's contacts with what deforms around it, as nodes of the local rollout ask for them.
#pragma once

#include <memory>
#include <string>

#include "framework/node/declare.hpp"
#include "nodes/physics/contact/soft_contact_options.hpp"
#include "nodes/physics/contact/soft_contact_source.hpp"

namespace tactor {

/// The tool of the scene against the faces of a patch; null where nothing deforms. Throws as SoftContacts does.
std::unique_ptr<SoftContactSource> patch_contacts(const SoftContactOptions& options, const NodeContext& context);

/// Why a scene needs a patch; empty where nothing deforms.
std::string something_deforms(const Scene& scene);

/// Why a scene has no patch; empty where something deforms.
std::string nothing_deforms(const Scene& scene);

/// Adds SoftContactOptions without `soft_work` to the declaration of N. `shared`: they are as in dynamics unless a
/// graph gives them.
template <class N>
void declare_soft_contacts(Declare<N>& node, std::int32_t most_contacts, bool shared) {
  using P = typename N::Params;
  const std::optional<Role> as_in = shared ? std::optional(Role::dynamics) : std::nullopt;
  node.template real<double>(
          "soft_margin", &P::soft_margin,
          {.doc = "bodies closer than this to a deforming surface are found as contacts before they touch",
           .unit = "m",
           .default_value = 0.002,
           .min = 0,
           .max = 0.1,
           .as_in = as_in})
      .template real<double>("soft_spacing", &P::soft_spacing,
                             {.doc = "how far apart samples of a deforming surface may be; 0: a third of a ball's or "
                                     "capsule's radius, a sixteenth of the longest side of a box or mesh",
                              .unit = "m",
                              .default_value = 0,
                              .min = 0,
                              .max = 1,
                              .as_in = as_in})
      .template integer<std::int32_t>("soft_contacts", &P::soft_contacts,
                                      {.doc = "most contacts with deforming surfaces. If there are more, a spread-out "
                                              "subset is used. It is weighted to give the same force and torque",
                                       .default_value = most_contacts,
                                       .min = 8,
                                       .max = ContactSet::capacity});
  node.unread_when({"soft_margin", "soft_spacing", "soft_contacts"}, [](const P&, const ParamUse& use) {
    return std::string(use.scene->deformable().empty() ? "nothing deforms" : "");
  });
}

/// Adds SoftContactOptions.
template <class N>
void declare_patch_contacts(Declare<N>& node) {
  using P = typename N::Params;
  declare_soft_contacts(node, 48, true);
  node.template integer<std::int32_t>(
          "soft_work", &P::soft_work,
          {.doc = "most looks at a face, a row of samples or a sample that a step may take to find its contacts with a "
                  "deforming surface. A step that needs more fails",
           .default_value = 6000,
           .min = 1,
           .max = 1'000'000})
      .unread_when({"soft_work"}, [](const P&, const ParamUse& use) {
        return std::string(use.scene->deformable().empty() ? "nothing deforms" : "");
      });
}

}  // namespace tactor
