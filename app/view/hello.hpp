// What a page is told first: the scene, the graph, its streams and its knobs.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/view/drawn_scene.hpp"
#include "app/view/shown_streams.hpp"
#include "framework/graph/plan.hpp"

namespace tactor {

/// What `hello` says beside what the plan tells.
struct HelloExtras {
  bool replay = false;
  double duration = 0;                        ///< s; 0: until it is stopped
  std::optional<std::size_t> mouse;           ///< the node that a page leads, index into the plan
  Pose start;                                 ///< where the handle is at first
  std::map<std::string, std::string> values;  ///< of parameters that were changed, as text
  std::shared_ptr<const DrawnScene> drawn;    ///< of the plan's graph; null: hello_text asks its nodes
};

/// The text `hello` without `client`. Meshes are counted by `mesh_messages`.
std::string hello_text(const Plan& plan, const std::vector<ShownStream>& streams, const HelloExtras& extras);

/// The value that such a text gives the parameter `node.name`, in SI, as JSON. Throws YamlError where it gives none.
std::string parameter_value_text(const Plan& plan, const std::string& parameter, const std::string& value);

/// The meshes of what is drawn as binary messages, each once, in the order in which `hello` counts them. `note` takes
/// what a user should know of them. Throws InputError where a file holds no solid.
std::vector<std::string> mesh_messages(const DrawnScene& drawn, const std::function<void(const std::string&)>& note);

}  // namespace tactor
