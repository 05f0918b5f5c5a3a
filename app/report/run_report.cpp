#include "app/report/run_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "app/report/figure.hpp"
#include "app/report/html_page.hpp"
#include "app/report/method_style.hpp"
#include "app/report/provenance_html.hpp"
#include "app/report/run_curves.hpp"
#include "app/report/scene_picture.hpp"
#include "app/run/headline.hpp"
#include "app/run/summary.hpp"
#include "framework/core/check.hpp"

namespace tactor {

namespace {

std::string metrics_table(const RunResult& run) {
  HtmlTable table({"metric", "value", "unit", "better", ""});
  for (const auto& [name, value] : run.metrics) {
    const MetricInfo* info = run.info(name);
    std::vector<std::string> cells{breakable(name), pretty(value), "", "", ""};
    if (info != nullptr) {
      cells[2] = escape(unit_text(info->unit));
      cells[3] = better_text(info->better);
      cells[4] = escape(info->doc);
    }
    table.add(cells);
  }
  return table.html();
}

std::string cost_table(const RunResult& run) {
  HtmlTable table({"node", "type", "steps", "median µs", "p99 µs", "CPU s"});
  for (const NodeCost& node : run.nodes) {
    table.add({breakable(node.node), breakable(node.type), std::to_string(node.steps), pretty(node.median_us),
               pretty(node.p99_us), pretty(node.total_s)});
  }
  return table.html();
}

std::string edge_table(const RunResult& run) {
  HtmlTable table({"edge", "queue", "delivered", "dropped", "superseded"});
  for (const EdgeResult& edge : run.edges) {
    table.add({breakable(edge.edge), escape(edge.queue), std::to_string(edge.metrics.delivered),
               std::to_string(edge.metrics.dropped), std::to_string(edge.metrics.superseded)});
  }
  return table.html();
}

std::string capitalised(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

/// How the run ended, as a sentence.
std::string verdict(const std::vector<HeadlineLine>& lines) {
  return "<p class=\"verdict\"><b>" + escape(capitalised(lines.front().text)) + ".</b></p>\n";
}

/// A row for each other line of the headline.
std::string headline_table(const RunResult& run, const std::vector<HeadlineLine>& lines) {
  HtmlTable table({"", ""});
  for (std::size_t i = 1; i < lines.size(); ++i) {
    table.add({defined(capitalised(lines[i].name), run.info(lines[i].metric)), escape(lines[i].text)});
  }
  return table.html();
}

/// Why there is no chart of the error, where nothing else on the page says so.
std::string why_no_error(const RunResult& run) {
  if (run.reference.made || run.reference_interrupted || run.failure || run.force_was_withheld()) return {};
  return "<p class=\"sub\">No error is shown: nothing in the graph asks for a reference, as a node sink.metrics "
         "does.</p>\n";
}

std::string rows_figure(const RunResult& run, const std::string& color) {
  const std::vector<Chart> rows = run_rows(run, color);
  return rows.empty() ? std::string() : "<h2>The run</h2>\n" + chart_figure(rows, 1160, 210);
}

/// Error and force over time, beside each other.
std::string first_charts(const Chart& error, const Chart& force) {
  constexpr int half_width = 580, height = 330;
  return "<div class=\"pair\">\n" + chart_figure({error}, half_width, height) +
         chart_figure({force}, half_width, height) + "</div>\n";
}

/// The scene at the largest force; at the begin where there was none, or where it is not known how it was then.
std::string picture_of(const RunResult& run, const GraphSpec& graph, DrawnScene drawn) {
  if (!run.trace.largest || run.trace.largest->X_WB.empty()) return scene_figure(drawn, "The scene as the run begins.");
  const LargestForce& largest = *run.trace.largest;
  const std::vector<std::size_t> moving = graph.scene.moving();
  for (std::size_t i = 0; i < std::min(moving.size(), largest.X_WB.size()); ++i)
    drawn.put(graph.scene.bodies[moving[i]].name, i == 0, largest.X_WB[i]);
  std::string caption = fmt::format("The scene at the largest force, {} N at {} s; the arrow is the force on the hand.",
                                    pretty(norm(largest.force_W)), pretty(largest.time_s));
  if (!graph.scene.deformable().empty()) caption += " Deformable bodies are drawn as the run begins.";
  if (drawn.has_bodies_beside(graph.scene)) caption += " Bodies that are not in `scene` are drawn as the run begins.";
  return scene_figure(drawn, caption, largest.force_W);
}

std::string picture(const RunResult& run, const GraphSpec& graph) {
  try {
    return picture_of(run, graph, drawn_scene(graph));
  } catch (const InputError& error) {
    return no_scene_figure(error);
  }
}

std::string zoom_figure(const RunResult& run, const std::string& color) {
  const std::pair<double, double> range = liveliest_window(run);
  const std::string axis = liveliest_axis(run, range);
  Chart zoom = zoom_on(run, range, axis);
  if (const Series* s = run.curve("commanded." + axis)) zoom.curves.push_back(cut(*s, "commanded", color, range));
  if (zoom.curves.empty()) return {};
  zoom.curves.push_back(arrivals(run, range, axis));
  return chart_figure({zoom}, 1160, 360);
}

}  // namespace

std::string chosen_and_left_out(const RunResult& run) {
  std::string items;
  for (const Chosen& c : run.chosen) {
    items +=
        fmt::format("<li>node {}: {} is {}: {}</li>\n", escape(c.node), escape(c.asked), escape(c.type), escape(c.why));
  }
  if (run.left_out.empty()) items += "<li>nothing was left out</li>\n";
  for (const LeftOut& item : run.left_out) {
    items += fmt::format("<li>{}: {}</li>\n", escape(item.what), escape(item.why));
  }
  return "<ul>" + items + "</ul>\n";
}

std::string run_report(const RunResult& run, const GraphSpec* graph) {
  const std::string color = method_styles({run.graph}).front().color;
  const std::string time = run.live ? "live" : fmt::format("of virtual time in {} s", pretty(run.wall_s));
  std::string body = fmt::format("<p class=\"sub\">{}{}seed {}, {} s {}, {} MB, tactor {}</p>\n", escape(run.title),
                                 run.title.empty() ? "" : " · ", run.seed, pretty(run.duration_s), time,
                                 pretty(run.peak_memory_MB), TACTOR_VERSION);
  const std::vector<HeadlineLine> lines = headline(run);
  body += verdict(lines);
  if (run.failure) body += "<p class=\"bad\">The run has failed: " + escape(*run.failure) + "</p>\n";
  if (run.interrupted && !run.live) {
    body +=
        fmt::format("<p class=\"bad\">The run was interrupted after {} s of {} s: its metrics are of that part.</p>\n",
                    pretty(run.duration_s), pretty(run.planned_s));
  } else if (run.interrupted) {
    body += "<p>The run was ended early.</p>\n";
  }
  for (const std::string& text : warnings_of(run)) body += "<p class=\"bad\">" + escape(text) + "</p>\n";
  if (run.trace.lost > 0) {
    body += fmt::format(
        "<p class=\"bad\">{} messages of the devices were not taken in time: curves and picture may lack peaks.</p>\n",
        run.trace.lost);
  }
  const std::optional<Chart> error = error_over_time(run, color);
  const std::string rows = rows_figure(run, color);
  body += error ? first_charts(*error, *judged_force_over_time(run, color)) : why_no_error(run) + rows;
  body += "<div class=\"pair\">\n" + headline_table(run, lines) +
          (graph == nullptr ? std::string() : picture(run, *graph)) + "</div>\n";
  body += zoom_figure(run, color);
  if (error) body += rows;
  body += folded("All metrics", metrics_table(run));
  body += folded("Run time", "<p>CPU time of each step on one core.</p>\n" + cost_table(run));
  body += folded("Edges", edge_table(run));
  body += folded("Chosen and left out", chosen_and_left_out(run));
  body += provenance_html(run.provenance);
  body += folded("Graph, resolved", "<pre>" + escape(run.graph_yaml) + "</pre>\n");
  return page(run.graph, body);
}

}  // namespace tactor
