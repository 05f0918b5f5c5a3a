// How deformable bodies are modelled, stepped and condensed.
#pragma once

#include <cstdint>

#include "nodes/physics/deformable/soft_body.hpp"
#include "nodes/physics/deformable/sparse_factor.hpp"

namespace tactor {

/// What all of physics/deformable is told, and the parameters of dynamics.deformable of the same names.
struct DeformableOptions {
  Elasticity law = Elasticity::corotational;
  ElementOrder elements = ElementOrder::linear;
  FactorKind solver = FactorKind::automatic;
  std::int32_t newton_iterations = 8;  ///< in a step, at most
  double tolerance = 1e-3;             ///< of the forces on the nodes: what may be left of their equation
  bool reuse_factors = true;           ///< of earlier steps, as long as they do
  std::int32_t patch_nodes = 36;       ///< around the tool, at most; no more than LocalPatch::capacity
  std::int32_t patch_far_nodes = 8;    ///< masters far from the tool, at most
  double patch_reach = 0.04;           ///< m, how far from the tool its nodes may be
};

}  // namespace tactor
