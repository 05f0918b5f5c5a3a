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

/// The headline as sentences: how the run ended, then what each of its lines tells.
std::string verdict(const RunResult& run) {
  const auto capitalised = [](std::string text) {
    if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
    return text;
  };
  std::string sentences;
  for (const HeadlineLine& line : headline(run)) {
    if (sentences.empty()) {
      sentences = "<b>" + escape(capitalised(line.text)) + ".</b>";
    } else {
      sentences += fmt::format(" {}: {}.", defined(capitalised(line.name), run.info(line.metric)), escape(line.text));
    }
  }
  return "<p class=\"verdict\">" + sentences + "</p>\n";
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

std::string run_report(const RunResult& run, const std::string& scene) {
  const std::string time = run.live ? "live" : fmt::format("of virtual time in {} s", pretty(run.wall_s));
  std::string body = verdict(run);
  body += fmt::format("<p class=\"sub\">{}{}seed {}, {} s {}, {} MB, tactor {}</p>\n", escape(run.title),
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
  body += scene;
  const std::vector<Chart> rows = four_rows(run);
  if (!rows.empty()) body += "<h2>The run</h2>\n" + chart_figure(rows, 1160, 210);
  const std::pair<double, double> range = liveliest_window(run);
  const std::string axis = liveliest_axis(run, range);
  Chart zoom = zoom_on(run, range, axis);
  if (const Series* s = run.curve("commanded." + axis))
    zoom.curves.push_back(cut(*s, "commanded", series_color(0), range));
  if (!zoom.curves.empty()) {
    zoom.curves.push_back(arrivals(run, range, axis));
    body += "<h2>Zoom</h2>\n" + chart_figure({zoom}, 1160, 360);
  }
  body += "<h2>Metrics</h2>\n" + metrics_table(run);
  body += "<h2>Run time</h2>\n<p>CPU time of each step on one core.</p>\n" + cost_table(run);
  body += "<h2>Edges</h2>\n" + edge_table(run);
  body += "<h2>Chosen and left out</h2>\n" + chosen_and_left_out(run);
  body += "<h2>Graph, resolved</h2>\n<pre>" + escape(run.graph_yaml) + "</pre>\n";
  return page(run.graph, body);
}

}  // namespace tactor
