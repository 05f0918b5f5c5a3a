// What a graph says of a deformable body, read from its tree.
#pragma once

#include <string>
#include <vector>

#include "framework/core/scene.hpp"
#include "framework/yaml/yaml_tree.hpp"

namespace tactor {

/// The keys of a body that only a deformable one has.
const std::vector<std::string>& deformable_keys();

/// Those keys of the body's tree; defaults where they are not given. `path`: that of the body.
Deformable read_deformable(const Tree& body, const std::string& path, Diagnostics& diagnostics);

}  // namespace tactor
