// Cluster files. Every refusal is a GraphError with a reason, and what is read makes commands.
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>

#include "app/study/cluster/cluster_system.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/yaml/diagnostics.hpp"
#include "require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactor;
  static const TemporaryFolder folder;
  const auto file = folder.path() / "cluster.yaml";
  std::ofstream(file, std::ios::binary) << std::string(reinterpret_cast<const char*>(data), size);
  try {
    const ClusterSystem system = load_cluster_system(file);
    TemplateValues values;
    values.texts = {{"script", "/a script"}, {"name", "{name}"}};
    values.lists = {{"jobs", {"1", "2"}}, {"after", {}}, {"options", {"{jobs}"}}};
    for (const CommandTemplate& command : {system.submit, system.status, system.cancel}) {
      fuzz::require(!command.empty(), "every command has a word");
      // A list may make several words of one.
      fuzz::require(filled_in(command, values, system.joined_by).size() <= 2 * command.size(), "words stay words");
    }
  } catch (const YamlError& error) {
    fuzz::require(!error.diagnostics().empty(), "a refusal says why");
  }
  return 0;
}
