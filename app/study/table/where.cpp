#include "app/study/table/where.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <set>

#include "app/report/html_page.hpp"
#include "app/report/provenance_html.hpp"

namespace tactor {

namespace {

/// `n1, n2, n3, ... (12 in all)`
std::string some_of(const std::set<std::string>& names) {
  constexpr std::size_t most_named = 8;
  std::string text;
  std::size_t named = 0;
  for (const std::string& name : names) {
    if (named == most_named) return text + fmt::format(", ... ({} in all)", names.size());
    text += (named++ == 0 ? "" : ", ") + name;
  }
  return text;
}

}  // namespace

std::string core_time(double seconds) {
  return seconds < 600 ? fmt::format("{:.3g} core seconds", seconds) : fmt::format("{:.3g} core hours", seconds / 3600);
}

std::vector<std::string> where_runs_were_made(const std::vector<RunRecord>& records) {
  struct Machines {
    std::set<std::string> nodes;
    std::size_t runs = 0;
    double cpu_s = 0;
  };
  std::map<std::string, Machines> kinds;  // by processor and C library
  for (const RunRecord& record : records) {
    if (record.ran_on.node.empty()) continue;
    Machines& kind = kinds[record.ran_on.processor + ", " + record.ran_on.c_library];
    kind.nodes.insert(record.ran_on.node);
    ++kind.runs;
    for (const double cpu_s : record.cpu_s) kind.cpu_s += std::isfinite(cpu_s) ? cpu_s : 0;
  }
  std::vector<std::string> sentences;
  for (const auto& [kind, machines] : kinds) {
    sentences.push_back(fmt::format("{} run{} on {} ({}): {}.", machines.runs, machines.runs == 1 ? "" : "s",
                                    some_of(machines.nodes), kind, core_time(machines.cpu_s)));
  }
  if (kinds.size() > 1) {
    sentences.emplace_back("Run times of different processors are not compared with each other: a row may have both.");
  }
  return sentences;
}

std::string where_html(const Comparison& comparison) {
  if (comparison.where.empty()) return provenance_html(comparison.provenance);
  std::string html = "<h2>Where it ran</h2>\n<p class=\"sub\">";
  for (const std::string& sentence : comparison.where) html += escape(sentence) + "<br>\n";
  return html + "</p>\n" + provenance_html(comparison.provenance);
}

}  // namespace tactor
