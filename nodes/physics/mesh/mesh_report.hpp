// What was found while a mesh was made ready for contact.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tactor {

/// Each a phrase without the name of the file: `2 duplicated faces were removed`.
struct MeshReport {
  std::vector<std::string> repairs;   ///< where the mesh differs from its file
  std::vector<std::string> warnings;  ///< what is allowed, but seldom meant
  bool repairable = false;            ///< it was refused for a fault that `tactor mesh repair` is made for
  bool operator==(const MeshReport&) const = default;
};

/// `1 face`, `2 faces`, `2 vertices`.
inline std::string counted(std::size_t n, const std::string& thing) {
  const std::string things = thing.ends_with("ex") ? thing.substr(0, thing.size() - 2) + "ices" : thing + "s";
  return std::to_string(n) + " " + (n == 1 ? thing : things);
}

/// `was` or `were`.
inline std::string were(std::size_t n) {
  return n == 1 ? " was " : " were ";
}

}  // namespace tactor
