#include "app/study/table/warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>

#include "app/report/html_page.hpp"
#include "app/run/headline.hpp"
#include "app/study/plan/run_case.hpp"

namespace tactor {

namespace {

const Body* find(const Scene& scene, const std::string& name) {
  const auto found =
      std::find_if(scene.bodies.begin(), scene.bodies.end(), [&](const Body& body) { return body.name == name; });
  return found == scene.bodies.end() ? nullptr : &*found;
}

/// In which parameters the nodes that couple handle and tool differ: `k_0 and m_0`, `type`; empty for none.
std::string difference_of_coupling(const GraphSpec& graph, const GraphSpec& other) {
  const auto coupling = [](const GraphSpec& of) {
    const auto found = std::find_if(of.nodes.begin(), of.nodes.end(),
                                    [](const NodeSpec& node) { return node.info->role == Role::coupling; });
    return found == of.nodes.end() ? nullptr : &*found;
  };
  const NodeSpec *mine = coupling(graph), *theirs = coupling(other);
  if (mine == nullptr || theirs == nullptr) return mine == theirs ? "" : "type";
  if (mine->info != theirs->info) return "type";
  std::vector<std::string> names;
  for (std::size_t i = 0; i < mine->params.size(); ++i) {
    if (mine->params[i] != theirs->params[i]) names.push_back(mine->info->params[i].name);
  }
  return fmt::format("{}", fmt::join(names, " and "));
}

/// The first few.
std::string first_names(std::vector<std::string> names) {
  constexpr std::size_t most_named = 5;
  if (names.size() > most_named) {
    names.resize(most_named);
    names.emplace_back("...");
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

/// The rows whose truth is no finer than their runs, one line for each reason.
std::vector<std::string> coarse_warnings(const Comparison& comparison) {
  std::map<std::string, std::vector<std::string>> rows;
  for (const CompareRow& row : comparison.rows) {
    if (!row.too_coarse.empty()) rows[row.too_coarse].push_back(case_name(row.graph, row.configuration));
  }
  std::vector<std::string> warnings;
  for (const auto& [why, names] : rows) {
    const bool all = names.size() == comparison.rows.size();
    warnings.push_back((all ? std::string("nothing is ranked")
                            : fmt::format("{} of {} rows are not ranked ({})", names.size(), comparison.rows.size(),
                                          first_names(names))) +
                       ": " + why);
  }
  return warnings;
}

/// The rows of which a run let no force reach any device, each with the first reason.
std::vector<std::string> no_force_warnings(const Comparison& comparison) {
  std::vector<std::string> warnings;
  for (const CompareRow& row : comparison.rows) {
    const auto count = std::count_if(row.runs.begin(), row.runs.end(), std::mem_fn(&RunResult::force_was_withheld));
    if (count == 0) continue;
    const auto first = std::find_if(row.runs.begin(), row.runs.end(), std::mem_fn(&RunResult::force_was_withheld));
    warnings.push_back(fmt::format("{}: {}, in {} of {} runs", case_name(row.graph, row.configuration),
                                   no_force_text(*first), count, row.runs.size()));
  }
  return warnings;
}

/// The rows whose seeds are copies of one run; empty where there is none.
std::string copies_warning(const Comparison& comparison) {
  std::vector<std::string> names;
  for (const CompareRow& row : comparison.rows) {
    if (row.identical_seeds) names.push_back(case_name(row.graph, row.configuration));
  }
  if (names.empty()) return {};
  const std::string rows =
      names.size() == comparison.rows.size()
          ? std::string("each row")
          : fmt::format("{} of {} rows ({})", names.size(), comparison.rows.size(), first_names(names));
  return "the runs of all seeds are identical in " + rows +
         ", because nothing in them is random: further seeds tell no more, and no difference between such rows is "
         "tested";
}

}  // namespace

std::vector<std::string> comparison_warnings(const Comparison& comparison) {
  std::vector<std::string> warnings = comparison.further_warnings, untouched;
  for (const CompareRow& row : comparison.rows) {
    const std::string name = case_name(row.graph, row.configuration);
    if (!row.unlike.empty()) warnings.push_back(name + ": " + row.unlike);
    if (row.never_touches()) untouched.push_back(name);
  }
  for (std::string& warning : no_force_warnings(comparison)) warnings.push_back(std::move(warning));
  for (std::string& warning : coarse_warnings(comparison)) warnings.push_back(std::move(warning));
  const std::string copies = copies_warning(comparison);
  if (!copies.empty()) warnings.push_back(copies);
  const std::size_t count = untouched.size();
  if (count == comparison.rows.size() && count > 0) {
    warnings.emplace_back(
        "nothing touches in any run: every force is that of a tool in free space, so no difference is tested");
  } else if (count > 0) {
    warnings.push_back(
        fmt::format("nothing touches in any run of {} of {} rows: {}; if neither a row nor its baseline has contact, "
                    "their difference is not tested",
                    count, comparison.rows.size(), first_names(untouched)));
  }
  return warnings;
}

std::string warning_lines(const Comparison& comparison) {
  std::string text;
  for (const std::string& warning : comparison_warnings(comparison)) text += "  WARNING: " + warning + "\n";
  return text.empty() ? text : "\n" + text;
}

std::string warnings_html(const std::vector<std::string>& warnings) {
  std::string html;
  for (const std::string& warning : warnings) {
    html += "<p class=\"bad\">Warning: " + escape(warning) + "</p>\n";
  }
  return html;
}

std::string difference_beside_method(const GraphSpec& graph, const GraphSpec& other) {
  const Scene &scene = graph.scene, &of_other = other.scene;
  std::vector<std::string> parts;
  if (scene.gravity_W != of_other.gravity_W) parts.emplace_back("has another gravity");
  if (scene.moving().size() == of_other.moving().size() && scene.tool() != nullptr &&
      scene.tool()->name != of_other.tool()->name) {
    parts.emplace_back("has another tool");
  }
  for (const Body& theirs : of_other.bodies) {
    const Body* mine = find(scene, theirs.name);
    if (mine == nullptr) {
      parts.push_back("lacks the body " + theirs.name);
      continue;
    }
    std::vector<std::string> what;
    if (mine->shape != theirs.shape) what.emplace_back("shape");
    if (mine->X_WB != theirs.X_WB) what.emplace_back("pose");
    if (mine->motion != theirs.motion) what.emplace_back("motion");
    if (mine->mass != theirs.mass || mine->inertia != theirs.inertia) what.emplace_back("mass");
    if (mine->material != theirs.material) what.emplace_back("material");
    if (mine->deformable != theirs.deformable) what.emplace_back("elasticity");
    if (!what.empty()) parts.push_back(fmt::format("has another {} of {}", fmt::join(what, " and "), theirs.name));
  }
  for (const Body& mine : scene.bodies) {
    if (find(of_other, mine.name) == nullptr) parts.push_back("has the body " + mine.name + " besides");
  }
  const std::string coupling = difference_of_coupling(graph, other);
  std::vector<std::string> sentences;
  if (!parts.empty()) {
    sentences.push_back(fmt::format("its scene differs from that of {}: it {}", other.name, fmt::join(parts, ", ")));
  }
  if (!coupling.empty()) {
    sentences.push_back(fmt::format("its coupling differs from that of {} in {}", other.name, coupling));
  }
  if (sentences.empty()) return {};
  return fmt::format("{}; so more than the method differs", fmt::join(sentences, "; "));
}

}  // namespace tactor
