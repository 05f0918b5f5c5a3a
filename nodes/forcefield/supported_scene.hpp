// The scenes that have a field of forces.
#pragma once

#include <string_view>

#include "framework/core/scene.hpp"

namespace tactor {

/// The force is a function of the handle's position alone where the tool keeps its orientation and nothing else moves.
/// Throws InputError, naming `type`, the body in the way and what to do, where a body besides the tool moves, the tool
/// rotates, or there is nothing to hit.
void check_static_scene(std::string_view type, const Scene& scene);

}  // namespace tactor
