// Node types and files that the tests of graphs are written with.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "framework/core/temporary_folder.hpp"
#include "framework/graph/spec.hpp"
#include "framework/node/registry.hpp"

namespace tactor::testing {

/// A registry that knows test.device, test.collision, test.dynamics, test.coupling, test.predictor, test.refit,
/// test.hold, test.twist, test.gate, test.motor, test.solver, test.listener, test.values and test.judge, and searches
/// no folder.
Registry test_registry();

class Folder : public TemporaryFolder {
 public:
  /// Writes a file and gives its path.
  [[nodiscard]] std::filesystem::path write(const std::string& name, const std::string& text) const;
};

/// `--set` of each.
Overrides settings(const std::vector<std::string>& texts);

/// The graph of a text; every call writes `graph.yaml` anew.
GraphSpec load_text(const Folder& folder, const std::string& text, const Overrides& overrides = {});

/// What load_text says is wrong, or empty.
std::string errors_of(const Folder& folder, const std::string& text, const Overrides& overrides = {});

/// A whole pipeline: device -> collision -> dynamics -> coupling -> predictor (with refit) -> hold -> device, judge.
/// `scene` is the text of its scene.
std::string pipeline(const std::string& scene);
inline const std::string rigid_scene =
    "  bodies:\n    tool: {sphere: {radius: 4 mm}, motion: rigid, mass: 50 g}\n    wall: {sphere: {radius: 1 m}}\n";
inline const std::string sliding_scene =
    "  bodies:\n    tool: {sphere: {radius: 4 mm}, motion: translation}\n    wall: {sphere: {radius: 1 m}}\n";

}  // namespace tactor::testing
