// YAML texts. What is no tree says why, and a tree keeps the bounds that are stated for it.
#include <cstddef>
#include <cstdint>
#include <string>

#include "framework/yaml/yaml_tree.hpp"
#include "require.hpp"

namespace {

using namespace tactor;

void visit(const Tree& tree, std::size_t depth, std::size_t& values) {
  fuzz::require(depth <= max_yaml_depth + 1, "the tree is no deeper than stated");
  fuzz::require(++values <= max_yaml_values + 1, "the tree holds no more values than stated");
  for (const Tree& item : tree.items) visit(item, depth + 1, values);
  for (const TreeEntry& entry : tree.entries) {
    fuzz::require(tree.find(entry.key) == &entry, "keys are unique");
    visit(entry.value, depth + 1, values);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Diagnostics diagnostics;
  const auto tree = parse_yaml(std::string(reinterpret_cast<const char*>(data), size), "input.yaml", diagnostics);
  fuzz::require(tree || diagnostics.any(), "a refusal says why");
  std::size_t values = 0;
  if (tree) visit(*tree, 0, values);
  return 0;
}
