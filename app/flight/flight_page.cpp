#include "app/flight/flight_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "app/flight/flight_text.hpp"
#include "app/report/figure.hpp"
#include "app/report/html_page.hpp"
#include "app/report/run_curves.hpp"

namespace tactor {

namespace {

struct ShownTick {
  double time_s;
  FlightDevice body;
};
using FlightTicks = std::vector<ShownTick>;

double euclidean(const FlightVector& v) {
  return std::sqrt(static_cast<double>(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
}

/// What a tick has of a curve; NaN: nothing.
using OfTick = std::function<double(const FlightDevice&)>;

Curve curve_of(const FlightTicks& ticks, const std::string& name, std::size_t color, const OfTick& of) {
  Series series{name, "", {}, {}};
  for (const ShownTick& tick : ticks) {
    const double value = of(tick.body);
    if (!std::isfinite(value)) continue;
    series.time.push_back(tick.time_s);
    series.value.push_back(value);
  }
  return thinned(series, name, series_color(color), series.time.empty() ? 0 : series.time.front());
}

/// The findings of each kind as marks at zero.
void add_marks(const std::vector<FlightFinding>& findings, Chart& chart) {
  for (const FlightFinding& finding : findings) {
    const std::string name(name_of(finding.fault));
    auto marks = std::find_if(chart.curves.begin(), chart.curves.end(),
                              [&](const Curve& curve) { return curve.points && curve.name == name; });
    if (marks == chart.curves.end()) {
      Curve made{name, {}, {}, series_color(chart.curves.size())};
      made.points = true;
      made.mark = chart.curves.size() % mark_shapes;
      marks = chart.curves.insert(chart.curves.end(), std::move(made));
    }
    marks->x.push_back(finding.time.seconds());
    marks->y.push_back(0);
  }
}

Chart chart_of(const std::string& name, const std::string& title, const std::string& unit,
               std::pair<double, double> range, std::vector<Curve> curves) {
  Chart chart{title, "time s", unit, std::move(curves), range};
  chart.name = name;
  return chart;
}

}  // namespace

std::vector<Chart> flight_charts(const FlightLog& log, const std::vector<FlightFinding>& findings) {
  std::vector<Chart> charts;
  const std::pair<double, double> range{log.first().seconds(), log.last().seconds()};
  for (std::size_t n = 0; n < log.nodes.size(); ++n) {
    FlightTicks ticks;
    for (const FlightRecord& record : log.records) {
      if (record.kind == FlightKind::device && record.node == n) {
        ticks.push_back({log.time_of(record).seconds(), body_of<FlightDevice>(record)});
      }
    }
    if (ticks.empty()) continue;
    const std::string of = " of " + log.nodes[n].name;
    const auto add = [&](const char* name, const std::string& title, const char* unit, std::vector<Curve> curves) {
      charts.push_back(chart_of(log.nodes[n].name + "." + name, title + of, unit, range, std::move(curves)));
    };
    add("force", "Force", "N",
        {curve_of(ticks, "wanted", 0, [](const auto& t) { return euclidean(t.wanted_force); }),
         curve_of(ticks, "commanded", 1, [](const auto& t) { return euclidean(t.commanded_force); })});
    add("position", "Position", "m",
        {curve_of(ticks, "x", 0, [](const auto& t) { return t.p_WD[0]; }),
         curve_of(ticks, "y", 1, [](const auto& t) { return t.p_WD[1]; }),
         curve_of(ticks, "z", 2, [](const auto& t) { return t.p_WD[2]; })});
    add("gate", "Safety gate: part of the force that it lets through, and the findings", "",
        {curve_of(ticks, "gate", 0, [](const auto& t) { return t.gain; })});
    add_marks(findings, charts.back());
    add("wake", "Wake-up", "ms",
        {curve_of(ticks, "late", 0, [](const auto& t) { return t.lateness_s * 1e3; }),
         curve_of(ticks, "step", 1, [](const auto& t) { return t.body_s * 1e3; })});
    add("age", "Age", "ms",
        {curve_of(ticks, "result", 0, [](const auto& t) { return t.result_age_s * 1e3; }),
         curve_of(ticks, "sample", 1, [](const auto& t) { return t.sample_age_s * 1e3; })});
  }
  return charts;
}

std::string flight_page(const FlightSource& source, const std::vector<FlightFinding>& findings) {
  const FlightLog& log = source.log;
  const std::string fault = findings.empty() ? "nothing went wrong" : fault_line(findings.front());
  std::string body = fmt::format("<p class=\"sub\">{}, process {}, tactor {}</p>\n", escape(source.path.string()),
                                 log.process, escape(log.version));
  body += "<p class=\"verdict\"><b>" + escape(fault) + "</b></p>\n";
  const std::vector<Chart> charts = flight_charts(log, findings);
  if (!charts.empty()) body += chart_figure(charts, 1160, 210);
  if (!findings.empty()) {
    HtmlTable table({"found", "node", "s", ""});
    for (const FlightFinding& finding : findings) {
      table.add({std::string(name_of(finding.fault)), escape(finding.node),
                 fmt::format("{:.3f}", finding.time.seconds()), escape(finding.words)});
    }
    body += table.html();
  }
  return page(log.graph + ": flight recorder", body);
}

}  // namespace tactor
