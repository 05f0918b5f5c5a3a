#include "app/study/spec/study_baseline.hpp"

#include <algorithm>

#include "framework/graph/merge.hpp"
#include "framework/yaml/yaml_values.hpp"

namespace tactor {

namespace {

constexpr const char* methods_axis = "method";

/// An axis of the study with the names of its values, in order.
struct Axis {
  std::string name;
  std::vector<std::string> values;
};

std::vector<Axis> axes_of(const StudySpec& study) {
  std::vector<Axis> axes;
  if (!study.methods.empty()) {
    axes.push_back({methods_axis, {}});
    for (const Overlay& method : study.methods) axes.back().values.push_back(method.name);
  }
  for (const StudyAxis& axis : study.vary) {
    axes.push_back({axis.name, {}});
    for (const StudyValue& value : axis.values) axes.back().values.push_back(value.text);
  }
  return axes;
}

std::string names_of(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

/// The first value of the first axis on which every row has a counterpart; none where there is no such axis.
std::vector<AxisValue> usual_baseline(const StudySpec& study, const std::vector<Axis>& axes) {
  std::vector<AxisValue> baseline;
  if (axes.empty()) return baseline;
  if (axes.front().name == methods_axis && !study.methods.empty()) return {{methods_axis, axes.front().values.front()}};
  switch (study.design) {
    case StudyDesign::grid:
      return {{axes.front().name, axes.front().values.front()}};
    case StudyDesign::one_at_a_time:
      // Each row differs in one axis alone from the row of all first values.
      for (const Axis& axis : axes) baseline.push_back({axis.name, axis.values.front()});
      return baseline;
    case StudyDesign::latin_hypercube:
      return {};
  }
  TACTOR_DEMAND(false);
}

}  // namespace

void read_baseline(const Tree* tree, StudySpec& study, Diagnostics& diagnostics) {
  const std::vector<Axis> axes = axes_of(study);
  if (tree == nullptr) {
    study.baseline = usual_baseline(study, axes);
    return;
  }
  std::vector<std::string> names;
  for (const Axis& axis : axes) names.push_back(axis.name);
  if (!expect_map(*tree, "baseline", "a map of an axis of the study (" + names_of(names) + ") to one of its values",
                  diagnostics)) {
    return;
  }
  if (tree->entries.empty()) {
    diagnostics.error(tree->place, "baseline: expected an axis of the study (" + names_of(names) + "), found none");
  }
  for (const TreeEntry& entry : tree->entries) {
    const std::string path = "baseline." + entry.key;
    const auto axis = std::find_if(axes.begin(), axes.end(), [&](const Axis& a) { return a.name == entry.key; });
    if (axis == axes.end()) {
      diagnostics.error(entry.place, path + ": expected an axis of the study (" + names_of(names) + "), found " +
                                         entry.key + did_you_mean(entry.key, names));
      continue;
    }
    const std::string value = entry.value.is_scalar() ? entry.value.text : std::string();
    if (std::find(axis->values.begin(), axis->values.end(), value) == axis->values.end()) {
      diagnostics.error(entry.value.place, path + ": expected one of the values of this axis (" +
                                               names_of(axis->values) + "), found " + describe(entry.value));
      continue;
    }
    const bool of_methods = entry.key == methods_axis;
    if (study.design == StudyDesign::latin_hypercube && !of_methods) {
      diagnostics.error(
          entry.place,
          path + ": expected method, because the samples of a hypercube have no counterparts on an axis, found " +
              entry.key);
    } else if (study.design == StudyDesign::one_at_a_time && !of_methods && value != axis->values.front()) {
      diagnostics.error(entry.value.place, path + ": expected the first value of the axis, " + axis->values.front() +
                                               ", which every row has a counterpart at with design: one_at_a_time, "
                                               "found " +
                                               value);
    }
    study.baseline.push_back({entry.key, value});
  }
}

std::string baseline_text(const StudySpec& spec) {
  if (spec.baseline.empty()) return {};
  std::string text;
  for (const AxisValue& at : spec.baseline) text += (text.empty() ? "" : ", ") + at.axis + " " + at.value;
  std::vector<std::string> others;
  for (const Axis& axis : axes_of(spec)) {
    const bool fixed = std::any_of(spec.baseline.begin(), spec.baseline.end(),
                                   [&](const AxisValue& at) { return at.axis == axis.name; });
    if (!fixed) others.push_back(axis.name);
  }
  return others.empty() ? text : text + " with the same " + names_of(others);
}

}  // namespace tactor
