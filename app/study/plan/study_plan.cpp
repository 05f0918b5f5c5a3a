#include "app/study/plan/study_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace tactor {

std::string label(const StudyConfiguration& configuration) {
  std::vector<std::string> parts;
  if (!configuration.method.empty()) parts.push_back(configuration.method);
  for (const auto& [path, value] : configuration.values) parts.push_back(fmt::format("{}={}", path, value));
  return parts.empty() ? "as it is" : fmt::format("{}", fmt::join(parts, " "));
}

namespace {

/// Sets of every configuration the one that has the values of the baseline and is otherwise like it.
void find_counterparts(const StudySpec& spec, std::vector<StudyConfiguration>& configurations) {
  using Cell = std::pair<std::string, std::vector<std::pair<std::string, std::string>>>;
  std::map<Cell, std::size_t> cells;
  for (std::size_t s = 0; s < configurations.size(); ++s) {
    cells.emplace(Cell{configurations[s].method, configurations[s].values}, s);
    configurations[s].against = s;
  }
  for (StudyConfiguration& configuration : configurations) {
    const Cell own{configuration.method, configuration.values};
    Cell cell = own;
    for (const AxisValue& at : spec.baseline) {
      if (at.axis == "method") cell.first = at.value;
      for (auto& [axis, value] : cell.second) {
        if (axis == at.axis) value = at.value;
      }
    }
    if (cell != own) configuration.against = cells.at(cell);
  }
}

}  // namespace

std::vector<StudyConfiguration> study_configurations(const StudySpec& spec) {
  std::vector<StudyConfiguration> methods;
  if (spec.methods.empty()) methods.emplace_back();
  for (const Overlay& method : spec.methods) methods.push_back({.method = method.name, .files = {method.patch}});
  const std::vector<StudyPoint> points = study_points(spec);
  std::vector<StudyConfiguration> configurations;
  for (const StudyConfiguration& method : methods) {
    for (const StudyPoint& point : points) {
      StudyConfiguration configuration = method;
      for (std::size_t a = 0; a < spec.vary.size(); ++a) {
        const StudyValue& value = point.values[a];
        configuration.values.emplace_back(spec.vary[a].name, value.text);
        if (value.swap) configuration.files.push_back(*value.swap);
        for (const std::string& path : spec.vary[a].paths) {
          configuration.set.push_back({value.place, Assignment{path, value.text}});
        }
      }
      configurations.push_back(std::move(configuration));
    }
  }
  find_counterparts(spec, configurations);
  return configurations;
}

std::vector<std::string> shown_metrics(const StudySpec& spec) {
  std::vector<std::string> metrics = spec.metrics;
  const auto add = [&](const char* name) {
    if (std::find(metrics.begin(), metrics.end(), name) == metrics.end()) metrics.emplace_back(name);
  };
  if (spec.report == StudyReport::stability) {
    for (const char* name :
         {"stability.verdict", "stability.peak_energy_J", "stability.passivity_violation_J",
          "stability.oscillation_amplitude_m", "stability.oscillation_frequency_Hz", "stability.passive"}) {
      add(name);
    }
    if (spec.metrics.empty()) add("delivered.force.rms_error_N");
  } else if (spec.report == StudyReport::work_precision &&
             (!spec.metrics.empty() || spec.error != "delivered.force.rms_error_N")) {
    for (const char* name : {"delivered.force.rms_error_N", spec.error.c_str()}) add(name);
  }
  return metrics;
}

Overrides overrides_of(const StudySpec& spec, const Overrides& files, const Overrides& set,
                       const Overrides& command_line) {
  Overrides overrides = files;
  overrides.insert(overrides.end(), spec.set.begin(), spec.set.end());
  overrides.insert(overrides.end(), set.begin(), set.end());
  if (spec.duration) overrides.push_back(*spec.duration);
  overrides.insert(overrides.end(), command_line.begin(), command_line.end());
  return overrides;
}

void refuse_seed(const Overrides& command_line) {
  if (const Patch* seed = find_assignment(command_line, "seed")) {
    throw InputError(seed->place.file + ": expected --first-seed and --seeds, which choose the seeds of these runs");
  }
}

std::vector<RunCase> study_cases(const StudySpec& spec, const Overrides& command_line) {
  refuse_seed(command_line);
  for (const StudyAxis& axis : spec.vary) {
    for (const std::string& path : axis.paths) {
      if (const Patch* patch = find_assignment(command_line, path)) {
        throw InputError(patch->place.file + ": the study varies " + path +
                         "; take it out of the study's `vary` first");
      }
    }
  }
  const std::vector<StudyConfiguration> configurations = study_configurations(spec);
  std::vector<RunCase> cases;
  for (const auto& graph : spec.graphs) {
    const std::size_t first = cases.size();
    for (const StudyConfiguration& configuration : configurations) {
      RunCase c{.graph = graph,
                .overrides = overrides_of(spec, configuration.files, configuration.set, command_line),
                .configuration = label(configuration),
                .against = first + configuration.against,
                .reference_recording = spec.reference_recording,
                .group = first / configurations.size()};
      Overrides method = configuration.files;
      method.resize(spec.methods.empty() ? 0 : 1);
      c.unvaried = overrides_of(spec, method, {}, command_line);
      if (!spec.reference.empty()) {
        c.reference = c.overrides;
        c.reference->insert(c.reference->end(), spec.reference.begin(), spec.reference.end());
      }
      cases.push_back(std::move(c));
    }
  }
  return cases;
}

}  // namespace tactor
