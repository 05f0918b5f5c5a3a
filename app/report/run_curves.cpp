#include "app/report/run_curves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactor {

Curve thinned(const Series& series, std::string name, std::string color, std::size_t most) {
  Curve curve;
  curve.name = std::move(name);
  curve.color = std::move(color);
  const std::size_t step = std::max<std::size_t>(1, series.time.size() / most);
  for (std::size_t i = 0; i < series.time.size(); i += step) {
    curve.x.push_back(series.time[i]);
    curve.y.push_back(series.value[i]);
  }
  return curve;
}

Curve cut(const Series& series, std::string name, std::string color, std::pair<double, double> range) {
  Curve curve;
  curve.name = std::move(name);
  curve.color = std::move(color);
  // One sample beyond each end, so that lines reach the border and steps begin with the value held before.
  for (std::size_t i = 0; i < series.time.size(); ++i) {
    const bool before = i + 1 < series.time.size() && series.time[i + 1] < range.first;
    const bool after = i > 0 && series.time[i - 1] > range.second;
    if (before || after) continue;
    curve.x.push_back(series.time[i]);
    curve.y.push_back(series.value[i]);
  }
  return curve;
}

std::pair<double, double> liveliest_window(const RunResult& run) {
  constexpr double length = 0.150;
  const Series* force = run.curve("reference.norm");
  if (force == nullptr) force = run.curve("commanded.norm");
  if (force == nullptr || force->time.size() < 3) return {0, length};
  const std::vector<double>& t = force->time;
  const std::vector<double>& f = force->value;
  std::vector<double> path(f.size(), 0.0);
  for (std::size_t i = 1; i < f.size(); ++i) path[i] = path[i - 1] + std::abs(f[i] - f[i - 1]);
  std::size_t begin = 0;
  double best = -1;
  double at = t.front();
  for (std::size_t end = 0; end < t.size(); ++end) {
    while (t[end] - t[begin] > length) ++begin;
    if (path[end] - path[begin] > best && t[begin] > 0.3) {
      best = path[end] - path[begin];
      at = t[begin];
    }
  }
  return {at, at + length};
}

std::string liveliest_axis(const RunResult& run, std::pair<double, double> range) {
  std::string best = "x";
  double most = -1;
  for (const char* axis : {"x", "y", "z"}) {
    const Series* s = run.curve(std::string("commanded.") + axis);
    if (s == nullptr) continue;
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (std::size_t i = 0; i < s->time.size(); ++i) {
      if (s->time[i] < range.first || s->time[i] > range.second) continue;
      low = std::min(low, s->value[i]);
      high = std::max(high, s->value[i]);
    }
    if (high - low > most) {
      most = high - low;
      best = axis;
    }
  }
  return best;
}

std::vector<Chart> four_rows(const RunResult& run) {
  std::vector<Chart> charts;
  const std::pair<double, double> range{0, run.duration_s};
  Chart force{"Force on the device", "", "N", {}, range};
  if (const Series* s = run.curve("reference.norm")) {
    force.curves.push_back(thinned(*s, "reference", "#555555"));
  }
  if (const Series* s = run.curve("commanded.norm")) {
    force.curves.push_back(thinned(*s, "commanded", series_color(0)));
  }
  if (!force.curves.empty()) charts.push_back(std::move(force));
  struct Row {
    const char* series;
    const char* title;
    const char* unit;
    bool steps;
  };
  for (const Row& row : {Row{"displacement", "Device displacement", "m", false}, Row{"contacts", "Contacts", "", true},
                         Row{"physics_rate", "Physics rate", "Hz", true}}) {
    const Series* s = run.curve(row.series);
    if (s == nullptr || s->time.empty()) continue;
    Chart chart{row.title, "", row.unit, {thinned(*s, "", series_color(0))}, range};
    chart.curves.front().steps = row.steps;
    charts.push_back(std::move(chart));
  }
  if (!charts.empty()) charts.back().x_label = "time s";
  return charts;
}

Chart zoom_on(const RunResult& run, std::pair<double, double> range, const std::string& axis) {
  Chart chart{fmt::format("150 ms, force along {}", axis), "time s", "N", {}, range};
  if (const Series* s = run.curve("reference." + axis)) {
    chart.curves.push_back(cut(*s, "reference", "#000000", range));
    chart.curves.back().dash = 1;
  }
  return chart;
}

Curve arrivals(const RunResult& run, std::pair<double, double> range, const std::string& axis) {
  Curve curve;
  if (const Series* s = run.curve("physics." + axis)) curve = cut(*s, "physics results, on arrival", "#888888", range);
  curve.points = true;
  return curve;
}

}  // namespace tactor
