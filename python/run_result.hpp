// Whole runs for Python: what `tactor run` does, in this process.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <utility>
#include <vector>

#include "app/run/run_metrics.hpp"

namespace tactor::python {

/// (name, value, unit, better, doc) of each metric.
pybind11::list metric_list(const std::vector<std::pair<std::string, double>>& metrics, const MetricMap& declared);

/// Adds `run` and the class RunResult.
void bind_run(pybind11::module_& module);

}  // namespace tactor::python
