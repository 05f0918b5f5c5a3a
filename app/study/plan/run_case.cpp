#include "app/study/plan/run_case.hpp"

#include <fmt/format.h>

namespace tactor {

std::string case_name(const std::string& graph, const std::string& configuration) {
  return graph + (configuration.empty() ? "" : " ") + configuration;
}

std::string run_name(const std::string& graph, const std::string& configuration, std::uint64_t seed) {
  return fmt::format("{}, seed {}", case_name(graph, configuration), seed);
}

}  // namespace tactor
