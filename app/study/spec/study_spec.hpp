// A study file: which graphs are run with which methods, values and seeds, against what, and what is told of them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "framework/graph/spec.hpp"

namespace tactor {

/// A file or a map that is laid over a graph, by its name in tables.
struct Overlay {
  std::string name;
  Patch patch;
};

/// One value of an axis.
struct StudyValue {
  std::string text;           ///< YAML, as after --set path=; of a swap its name
  std::optional<Patch> swap;  ///< of a swap: what is laid over the graph
  SourceLocation place;       ///< in the study file
};

/// A range of numbers, which a design may draw from anywhere.
struct StudyRange {
  double from = 0, to = 0;  ///< in `unit`
  std::string unit;         ///< as written behind both numbers, or empty
  bool log = false;         ///< equal ratios instead of equal steps; both ends are above zero
  bool whole = false;       ///< whole numbers
  /// The value at the share q in [0, 1] of the way, as YAML.
  [[nodiscard]] std::string at(double q) const;
};

/// Values that are tried one after the other.
struct StudyAxis {
  std::string name;                 ///< heads a column: the paths, or the name of a swap
  std::vector<std::string> paths;   ///< `node.parameter`; all of them get the same value; none for a swap
  std::vector<StudyValue> values;   ///< not empty, all different
  std::optional<StudyRange> range;  ///< where the values were made from one
  [[nodiscard]] bool swaps() const { return paths.empty(); }
};

/// A value of an axis, by the names that tables show; the axis `method` is that of the study's methods.
struct AxisValue {
  std::string axis, value;
  bool operator==(const AxisValue&) const = default;
};

/// Which combinations of values are run.
enum class StudyDesign : std::uint8_t {
  grid,             ///< every combination, the last axis fastest
  one_at_a_time,    ///< the first value of every axis, then each axis' others with the rest at their first
  latin_hypercube,  ///< `samples` combinations; each axis is cut into that many slices of which each is met once
};

/// What is made of the runs.
enum class StudyReport : std::uint8_t { table, work_precision, stability };

/// Which run time a work-precision diagram shows: of the whole run, of the methods alone, or one diagram of each.
enum class StudyTime : std::uint8_t { both, run, tick };

/// Which part of its runs a study judges.
enum class JudgedPart : std::uint8_t {
  warm,   ///< one interval of each graph, in which the nodes of all its configurations are warm
  whole,  ///< each run from its start
};

/// A checked study file. Paths of files are absolute.
struct StudySpec {
  std::string name;   ///< the file's stem
  std::string title;  ///< one line of prose, or empty
  std::filesystem::path file;
  std::string text;       ///< of the file, byte by byte
  bool is_short = false;  ///< the settings under `short` were laid over the rest
  std::vector<std::filesystem::path> graphs;
  std::vector<Overlay> methods;  ///< laid over every graph, one at a time; none: the graphs as they are
  Overrides set;                 ///< values of every run
  std::vector<StudyAxis> vary;
  StudyDesign design = StudyDesign::grid;
  /// Every row is compared with the row that has these values and is like it on all other axes. Empty: against none.
  /// The first method; without methods the first value of the first axis, with one_at_a_time of all; unless the study
  /// says otherwise.
  std::vector<AxisValue> baseline;
  std::int64_t samples = 0;       ///< of a Latin hypercube
  std::uint64_t design_seed = 1;  ///< of its draws
  std::int64_t seeds = 20;
  std::uint64_t first_seed = 1001;
  std::optional<Patch> duration;        ///< of every run; absent: the graphs' own
  std::optional<double> run_timeout_s;  ///< of real time, for every run and reference run; absent: none
  /// Laid over each graph to make its reference run; empty: the graph's under test own reference run.
  Overrides reference;
  /// Of recordings that judge the runs instead of reference runs, an absolute path that may have `{graph}` and `{seed}`
  /// in it (see recording_of); empty: reference runs do.
  std::string reference_recording;
  JudgedPart judge = JudgedPart::warm;        ///< `whole` by default where the report is a map of stability
  bool without_reference = false;             ///< no reference run is made, and no metric that needs one
  std::vector<std::string> metrics;           ///< metrics that tables show; none: the usual ones
  std::vector<SourceLocation> metric_places;  ///< of each
  StudyReport report = StudyReport::table;
  SourceLocation report_place;
  std::string error = "delivered.force.rms_error_N";  ///< the metric that work-precision diagrams show as error
  std::optional<SourceLocation> error_place;          ///< absent: the study does not name it
  StudyTime time = StudyTime::both;                   ///< the run times that they show
  std::vector<std::string> bounds;  ///< methods that tell what no method can be asked for: not on the Pareto front
  std::int64_t worst = 3;           ///< cells of a map of stability that are run anew with a recording
  std::vector<std::string> record;  ///< outputs that are recorded there; none: motion and force
  std::vector<SourceLocation> record_places;  ///< of each
  std::int64_t repeats = 1;                   ///< of every run, for its run time
  std::int64_t warm_up = 0;                   ///< runs before these whose run time does not count
};

/// Of a run for its run time, wherever they are asked for.
inline constexpr std::int64_t most_repeats = 100;

/// A key of a study file.
struct StudyKey {
  std::string name;
  std::string value;          ///< what it takes: `list of files`
  std::string unit;           ///< empty: none
  std::string default_value;  ///< empty: none, or told by `doc`
  std::string doc;            ///< one line
};

/// All that a study file may have: its reader takes no others.
const std::vector<StudyKey>& keys_of_studies();

/// One combination: an index into each axis' values, or for drawn values the values themselves.
struct StudyPoint {
  std::vector<StudyValue> values;  ///< one an axis
};

/// Reads a study; `use_short` lays what it says under `short` over the rest. Throws GraphError with every error of the
/// file itself, those under `short` included; the graphs are not looked into.
StudySpec load_study(const std::filesystem::path& file, bool use_short = false);

/// The combinations of the study's design, in order; one without values where nothing varies.
std::vector<StudyPoint> study_points(const StudySpec& spec);

/// What the rows are compared with, in words: `method hold with the same tool.stiffness`; empty for nothing.
std::string baseline_text(const StudySpec& spec);

}  // namespace tactor
