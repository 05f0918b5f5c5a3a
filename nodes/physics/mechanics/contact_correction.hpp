// The correction of declared contacts to those that the results of physics show.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "framework/core/describe.hpp"
#include "framework/core/messages.hpp"

namespace tactor {

/// The material of a contact, by which a correction finds it.
struct ContactMaterial {
  double stiffness = 0;  ///< N/m
  double damping = 0;    ///< N s/m
  double friction = 0;   ///< Coulomb coefficient
  bool operator==(const ContactMaterial&) const = default;
};

/// The estimate of ContactFit, for contacts that are found later.
struct ContactCorrection {
  static constexpr int most_materials = 8;
  double scale_all = 1;
  double friction_scale_all = 1;
  double stiffness_scale = 1;
  double friction_excess = 0;
  std::int32_t count = 0;
  std::array<ContactMaterial, most_materials> material{};

  /// Changes a contact as far as no estimate counts.
  void apply_scales(Contact& c) const {
    c.stiffness *= scale_all;
    c.damping *= scale_all;
    c.inertia *= scale_all;
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
    c.inertia *= stiffness_scale;
    c.friction = std::max(0.0, c.friction + friction_excess);
  }
};

template <>
inline const MessageType& message_type<ContactMaterial>() {
  static const MessageType type =
      Describe<ContactMaterial>("ContactMaterial", "", "The combined material of two bodies in contact.")
          .field("stiffness", "N/m", &ContactMaterial::stiffness, "Stiffness at weight 1, as Contact has it.")
          .field("damping", "N s/m", &ContactMaterial::damping, "Damping at weight 1, as Contact has it.")
          .field("friction", "1", &ContactMaterial::friction, "Coulomb coefficient of the two materials.")
          .type();
  return type;
}

template <>
inline const MessageType& message_type<ContactCorrection>() {
  static const MessageType type =
      Describe<ContactCorrection>("ContactCorrection", "",
                                  "Correction of the contacts of a local model, and of those that are found later.")
          .field("scale_all", "1", &ContactCorrection::scale_all, "Factor on stiffness and damping of every contact.")
          .field("friction_scale_all", "1", &ContactCorrection::friction_scale_all,
                 "Factor on the Coulomb coefficient of every contact. It is applied before `friction_excess`.")
          .field("stiffness_scale", "1", &ContactCorrection::stiffness_scale,
                 "Further factor on stiffness and damping of the tool's contacts of the listed materials.")
          .field("friction_excess", "1", &ContactCorrection::friction_excess,
                 "Added to the Coulomb coefficient of the same contacts; the result is at least 0.")
          .field("count", "1", &ContactCorrection::count, "Entries of `material` in use.")
          .field("material", &ContactCorrection::material, "Materials of the contacts that were compared with physics.")
          .type();
  return type;
}

}  // namespace tactor
