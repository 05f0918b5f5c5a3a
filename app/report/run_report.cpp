#include "app/report/run_report.hpp"

#include <fmt/format.h>

#include "app/report/chart.hpp"
#include "app/report/html_page.hpp"
#include "app/report/run_curves.hpp"
#include "app/run/headline.hpp"
#include "app/run/summary.hpp"

namespace tactor {

namespace {

std::string metrics_table(const RunResult& run) {
  std::string rows;
  for (const auto& [name, value] : run.metrics) {
    const MetricInfo* info = run.info(name);
    rows += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", escape(name),
                        pretty(value), info == nullptr ? "" : escape(unit_text(info->unit)),
                        info == nullptr ? "" : better_text(info->better), info == nullptr ? "" : escape(info->doc));
  }
  return "<table><thead><tr><th>metric</th><th>value</th><th>unit</th><th>better</th><th></th></tr></thead><tbody>\n" +
         rows + "</tbody></table>\n";
}

std::string cost_table(const RunResult& run) {
  std::string rows;
  for (const NodeCost& node : run.nodes) {
    rows +=
        fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", escape(node.node),
                    escape(node.type), node.steps, pretty(node.median_us), pretty(node.p99_us), pretty(node.total_s));
  }
  return "<table><thead><tr><th>node</th><th>type</th><th>steps</th><th>median µs</th><th>p99 µs</th><th>CPU "
         "s</th></tr></thead><tbody>\n" +
         rows + "</tbody></table>\n";
}

std::string edge_table(const RunResult& run) {
  std::string rows;
  for (const EdgeResult& edge : run.edges) {
    rows += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", escape(edge.edge),
                        escape(edge.queue), edge.metrics.delivered, edge.metrics.dropped, edge.metrics.superseded);
  }
  return "<table><thead><tr><th>edge</th><th>queue</th><th>delivered</th><th>dropped</th><th>superseded</th></tr>"
         "</thead><tbody>\n" +
         rows + "</tbody></table>\n";
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

std::string run_report(const RunResult& run) {
  const std::string time = run.live ? "live" : fmt::format("of virtual time in {} s", pretty(run.wall_s));
  std::string body = fmt::format("<p class=\"sub\">{}{}seed {}, {} s {}, {} MB, tactor {}</p>\n", escape(run.title),
                                 run.title.empty() ? "" : " · ", run.seed, pretty(run.duration_s), time,
                                 pretty(run.peak_memory_MB), TACTOR_VERSION);
  if (run.failure) body += "<p class=\"bad\">The run has failed: " + escape(*run.failure) + "</p>\n";
  if (run.interrupted && !run.live) {
    body +=
        fmt::format("<p class=\"bad\">The run was interrupted after {} s of {} s: its metrics are of that part.</p>\n",
                    pretty(run.duration_s), pretty(run.planned_s));
  } else if (run.interrupted) {
    body += "<p>The run was ended early.</p>\n";
  }
  for (const std::string& text : warnings_of(run)) body += "<p class=\"bad\">" + escape(text) + "</p>\n";
  for (const auto& [name, text] : headline(run)) body += fmt::format("<p><b>{}</b>: {}</p>\n", name, escape(text));
  const std::vector<Chart> rows = four_rows(run);
  if (!rows.empty()) body += "<h2>The run</h2>\n" + draw_svg(rows, 1160, 210);
  const std::pair<double, double> range = liveliest_window(run);
  const std::string axis = liveliest_axis(run, range);
  Chart zoom = zoom_on(run, range, axis);
  if (const Series* s = run.curve("commanded." + axis))
    zoom.curves.push_back(cut(*s, "commanded", series_color(0), range));
  if (!zoom.curves.empty()) {
    zoom.curves.push_back(arrivals(run, range, axis));
    body += "<h2>Zoom</h2>\n" + draw_svg({zoom}, 1160, 360);
  }
  body += "<h2>Metrics</h2>\n" + metrics_table(run);
  body += "<h2>Run time</h2>\n<p>CPU time of each step on one core.</p>\n" + cost_table(run);
  body += "<h2>Edges</h2>\n" + edge_table(run);
  body += "<h2>Chosen and left out</h2>\n" + chosen_and_left_out(run);
  body += "<h2>Graph, resolved</h2>\n<pre>" + escape(run.graph_yaml) + "</pre>\n";
  return page(run.graph, body);
}

}  // namespace tactor
