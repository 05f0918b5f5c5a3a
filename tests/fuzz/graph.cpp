// Graph files, up to the plan and its explanation. Every refusal is a GraphError with a reason.
#include <cstddef>
#include <cstdint>
#include <string>

#include "framework/graph/plan.hpp"
#include "require.hpp"
#include "tests/framework/graph/test_nodes.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactor;
  static const testing::Folder folder;
  try {
    const Plan plan = make_plan(testing::load_text(folder, std::string(reinterpret_cast<const char*>(data), size)));
    static_cast<void>(make_reference_plan(plan));
    static_cast<void>(explain(plan));
  } catch (const GraphError& error) {
    fuzz::require(!error.diagnostics().empty(), "a refusal says why");
  }
  return 0;
}
