#include "app/study/table/warnings.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/report/html_page.hpp"
#include "app/study/plan/run_case.hpp"

namespace tactor {

namespace {

const Body* find(const Scene& scene, const std::string& name) {
  const auto found =
      std::find_if(scene.bodies.begin(), scene.bodies.end(), [&](const Body& body) { return body.name == name; });
  return found == scene.bodies.end() ? nullptr : &*found;
}

bool same(const Material& a, const Material& b) {
  return a.stiffness == b.stiffness && a.damping == b.damping && a.friction == b.friction &&
         a.patch_area == b.patch_area;
}

}  // namespace

std::vector<std::string> comparison_warnings(const Comparison& comparison) {
  constexpr std::size_t most_named = 5;
  std::vector<std::string> warnings = comparison.further_warnings, untouched;
  for (const CompareRow& row : comparison.rows) {
    const std::string name = case_name(row.graph, row.configuration);
    if (!row.unlike.empty()) warnings.push_back(name + ": " + row.unlike);
    if (row.never_touches()) untouched.push_back(name);
  }
  const std::size_t count = untouched.size();
  if (count == comparison.rows.size() && count > 0) {
    warnings.emplace_back(
        "nothing touches in any run: every force is that of a tool in free space, so no difference is tested");
  } else if (count > 0) {
    if (count > most_named) {
      untouched.resize(most_named);
      untouched.emplace_back("...");
    }
    warnings.push_back(
        fmt::format("nothing touches in any run of {} of {} rows: {}; if neither a row nor its baseline has contact, "
                    "their difference is not tested",
                    count, comparison.rows.size(), fmt::join(untouched, ", ")));
  }
  return warnings;
}

std::string warning_lines(const Comparison& comparison) {
  std::string text;
  for (const std::string& warning : comparison_warnings(comparison)) text += "  WARNING: " + warning + "\n";
  return text.empty() ? text : "\n" + text;
}

std::string warnings_html(const Comparison& comparison) {
  std::string html;
  for (const std::string& warning : comparison_warnings(comparison)) {
    html += "<p class=\"bad\">Warning: " + escape(warning) + "</p>\n";
  }
  return html;
}

std::string scene_difference(const Scene& scene, const Scene& of_other, const std::string& other) {
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
    if (!same(mine->material, theirs.material)) what.emplace_back("material");
    if (mine->deformable != theirs.deformable) what.emplace_back("elasticity");
    if (!what.empty()) parts.push_back(fmt::format("has another {} of {}", fmt::join(what, " and "), theirs.name));
  }
  for (const Body& mine : scene.bodies) {
    if (find(of_other, mine.name) == nullptr) parts.push_back("has the body " + mine.name + " besides");
  }
  if (parts.empty()) return {};
  return fmt::format("its scene differs from that of {}: it {}; so more than the method differs", other,
                     fmt::join(parts, ", "));
}

}  // namespace tactor
