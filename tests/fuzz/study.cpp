// Study files, up to the points of their design. Every refusal is a GraphError with a reason.
#include <cstddef>
#include <cstdint>
#include <string>

#include "app/study/spec/study_spec.hpp"
#include "require.hpp"
#include "tests/framework/graph/test_nodes.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactor;
  static const testing::Folder folder;
  const auto file = folder.write("study.yaml", std::string(reinterpret_cast<const char*>(data), size));
  for (const bool use_short : {false, true}) {
    try {
      const StudySpec spec = load_study(file, use_short);
      for (const StudyPoint& point : study_points(spec)) {
        fuzz::require(point.values.size() == spec.vary.size(), "a point has a value for every axis");
      }
    } catch (const GraphError& error) {
      fuzz::require(!error.diagnostics().empty(), "a refusal says why");
    }
  }
  return 0;
}
