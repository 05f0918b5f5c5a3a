// How contacts as declared become those that physics was felt to have.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "framework/core/describe.hpp"
#include "framework/core/messages.hpp"

namespace tactor {

/// What sets apart the contacts of two bodies from those of two others.
struct ContactMaterial {
  double stiffness = 0;  ///< N/m
  double damping = 0;    ///< N s/m
  double friction = 0;   ///< Coulomb coefficient
  bool operator==(const ContactMaterial&) const = default;
};

/// The estimate of ContactFit, for contacts that are found later.
struct ContactCorrection {
  static constexpr int most_materials = 8;
  double scale_all = 1;           ///< multiplies stiffness and damping of every contact
  double friction_scale_all = 1;  ///< multiplies the friction of every contact, before what follows
  double stiffness_scale = 1;     ///< multiplies stiffness and damping of the tool's contacts of these materials
  double friction_excess = 0;     ///< is added to their Coulomb coefficient; what comes out is 0 at least
  std::int32_t count = 0;         ///< materials
  std::array<ContactMaterial, most_materials> material{};

  /// Changes a contact as far as no estimate counts.
  void apply_scales(Contact& c) const {
    c.stiffness *= scale_all;
    c.damping *= scale_all;
    c.friction *= friction_scale_all;
  }
  /// Changes a contact of that pair.
  void apply(Contact& c, const ContactPair& pair) const {
    apply_scales(c);
    const bool of_tool = pair.body == 0 || pair.other == 0;
    const auto end = material.begin() + count;
    if (!of_tool || std::find(material.begin(), end, ContactMaterial{c.stiffness, c.damping, c.friction}) == end)
      return;
    c.stiffness *= stiffness_scale;
    c.damping *= stiffness_scale;
    c.friction = std::max(0.0, c.friction + friction_excess);
  }
};

template <>
inline const MessageType& message_type<ContactMaterial>() {
  static const MessageType type = Describe<ContactMaterial>("ContactMaterial")
                                      .field("stiffness", "N/m", &ContactMaterial::stiffness)
                                      .field("damping", "N s/m", &ContactMaterial::damping)
                                      .field("friction", "1", &ContactMaterial::friction)
                                      .type();
  return type;
}

template <>
inline const MessageType& message_type<ContactCorrection>() {
  static const MessageType type = Describe<ContactCorrection>("ContactCorrection")
                                      .field("scale_all", "1", &ContactCorrection::scale_all)
                                      .field("friction_scale_all", "1", &ContactCorrection::friction_scale_all)
                                      .field("stiffness_scale", "1", &ContactCorrection::stiffness_scale)
                                      .field("friction_excess", "1", &ContactCorrection::friction_excess)
                                      .field("count", "1", &ContactCorrection::count)
                                      .field("material", &ContactCorrection::material)
                                      .type();
  return type;
}

}  // namespace tactor
