// What the rows of a study are compared with: the key `baseline`, and what holds without it.
#pragma once

#include "app/study/spec/study_spec.hpp"
#include "framework/yaml/diagnostics.hpp"
#include "framework/yaml/yaml_tree.hpp"

namespace tactor {

/// Sets `study.baseline` from the study's key, null where it has none; methods, axes and design have been read. Adds an
/// error where it names no axis or value of the study, or where a row would have no such counterpart.
void read_baseline(const Tree* tree, StudySpec& study, Diagnostics& diagnostics);

}  // namespace tactor
