#include "app/study/table/study_csv.hpp"

#include <fmt/format.h>

#include "app/csv_cell.hpp"

namespace tactor {

namespace {

/// A line a run: what it is, then a cell for each of the columns.
template <class Cells>
std::string csv_of(const Study& study, std::vector<std::string> more_head, const Cells& cells_of) {
  std::vector<std::string> head{"graph", "method"};
  for (const StudyAxis& axis : study.spec.vary) head.push_back(csv_cell(axis.name));
  head.emplace_back("seed");
  for (std::string& name : more_head) head.push_back(std::move(name));
  std::string out = fmt::format("{}\n", fmt::join(head, ","));
  const Comparison& comparison = study.comparison;
  for (std::size_t row = 0; row < comparison.rows.size(); ++row) {
    for (std::size_t s = 0; s < comparison.seeds.size(); ++s) {
      std::vector<std::string> cells{csv_cell(comparison.rows[row].graph), csv_cell(study.configuration(row).method)};
      for (const auto& [path, value] : study.configuration(row).values) cells.push_back(csv_cell(value));
      cells.push_back(std::to_string(comparison.seeds[s]));
      cells_of(comparison.rows[row], s, cells);
      out += fmt::format("{}\n", fmt::join(cells, ","));
    }
  }
  return out;
}

void add_values(const Study& study, const CompareRow& row, std::size_t seed, bool run_times,
                std::vector<std::string>& cells) {
  for (std::size_t c = 0; c < study.comparison.columns.size(); ++c) {
    if (study.comparison.columns[c].run_time == run_times) cells.push_back(csv_cell(row.values[c][seed]));
  }
}

std::vector<std::string> metrics_of(const Study& study, bool run_times) {
  std::vector<std::string> names;
  for (const Column& column : study.comparison.columns) {
    if (column.run_time == run_times) names.push_back(column.metric);
  }
  return names;
}

}  // namespace

std::string study_csv(const Study& study) {
  std::vector<std::string> head{"status"};
  for (std::string& name : metrics_of(study, false)) head.push_back(std::move(name));
  return csv_of(study, std::move(head), [&](const CompareRow& row, std::size_t s, std::vector<std::string>& cells) {
    cells.push_back(word_of(row.status[s]));
    add_values(study, row, s, false, cells);
  });
}

std::string run_times_csv(const Study& study) {
  std::vector<std::string> head = metrics_of(study, true);
  head.insert(head.end(), {"spread_of_repeats", "control_us"});
  return csv_of(study, std::move(head), [&](const CompareRow& row, std::size_t s, std::vector<std::string>& cells) {
    add_values(study, row, s, true, cells);
    cells.push_back(csv_cell(row.spread[s]));
    cells.push_back(csv_cell(row.control_us[s]));
  });
}

}  // namespace tactor
