// The option `--unit` of verbs that read a mesh.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/mesh/mesh_units.hpp"

namespace tactor {

/// Adds `--unit`; `scale` becomes what one unit of the file is in m.
inline CLI::Option* add_mesh_unit(CLI::App& verb, std::optional<double>& scale) {
  std::vector<std::string> names;
  for (const auto& [name, metres] : mesh_units()) names.push_back(name);
  const auto take = [&scale](const std::string& word) {
    for (const auto& [name, metres] : mesh_units()) {
      if (name == word) scale = metres;
    }
  };
  return verb
      .add_option_function<std::string>("--unit", take,
                                        "The unit of the file (default: m, or mm where only that makes 20 mm to 0.5 m)")
      ->check(CLI::IsMember(names))
      ->type_name("UNIT");
}

}  // namespace tactor
