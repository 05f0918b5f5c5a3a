#include "app/run/summary.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "framework/core/stability.hpp"
#include "framework/graph/text_table.hpp"

namespace tactor {

using Json = nlohmann::ordered_json;

namespace {

Json number(double value) {
  // Counts read better without a fraction.
  if (value == std::floor(value) && std::abs(value) < 1e15) return static_cast<std::int64_t>(value);
  return number_json(value);
}

void set_nested(Json& root, const std::string& dotted, Json value) {
  Json* at = &root;
  std::size_t begin = 0;
  for (std::size_t dot = dotted.find('.'); dot != std::string::npos; dot = dotted.find('.', begin)) {
    at = &(*at)[dotted.substr(begin, dot - begin)];
    begin = dot + 1;
  }
  (*at)[dotted.substr(begin)] = std::move(value);
}

}  // namespace

std::string pretty(double value) {
  if (!std::isfinite(value)) return "-";
  if (value == 0) return "0";
  const double size = std::abs(value);
  if (size >= 1e6 || size < 1e-4) return fmt::format("{:.2e}", value);
  if (value == std::floor(value) && size < 1e5) return fmt::format("{:.0f}", value);
  const int digits = std::max(0, 2 - static_cast<int>(std::floor(std::log10(size))));
  return fmt::format("{:.{}f}", value, digits);
}

Json number_json(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

Json to_json(const RunResult& result) {
  Json json;
  json["tactor"] = TACTOR_VERSION;
  json["metric_definitions"] = metric_definitions;
  json["graph"] = result.graph;
  json["seed"] = result.seed;
  json["duration_s"] = result.duration_s;
  json["clock"] = result.live ? "real" : "virtual";
  json["planned_s"] = number_json(result.planned_s);
  json["interrupted"] = result.interrupted;
  json["reference_interrupted"] = result.reference_interrupted;
  if (result.failure) json["failure"] = *result.failure;
  if (!result.remarks.empty()) json["remarks"] = result.remarks;
  json["wall_s"] = result.wall_s;
  json["cpu_s"] = result.cpu_s;
  json["realtime_factor"] = number(result.duration_s / result.wall_s);
  json["peak_memory_MB"] = result.peak_memory_MB;
  json["warm"] = {{"all", result.warmth.since.has_value()}, {"last", result.warmth.last}, {"when", result.warmth.when}};
  for (const auto& [name, value] : result.metrics) set_nested(json, name, number(value));
  if (const double verdict = result.metric("stability.verdict"); std::isfinite(verdict)) {
    json["stability"]["verdict_name"] =
        result.force_was_withheld() ? "no_force" : name_of(static_cast<StabilityVerdict>(static_cast<int>(verdict)));
  }
  for (const NoForce& one : result.no_force) {
    json["no_force"].push_back({{"device", one.device},
                                {"reason", name_of(one.reason)},
                                {"count", one.count},
                                {"of", one.of},
                                {"text", one.text}});
  }
  json["cost_us"] = Json::object();
  for (const NodeCost& node : result.nodes) {
    json["cost_us"][node.node] = {{"type", node.type},
                                  {"steps", node.steps},
                                  {"missed_ticks", node.missed_ticks},
                                  {"median", number(node.median_us)},
                                  {"p99", number(node.p99_us)},
                                  {"total_s", node.total_s}};
  }
  json["edges"] = Json::object();
  for (std::size_t i = 0; i < result.edges.size(); ++i) {
    const EdgeResult& edge = result.edges[i];
    json["edges"][edge.edge] = {{"queue", edge.queue},
                                {"delivered", edge.metrics.delivered},
                                {"drops", edge.metrics.dropped},
                                {"superseded", edge.metrics.superseded}};
    if (!result.live || result.live->edges[i].age.count == 0) continue;
    const LatencyStatistics& age = result.live->edges[i].age;
    json["edges"][edge.edge]["age_us"] = {
        {"p50", age.p50.microseconds()}, {"p99", age.p99.microseconds()}, {"max", age.max.microseconds()}};
  }
  if (result.live && !result.live->missing.empty()) json["missing_privileges"] = result.live->missing;
  if (!result.reference.too_coarse.empty()) json["reference_too_coarse"] = result.reference.too_coarse;
  if (result.reference.made) {
    json["reference_run"] = {{"cached", result.reference.cached},
                             {"cpu_s", result.reference.cpu_s},
                             {"rate_hz", number_json(result.reference.rate_hz)}};
  }
  json["chosen"] = Json::array();
  for (const Chosen& c : result.chosen) {
    json["chosen"].push_back({{"node", c.node}, {"asked", c.asked}, {"type", c.type}, {"why", c.why}});
  }
  json["left_out"] = Json::array();
  for (const LeftOut& item : result.left_out) json["left_out"].push_back({{"what", item.what}, {"why", item.why}});
  if (!result.provenance.empty()) json["provenance"] = to_json(result.provenance);
  return json;
}

std::string dynamics_warning(const RunResult& result) {
  const double damped = result.metric("dynamics_damped_steps"), stopped = result.metric("dynamics_stopped_steps");
  // Without dynamics the metrics are NaN.
  if (!(damped + stopped > 0)) return {};
  return fmt::format("dynamics: of {:.0f} steps, {:.0f} fell back to a damped step and {:.0f} stopped the bodies",
                     result.metric("dynamics_steps"), damped, stopped);
}

std::string summary_table(const RunResult& result, std::size_t columns) {
  using enum TextTable::Align;
  std::string out = "\n";
  for (const std::string& text : result.remarks) out += fmt::format("  {}\n", text);
  if (!result.remarks.empty()) out += "\n";
  TextTable metrics({{"metric"}, {"", right}, {"unit"}, {"better"}});
  for (const auto& [name, value] : result.metrics) {
    const MetricInfo* info = result.info(name);
    metrics.add({name, pretty(value), info == nullptr ? "" : unit_text(info->unit),
                 info == nullptr ? "" : better_text(info->better)});
  }
  out += metrics.text(columns) + "\n";
  TextTable nodes({{"node"}, {"type"}, {"steps", right}, {"median us", right}, {"p99 us", right}, {"CPU s", right}});
  for (const NodeCost& node : result.nodes) {
    nodes.add({node.node, node.type, std::to_string(node.steps), pretty(node.median_us), pretty(node.p99_us),
               pretty(node.total_s)});
  }
  out += nodes.text(columns);
  if (!result.chosen.empty()) {
    out += "\n  chosen:\n";
    for (const Chosen& c : result.chosen) out += fmt::format("    {}: {} is {}: {}\n", c.node, c.asked, c.type, c.why);
  }
  if (!result.left_out.empty()) {
    out += "\n  left out:\n";
    for (const LeftOut& item : result.left_out) out += fmt::format("    {}: {}\n", item.what, item.why);
  }
  return wrapped(out, columns);
}

}  // namespace tactor
