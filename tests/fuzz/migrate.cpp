// Rewriting of graphs and studies of an earlier release. What it returns is YAML that it would not rewrite again, and
// what it refuses stays as it was.
#include "framework/graph/migrate.hpp"

#include <cstddef>
#include <cstdint>
#include <string>

#include "framework/yaml/yaml_tree.hpp"
#include "require.hpp"

namespace {

using namespace tactor;

/// A type with former names, and one in which one of them is still in use.
std::vector<NodeInfo> types() {
  std::vector<NodeInfo> all(2);
  all[0].type = "my.filter";
  all[0].params.resize(2);
  all[0].params[0].name = "detrend";
  all[0].params[0].former = "remove";
  all[0].params[1].name = "span";
  all[0].params[1].former = "window";
  all[0].outputs.resize(1);
  all[0].outputs[0].name = "parameters";
  all[0].outputs[0].former = "law";
  all[1].type = "my.other";
  all[1].params.resize(1);
  all[1].params[0].name = "window";
  all[1].inputs.resize(1);
  all[1].inputs[0].name = "coupling";
  all[1].inputs[0].former = "law";
  return all;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::vector<NodeInfo> all = types();
  const std::vector<const NodeInfo*> known{&all[0], &all[1]};
  const std::string text(reinterpret_cast<const char*>(data), size);
  Diagnostics diagnostics;
  const Migrated once = migrate(text, "input.yaml", known, diagnostics);
  if (diagnostics.any()) {
    fuzz::require(once.text == text && once.changes.empty(), "what is refused stays as it was");
    return 0;
  }
  fuzz::require(once.changes.empty() == (once.text == text), "the text changes where a change is told");
  Diagnostics again;
  fuzz::require(parse_yaml(once.text, "input.yaml", again).has_value() && !again.any(), "the result is YAML");
  const Migrated twice = migrate(once.text, "input.yaml", known, again);
  fuzz::require(!again.any() && twice.changes.empty(), "the result is not rewritten again");
  return 0;
}
