// What is laid over a graph file: values, files and maps, one after the other.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "framework/yaml/yaml_tree.hpp"

namespace tactor {

/// What errors expect of an assignment.
inline constexpr const char* assignment_form =
    "expected node.parameter=value, node={type: ...} or node={python: FILE.py:Class}, scene.bodies.body.key=value, "
    "duration=... or seed=...";

/// A value at a path: `device.rate`, `scene.bodies.tool.mass`, `duration`.
struct Assignment {
  std::string path;
  std::string value;  ///< as YAML
};

/// One step. A file and a map (without `extends`) are laid over the graph like a file that extends it.
struct Patch {
  SourceLocation place;  ///< where it was given, for errors: in a study, or the option with line 0
  std::variant<Assignment, std::filesystem::path, Tree> change;

  [[nodiscard]] const Assignment* assignment() const { return std::get_if<Assignment>(&change); }
  [[nodiscard]] const std::filesystem::path* file() const { return std::get_if<std::filesystem::path>(&change); }
};

/// What the command line or a study lays over a graph file, in this order: the later wins.
using Overrides = std::vector<Patch>;

/// TEXT being `path=value`. Errors name it `--set TEXT`, or by another word. Throws GraphError where it has no `=`.
Patch set_patch(const std::string& text, const std::string& said_by = "--set");
/// An option with a path of its own: `--seed 7`.
Patch option_patch(const std::string& option, const std::string& path, const std::string& value);
/// Errors name it `--over FILE`, or by another word.
Patch over_patch(const std::filesystem::path& file, const std::string& said_by = "--over");

/// The last of the patches that gives the path a value, or null.
const Patch* find_assignment(const Overrides& overrides, std::string_view path);

}  // namespace tactor
