#include "app/study/table/study_export.hpp"

#include "framework/record/recorder.hpp"

namespace tactor {

namespace {

TableFile table_of(const Study& study) {
  const Comparison& comparison = study.comparison;
  TableFile table{{{"study", study.spec.name},
                   {"title", study.spec.title},
                   {"tactor", TACTOR_VERSION},
                   {"provenance", provenance_text(comparison.provenance)}},
                  {}};
  TableColumn graph{"graph", {}, {}}, method{"method", {}, {}}, status{"status", {}, {}}, message{"message", {}, {}};
  TableColumn seed{"seed", {}, {}}, spread{"spread_of_repeats", {}, {}}, control{"control_us", {}, {}};
  std::vector<TableColumn> varied, metrics;
  for (const StudyAxis& axis : study.spec.vary) varied.push_back({axis.name, {}, {}});
  for (const Column& column : comparison.columns) {
    metrics.push_back({column.metric, {}, {}});
    const MetricInfo* info = comparison.info(column.metric);
    if (info == nullptr) continue;
    metrics.back().attributes = {{"unit", info->unit}, {"better", std::string(name_of(info->better))}};
  }
  for (std::size_t row = 0; row < comparison.rows.size(); ++row) {
    const CompareRow& one = comparison.rows[row];
    for (std::size_t s = 0; s < comparison.seeds.size(); ++s) {
      graph.texts.push_back(one.graph);
      method.texts.push_back(study.configuration(row).method);
      for (std::size_t a = 0; a < varied.size(); ++a)
        varied[a].texts.push_back(study.configuration(row).values[a].second);
      seed.texts.push_back(std::to_string(comparison.seeds[s]));  // it may be larger than a double holds
      status.texts.push_back(word_of(one.status[s]));
      message.texts.push_back(one.message[s]);
      for (std::size_t c = 0; c < metrics.size(); ++c) metrics[c].numbers.push_back(one.values[c][s]);
      spread.numbers.push_back(one.spread[s]);
      control.numbers.push_back(one.control_us[s]);
    }
  }
  table.columns = {graph, method, seed, status, message};
  table.columns.insert(table.columns.begin() + 2, varied.begin(), varied.end());
  table.columns.insert(table.columns.end(), metrics.begin(), metrics.end());
  table.columns.push_back(spread);
  table.columns.push_back(control);
  return table;
}

}  // namespace

void write_study_hdf5(const std::filesystem::path& path, const Study& study) {
  const RecordLibrary* library = nullptr;
  try {
    library = &load_record_library();
  } catch (const InputError&) {
    return;  // this build has no HDF5; study.csv has the same
  }
  library->write_table(path, table_of(study));
}

}  // namespace tactor
