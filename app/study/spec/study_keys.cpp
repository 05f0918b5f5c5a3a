// The keys of study files.
#include "app/study/spec/study_spec.hpp"

namespace tactor {

const std::vector<StudyKey>& keys_of_studies() {
  static const std::vector<StudyKey> keys{
      {"format", "2", "", "", "of this file; `tactor migrate` rewrites older ones"},
      {"title", "text", "", "", "one line of prose"},
      {"graphs", "list of files", "", "", "the graphs that run; required"},
      {"methods", "list of files or `name: {...}`", "", "", "each is laid over every graph, one at a time"},
      {"set", "map of `node.parameter` to a value", "", "", "holds for every run"},
      {"vary", "map of `node.parameter` to a list, a range or a swap", "", "", "the axes of the study"},
      {"design", "grid, one_at_a_time or `latin_hypercube: {samples, seed}`", "", "grid", "which combinations run"},
      {"seeds", "integer", "", "20", "number of seeds"},
      {"first_seed", "integer", "", "1001", "the first of them"},
      {"duration", "number", "s", "", "of every run; each graph's where it is absent"},
      {"reference", "own, none, `{over, set}` or `{recording: FILE}`", "", "own", "what errors are measured against"},
      {"run_timeout", "number", "s", "", "real time after which a run has failed; absent: no limit"},
      {"metrics", "list of metrics", "", "", "the metrics that the tables show"},
      {"report", "table, work_precision, stability, or a map with `kind`", "", "table", "what is made of the runs"},
      {"timing", "`{repeats, warm_up}`", "", "",
       "runs whose median run time counts, and runs before them that do not; 1 and 0, or 3 and 1 where the report is "
       "work_precision"},
      {"short", "map of these keys", "", "", "laid over the rest by `--short`"},
      {"baseline", "map of an axis to a value", "", "",
       "what every row is compared with; the first method, or else the first value of the first axis, where it is "
       "absent"},
      {"judge", "warm or whole", "", "",
       "which part of the runs is judged; warm, or whole where the report is stability"}};
  return keys;
}

}  // namespace tactor
