// A contact of a rigid body with a deforming surface.
#pragma once

#include <array>
#include <cstdint>

#include "framework/core/messages.hpp"

namespace tactor {

/// A contact of a rigid body, T of `contact`, with a point of a face of a deforming surface:
///   p_WC = sum_k share[k] p_W(node[k]).
/// n_W points from the surface to the rigid body; H_W is zero.
struct SoftContact {
  Contact contact;
  std::int32_t body = ContactPair::fixed;  ///< of the rigid body in Scene::moving(), or ContactPair::fixed
  std::array<std::int32_t, 3> node{};      ///< of the face
  std::array<double, 3> share{};           ///< of the nodes in the point, sum 1
};

}  // namespace tactor
