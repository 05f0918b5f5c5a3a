// The metrics that a study asks for, against those that its runs report.
#pragma once

#include "app/run/run_metrics.hpp"
#include "app/study/spec/study_spec.hpp"

namespace tactor {

class Registry;

/// Throws GraphError with every metric that the study names, or that its report needs, and that none of its runs
/// reports, and with an error of a work-precision report of which neither less nor more is better. `metrics`: those of
/// all its runs, and the run times that tables show. Loads all node libraries of the registry where it throws, to say
/// which type of node would report the metric.
void check_metrics(const StudySpec& spec, const RunMetrics& metrics, Registry& registry);

}  // namespace tactor
