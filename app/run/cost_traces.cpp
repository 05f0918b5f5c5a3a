#include "app/run/cost_traces.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <fstream>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "app/output.hpp"
#include "app/run/ran_on.hpp"
#include "framework/core/check.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

std::string trace_text(const RunResult& result, const NodeCost& node) {
  std::string text = fmt::format(
      "# What each step of {} ({}) took, in s: {}.\n# Graph {}, seed {}; {:%F}, Tactor {}.\n# {}, {} cores.\n",
      node.node, node.type, result.live ? "the time until its results were visible" : "CPU time of its thread",
      result.graph, result.seed, fmt::gmtime(std::time(nullptr)), TACTOR_VERSION, this_machine().processor,
      std::thread::hardware_concurrency());
  for (const Duration time : node.step_times) text += fmt::format("{:.9f}\n", time.seconds());
  return text;
}

}  // namespace

CostTraces::CostTraces(fs::path folder, const Plan& plan) : folder_(std::move(folder)) {
  if (plan.graph.clock == Clock::real && plan.graph.live.impose_cost) {
    throw InputError(
        "--record-costs: expected a graph that imposes no costs, found live.impose_cost: true; add --set "
        "live.impose_cost=false");
  }
  const std::string place = fmt::format("--record-costs {}: ", folder_.string());
  std::error_code error;
  if (is_taken(folder_)) {
    throw InputError(place + "expected a folder that does not exist yet, found one of that name; choose another name");
  }
  fs::create_directories(folder_, error);
  if (error) throw InputError(place + "cannot make this folder: " + error.message());
}

CostTraces::~CostTraces() {
  std::error_code ignored;
  fs::remove(folder_, ignored);
}

void CostTraces::write(const RunResult& result) const {
  if (result.live && result.record_dropped > 0) {
    throw RunError(
        fmt::format("--record-costs {}: {} messages of the run were lost, so the times have gaps; record "
                    "less, or run on a machine with less load",
                    folder_.string(), result.record_dropped));
  }
  for (const NodeCost& node : result.nodes) {
    if (!node.step_times.empty()) write_file(folder_ / (node.node + ".csv"), trace_text(result, node));
  }
}

}  // namespace tactor
