#include "app/study/plan/study_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "framework/core/text.hpp"

namespace tactor {

std::string label(const StudySetting& setting) {
  std::vector<std::string> parts;
  if (!setting.method.empty()) parts.push_back(setting.method);
  for (const auto& [path, value] : setting.values) parts.push_back(fmt::format("{}={}", path, value));
  return parts.empty() ? "as it is" : fmt::format("{}", fmt::join(parts, " "));
}

namespace {

/// Sets of every setting the one that has the values of the baseline and is otherwise like it.
void find_counterparts(const StudySpec& spec, std::vector<StudySetting>& settings) {
  using Cell = std::pair<std::string, std::vector<std::pair<std::string, std::string>>>;
  std::map<Cell, std::size_t> cells;
  for (std::size_t s = 0; s < settings.size(); ++s) {
    cells.emplace(Cell{settings[s].method, settings[s].values}, s);
    settings[s].against = s;
  }
  for (StudySetting& setting : settings) {
    const Cell own{setting.method, setting.values};
    Cell cell = own;
    for (const AxisValue& at : spec.baseline) {
      if (at.axis == "method") cell.first = at.value;
      for (auto& [axis, value] : cell.second) {
        if (axis == at.axis) value = at.value;
      }
    }
    if (cell != own) setting.against = cells.at(cell);
  }
}

}  // namespace

std::vector<StudySetting> study_settings(const StudySpec& spec) {
  std::vector<StudySetting> methods;
  if (spec.methods.empty()) methods.emplace_back();
  for (const Overlay& method : spec.methods) methods.push_back({.method = method.name, .layers = {method}});
  const std::vector<StudyPoint> points = study_points(spec);
  std::vector<StudySetting> settings;
  for (const StudySetting& method : methods) {
    for (const StudyPoint& point : points) {
      StudySetting setting = method;
      for (std::size_t a = 0; a < spec.vary.size(); ++a) {
        const StudyValue& value = point.values[a];
        setting.values.emplace_back(spec.vary[a].name, value.text);
        if (value.overlay) setting.layers.push_back(*value.overlay);
        for (const std::string& path : spec.vary[a].paths) setting.set.push_back(path + "=" + value.text);
      }
      settings.push_back(std::move(setting));
    }
  }
  find_counterparts(spec, settings);
  return settings;
}

std::vector<std::string> shown_figures(const StudySpec& spec) {
  std::vector<std::string> figures = spec.metrics;
  const auto add = [&](const char* name) {
    if (std::find(figures.begin(), figures.end(), name) == figures.end()) figures.emplace_back(name);
  };
  if (spec.report == StudyReport::stability) {
    for (const char* name : {"stability.verdict", "stability.peak_energy_J", "stability.passivity_violation_J",
                             "stability.oscillation_amplitude_m", "stability.oscillation_frequency_Hz"}) {
      add(name);
    }
    if (spec.metrics.empty()) add("delivered.force.rms_error_N");
  } else if (spec.report == StudyReport::work_precision &&
             (!spec.metrics.empty() || spec.error != "delivered.force.rms_error_N")) {
    for (const char* name : {"delivered.force.rms_error_N", spec.error.c_str()}) add(name);
  }
  return figures;
}

std::vector<RunCase> study_cases(const StudySpec& spec, const Overrides& overrides) {
  for (const StudyAxis& axis : spec.vary) {
    for (const std::string& path : axis.paths) {
      if (overrides.duration_s && path == "duration") {
        throw InputError("--duration: the study varies duration; take it out of the study's `vary` first");
      }
      for (const std::string& set : overrides.set) {
        if (trimmed(std::string_view(set).substr(0, set.find('='))) != path) continue;
        throw InputError("--set " + set + ": the study varies " + path + "; take it out of the study's `vary` first");
      }
    }
  }
  const std::vector<StudySetting> settings = study_settings(spec);
  std::vector<RunCase> cases;
  for (const auto& graph : spec.graphs) {
    const std::size_t first = cases.size();
    for (const StudySetting& setting : settings) {
      RunCase c{graph, overrides, label(setting), first + setting.against, {}};
      // What the command line says comes last, so that it wins.
      c.overrides.layers = setting.layers;
      std::vector<std::string> set = spec.set;
      set.insert(set.end(), setting.set.begin(), setting.set.end());
      c.overrides.set.insert(c.overrides.set.begin(), set.begin(), set.end());
      if (!c.overrides.duration_s) c.overrides.duration_s = spec.duration_s;
      if (!spec.reference_over.empty() || !spec.reference_set.empty()) {
        c.reference = c.overrides;
        c.reference->top_layers = spec.reference_over;
        c.reference->top_set = spec.reference_set;
      }
      cases.push_back(std::move(c));
    }
  }
  return cases;
}

}  // namespace tactor
