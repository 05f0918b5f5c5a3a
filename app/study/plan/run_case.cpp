#include "app/study/plan/run_case.hpp"

#include <fmt/format.h>

namespace tactor {

std::string case_name(const std::string& graph, const std::string& setting) {
  return graph + (setting.empty() ? "" : " ") + setting;
}

std::string run_name(const std::string& graph, const std::string& setting, std::uint64_t seed) {
  return fmt::format("{}, seed {}", case_name(graph, setting), seed);
}

}  // namespace tactor
