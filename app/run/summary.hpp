// What a run leaves behind as metrics: summary.json, and the table on the terminal.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "app/run/run.hpp"

namespace tactor {

/// The run as JSON: dotted metric names become nested objects; a metric that is not a number becomes null.
nlohmann::ordered_json to_json(const RunResult& result);

/// Every metric, what each node took, and what was chosen and left out: what `tactor run --all` prints, in so many
/// columns.
std::string summary_table(const RunResult& result, std::size_t columns);

/// What is to be said where steps of dynamics could not be solved as they should, else empty.
std::string dynamics_warning(const RunResult& result);

/// A number for people: three significant digits, no exponent where none is needed, `-` for NaN.
std::string pretty(double value);

/// A number for programs: null where it is not finite, which JSON cannot say.
nlohmann::ordered_json number_json(double value);

}  // namespace tactor
