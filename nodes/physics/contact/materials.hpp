// The contact law of two materials that meet.
#pragma once

#include <string>

#include "framework/core/scene.hpp"

namespace tactor {

/// Stiffnesses in series, 1 / (1/a + 1/b); damping and patch area of the softer; the geometric mean of the frictions.
/// Units as in Material.
Material combine(const Material& a, const Material& b);

/// Why a scene needs no collision, or empty where it does.
std::string nothing_to_hit(const Scene& scene);

}  // namespace tactor
