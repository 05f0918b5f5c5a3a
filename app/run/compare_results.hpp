// Two results of one graph, to the byte: recordings by their messages, summaries by all that is not measured.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "framework/record/recorder.hpp"

namespace tactor {

struct ResultComparison {
  std::size_t data_sets = 0, equal_data_sets = 0;
  std::size_t metrics = 0, equal_metrics = 0;
  std::vector<std::string> differences;  ///< a line each; of a data set its first one, with row and time

  [[nodiscard]] bool is_equal() const { return differences.empty(); }
};

/// Compares every stream of `was` with that of the same name in `now`: the stamps and the fields of all messages, by
/// their bytes. Throws InputError where a recording is damaged.
void compare_recordings(RecordingReader& was, RecordingReader& now, ResultComparison& found);

/// Compares everything in two summaries of runs but names, run times, memory and provenance.
void compare_summaries(const nlohmann::ordered_json& was, const nlohmann::ordered_json& now, ResultComparison& found);

}  // namespace tactor
