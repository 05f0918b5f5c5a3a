#include "app/report/run_curves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "app/run/envelope.hpp"
#include "app/run/summary.hpp"
#include "framework/core/perception.hpp"
#include "framework/realtime/safety_gate.hpp"

namespace tactor {

namespace {

constexpr const char* reference_color = "#555555";

std::pair<double, double> whole_of(const RunResult& run) {
  return {0, run.duration_s};
}

/// The interval that the metrics are of; the whole run where none is told.
std::pair<double, double> judged_of(const RunResult& run) {
  const double from = run.metric("judged.from_s");
  return from < run.duration_s ? std::pair{from, run.duration_s} : whole_of(run);
}

/// One curve a device, by its name where there are several.
template <class Of>
std::vector<Curve> curves_of_devices(const RunResult& run, const Of& of, const std::string& name) {
  std::vector<Curve> curves;
  for (const DeviceTrace& device : run.trace.devices) {
    const Series& series = of(device);
    if (series.time.empty()) continue;
    curves.push_back(
        {run.trace.devices.size() > 1 ? device.device : name, series.time, series.value, series_color(curves.size())});
  }
  return curves;
}

/// `, judged from 0.2 s on`, for titles; empty where the whole run is judged.
std::string judged_text(const RunResult& run) {
  const double from = judged_of(run).first;
  return from > 0 ? fmt::format(", judged from {} s on", pretty(from)) : "";
}

Chart gate_over_time(const RunResult& run) {
  Chart chart{"Safety gate: part of the force that it lets through", "time s", "", {}, whole_of(run)};
  chart.name = "gate";
  chart.curves = curves_of_devices(run, std::mem_fn(&DeviceTrace::gate), "");
  std::map<SafetyCause, Curve> causes;
  for (const DeviceTrace& device : run.trace.devices) {
    for (const GateEvent& event : device.events) {
      Curve& marks = causes[event.cause];
      marks.x.push_back(event.time_s);
      marks.y.push_back(0);
    }
  }
  for (auto& [cause, marks] : causes) {
    marks.name = name_of(cause);
    marks.points = true;
    marks.mark = chart.curves.size();
    marks.color = series_color(chart.curves.size());
    chart.curves.push_back(std::move(marks));
  }
  return chart;
}

bool shows_gate(const RunResult& run) {
  return std::any_of(run.trace.devices.begin(), run.trace.devices.end(), [&run](const DeviceTrace& device) {
    return !device.gate.time.empty() && (run.live || !device.events.empty());
  });
}

}  // namespace

Curve thinned(const Series& series, std::string name, std::string color, double from_s) {
  constexpr std::size_t pieces = 1750;
  Envelope envelope(pieces);
  for (std::size_t i = 0; i < series.time.size(); ++i) {
    if (series.time[i] >= from_s) envelope.add(series.time[i], series.value[i]);
  }
  Series kept = envelope.series({}, {});
  return {std::move(name), std::move(kept.time), std::move(kept.value), std::move(color)};
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
  // Not in what no metric is of, and not as a run without metrics begins.
  constexpr double beginning = 0.3;
  const double from = std::max(judged_of(run).first, std::min(beginning, run.duration_s - 2 * length));
  std::size_t begin = 0;
  double best = -1;
  double at = t.front();
  for (std::size_t end = 0; end < t.size(); ++end) {
    while (t[end] - t[begin] > length) ++begin;
    if (path[end] - path[begin] > best && t[begin] >= from) {
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

namespace {

/// The force from that time on, as the sink of the run tells it.
std::vector<Curve> told_forces(const RunResult& run, const std::string& color, double from_s) {
  std::vector<Curve> curves;
  if (const Series* s = run.curve("reference.norm"))
    curves.push_back(thinned(*s, "reference", reference_color, from_s));
  if (const Series* s = run.curve("commanded.norm")) curves.push_back(thinned(*s, "commanded", color, from_s));
  return curves;
}

}  // namespace

std::optional<Chart> judged_force_over_time(const RunResult& run, const std::string& color) {
  const std::pair<double, double> judged = judged_of(run);
  Chart chart{"Force on the device" + judged_text(run), "time s", "N", told_forces(run, color, judged.first), judged};
  chart.name = "judged_force";
  if (chart.curves.empty()) return std::nullopt;
  return chart;
}

std::optional<Chart> force_over_time(const RunResult& run, const std::string& color) {
  Chart chart{"Force on the device", "time s", "N", told_forces(run, color, 0), whole_of(run)};
  chart.name = "force";
  if (chart.curves.empty()) chart.curves = curves_of_devices(run, std::mem_fn(&DeviceTrace::force), "commanded");
  if (chart.curves.empty()) return std::nullopt;
  return chart;
}

std::optional<Chart> error_over_time(const RunResult& run, const std::string& color) {
  std::array<const Series*, 3> commanded{}, reference{};
  std::size_t axis = 0;
  for (const char* name : {"x", "y", "z"}) {
    commanded[axis] = run.curve(std::string("commanded.") + name);
    reference[axis] = run.curve(std::string("reference.") + name);
    if (commanded[axis] == nullptr || reference[axis] == nullptr) return std::nullopt;
    ++axis;
  }
  Series error{"error", "N", commanded[0]->time, {}}, noticed{"noticed", "N", commanded[0]->time, {}};
  for (std::size_t i = 0; i < error.time.size(); ++i) {
    const auto at = [i](const std::array<const Series*, 3>& of) {
      return Vec3{of[0]->value[i], of[1]->value[i], of[2]->value[i]};
    };
    error.value.push_back(norm(at(commanded) - at(reference)));
    noticed.value.push_back(force_jnd(norm(at(reference))));
  }
  Chart chart{"Error of the force" + judged_text(run), "time s", "N", {}, judged_of(run)};
  chart.name = "error";
  chart.curves = {thinned(noticed, "what a hand notices", "#888888", chart.x_range->first),
                  thinned(error, "error", color, chart.x_range->first)};
  chart.curves.front().dash = 1;
  return chart;
}

std::vector<Chart> run_rows(const RunResult& run, const std::string& color) {
  std::vector<Chart> charts;
  const auto add = [&](const char* name, const char* title, const char* unit, std::vector<Curve> curves, bool steps) {
    if (curves.empty() || curves.front().x.empty()) return;
    Chart& chart = charts.emplace_back(Chart{title, "time s", unit, std::move(curves), whole_of(run)});
    chart.name = name;
    chart.curves.front().steps = steps;
  };
  const auto of_series = [&run](const char* name) {
    const Series* s = run.curve(name);
    return s == nullptr ? std::vector<Curve>{} : std::vector<Curve>{thinned(*s, "", series_color(0))};
  };
  if (std::optional<Chart> force = force_over_time(run, color)) charts.push_back(std::move(*force));
  std::vector<Curve> displacement = of_series("displacement");
  if (displacement.empty()) displacement = curves_of_devices(run, std::mem_fn(&DeviceTrace::displacement), "");
  add("displacement", "Device displacement", "m", std::move(displacement), false);
  if (shows_gate(run)) charts.push_back(gate_over_time(run));
  add("contacts", "Contacts", "", of_series("contacts"), true);
  add("physics_rate", "Physics rate", "Hz", of_series("physics_rate"), true);
  return charts;
}

Chart zoom_on(const RunResult& run, std::pair<double, double> range, const std::string& axis) {
  Chart chart{fmt::format("The 150 ms in which the force moves most: along {}", axis), "time s", "N", {}, range};
  chart.name = "zoom";
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
