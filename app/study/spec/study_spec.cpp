#include "app/study/spec/study_spec.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <string_view>

#include "app/study/spec/study_baseline.hpp"
#include "framework/core/control_characters.hpp"
#include "framework/core/input_file.hpp"
#include "framework/core/text.hpp"
#include "framework/core/units.hpp"
#include "framework/graph/format.hpp"
#include "framework/graph/merge.hpp"
#include "framework/graph/values.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

// Of every table of a study, beside what it varies.
constexpr std::array<std::string_view, 6> study_columns{"graph",     "method", "seed", "status", "spread_of_repeats",
                                                        "control_us"};
constexpr std::int64_t most_values = 10'000;  // of one axis, and of a hypercube

const std::vector<std::string>& study_keys() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> found;
    for (const StudyKey& key : keys_of_studies()) {
      if (key.name != "format") found.push_back(key.name);  // which load_study takes out first
    }
    return found;
  }();
  return names;
}

/// A scalar or a list or map of them as the YAML that --set takes.
std::string yaml_of(const Tree& tree) {
  const auto quoted = [](const std::string& text) {
    std::string out;
    for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
    return "'" + out + "'";
  };
  std::string text;
  switch (tree.kind) {
    case Tree::Kind::null:
      return "~";
    case Tree::Kind::scalar:
      return tree.quoted ? quoted(tree.text) : tree.text;
    case Tree::Kind::sequence:
      for (const Tree& item : tree.items) text += (text.empty() ? "" : ", ") + yaml_of(item);
      return "[" + text + "]";
    case Tree::Kind::map:
      for (const TreeEntry& entry : tree.entries)
        text += (text.empty() ? "" : ", ") + entry.key + ": " + yaml_of(entry.value);
      return "{" + text + "}";
  }
  return text;
}

std::vector<std::string> split_paths(const std::string& key) {
  std::vector<std::string> paths;
  for (std::size_t begin = 0; begin <= key.size();) {
    const std::size_t end = std::min(key.find(',', begin), key.size());
    paths.emplace_back(trimmed(std::string_view(key).substr(begin, end - begin)));
    begin = end + 1;
  }
  return paths;
}

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

/// Reads one study file into a spec.
class StudyReader {
 public:
  StudyReader(const fs::path& file, Diagnostics& diagnostics)
      : files_(fs::absolute(file).parent_path()), diagnostics_(diagnostics) {}

  void read(const Tree& tree, StudySpec& study) {
    check_keys(tree, "study", "key of a study", study_keys(), diagnostics_);
    if (const Tree* t = tree.value("title")) study.title = read_text(*t, "title", diagnostics_).value_or("");
    if (const Tree* t = tree.value("graphs")) {
      read_graphs(*t, study);
    } else {
      diagnostics_.error(tree.place, "study: expected the key graphs, found none");
    }
    if (const Tree* t = tree.value("methods")) study.methods = read_overlays(*t, "methods");
    if (const Tree* t = tree.value("set")) read_set(*t, "set", named_, study.set);
    if (const Tree* t = tree.value("vary")) read_vary(*t, study);
    if (const Tree* t = tree.value("design")) read_design(*t, study);
    read_baseline(tree.value("baseline"), study, diagnostics_);
    if (const Tree* t = tree.value("seeds")) study.seeds = integer(*t, "seeds", 1, most_values);
    if (const Tree* t = tree.value("first_seed")) {
      study.first_seed = read_seed(*t, "first_seed", diagnostics_).value_or(1);
    }
    if (const Tree* t = tree.value("duration")) {
      if (named_.count("duration") > 0) diagnostics_.error(t->place, "duration: named in `set` or `vary` too");
      const auto duration = read_duration(*t, "duration", true, diagnostics_);
      if (duration) study.duration = Patch{t->place, Assignment{"duration", yaml_of(*t)}};
    }
    if (const Tree* t = tree.value("run_timeout")) {
      const auto timeout = read_duration(*t, "run_timeout", true, diagnostics_);
      if (timeout) study.run_timeout_s = timeout->seconds();
    }
    if (const Tree* t = tree.value("reference")) read_reference(*t, study);
    if (const Tree* t = tree.value("metrics")) {
      study.metrics = read_texts(*t, "metrics");
      for (const Tree& item : t->items) study.metric_places.push_back(item.place);
    }
    if (const Tree* t = tree.value("report")) read_report(*t, study);
    if (study.report == StudyReport::work_precision) study.repeats = 3, study.warm_up = 1;
    if (const Tree* t = tree.value("timing")) read_timing(*t, study);
    if (study.report == StudyReport::stability) study.judge = JudgedPart::whole;
    if (const Tree* t = tree.value("judge")) {
      const std::string part = read_choice(*t, "judge", {"warm", "whole"}, diagnostics_).value_or("warm");
      study.judge = part == "whole" ? JudgedPart::whole : JudgedPart::warm;
    }
    check_together(tree, study);
  }

 private:
  std::int64_t integer(const Tree& tree, const std::string& path, std::int64_t min, std::int64_t max) {
    return read_integer(tree, path, min, max, diagnostics_).value_or(min);
  }

  void read_graphs(const Tree& tree, StudySpec& study) {
    if (!tree.is_sequence() || tree.items.empty()) {
      diagnostics_.error(tree.place, "graphs: expected a list of graph files, found " + describe(tree));
      return;
    }
    std::set<std::string> names;
    for (const Tree& item : tree.items) {
      const std::optional<fs::path> file = files_.find(item, "graphs", graph_files, diagnostics_);
      if (!file) continue;
      name_once(names, graph_name(*file), item.place, "graphs", "files");
      study.graphs.push_back(*file);
    }
  }

  /// Names go into scripts, charts and the lines of tables.
  void name_in_one_line(const std::string& name, const SourceLocation& place, const std::string& key) {
    if (!has_control_characters(name)) return;
    diagnostics_.error(place,
                       key + ": expected a name without control characters, found " + with_visible_controls(name));
  }

  // Rows of the table are told apart by it.
  void name_once(std::set<std::string>& names, const std::string& name, const SourceLocation& place,
                 const std::string& key, const std::string& what) {
    name_in_one_line(name, place, key);
    if (!names.insert(name).second) {
      diagnostics_.error(place, key + ": expected " + what + " of different names, found " + name + " again");
    }
  }

  std::optional<Overlay> read_overlay(const std::string& name, const Tree& tree, const std::string& path) {
    if (!tree.is_map()) {
      const std::optional<fs::path> file = files_.find(tree, path, method_files, diagnostics_);
      if (!file) return std::nullopt;
      return Overlay{name.empty() ? file->stem().string() : name, {tree.place, *file}};
    }
    if (tree.find("extends") != nullptr) {
      diagnostics_.error(tree.find("extends")->place, path +
                                                          ".extends: expected no such key in a map that is laid over a "
                                                          "graph; write it to a file of its own and name that");
      return std::nullopt;
    }
    return Overlay{name, {tree.place, tree}};
  }

  /// A list of files, and of maps of a name to a file or to what is laid over.
  std::vector<Overlay> read_overlays(const Tree& tree, const std::string& key) {
    std::vector<Overlay> found;
    if (!tree.is_sequence() || tree.items.empty()) {
      diagnostics_.error(tree.place, key + ": expected a list of graph files, found " + describe(tree));
      return found;
    }
    std::set<std::string> names;
    for (const Tree& item : tree.items) {
      std::optional<Overlay> one;
      if (item.is_map() && item.entries.size() == 1) {
        one = read_overlay(item.entries[0].key, item.entries[0].value, key + "." + item.entries[0].key);
      } else if (item.is_map()) {
        diagnostics_.error(item.place, key + ": expected a file or `name: {...}`, found a map of " +
                                           std::to_string(item.entries.size()) + " keys");
      } else {
        one = read_overlay("", item, key);
      }
      if (!one) continue;
      name_once(names, one->name, item.place, key, "files");
      found.push_back(std::move(*one));
    }
    return found;
  }

  // A value that another one replaces would stand in the table all the same.
  void name_path(std::set<std::string>& named, const std::string& path, const SourceLocation& place,
                 const std::string& key) {
    if (!named.insert(path).second) diagnostics_.error(place, key + "." + path + ": named twice in `set` and `vary`");
  }

  void read_set(const Tree& tree, const std::string& key, std::set<std::string>& named, Overrides& set) {
    if (!expect_map(tree, key, "a map of node.parameter to its value", diagnostics_)) return;
    for (const TreeEntry& entry : tree.entries) {
      for (const std::string& path : split_paths(entry.key)) {
        name_path(named, path, entry.value.place, key);
        set.push_back({entry.place, Assignment{path, yaml_of(entry.value)}});
      }
    }
  }

  void read_vary(const Tree& tree, StudySpec& study) {
    if (!expect_map(tree, "vary", "a map of node.parameter to a list of values", diagnostics_)) return;
    for (const TreeEntry& entry : tree.entries) {
      const std::string path = "vary." + entry.key;
      StudyAxis axis;
      if (entry.value.is_map() && entry.value.find("swap") != nullptr) {
        axis.name = entry.key;
        name_in_one_line(entry.key, entry.place, "vary");
        if (std::find(study_columns.begin(), study_columns.end(), entry.key) != study_columns.end()) {
          diagnostics_.error(entry.value.place, path + ": expected a name of your own for the swap; `" + entry.key +
                                                    "` is a column of every table of a study");
        }
        read_swap(entry.value, path, axis);
      } else {
        axis.paths = split_paths(entry.key);
        axis.name = joined(axis.paths);
        for (const std::string& one : axis.paths) name_path(named_, one, entry.value.place, "vary");
        if (entry.value.is_map()) {
          read_range(entry.value, path, axis);
        } else {
          read_list(entry.value, path, axis);
        }
      }
      if (!axis.values.empty()) study.vary.push_back(std::move(axis));
    }
  }

  void read_list(const Tree& tree, const std::string& path, StudyAxis& axis) {
    if (!tree.is_sequence() || tree.items.empty()) {
      diagnostics_.error(tree.place, path + ": expected a list of values, a range {from, to, count} or {swap}, found " +
                                         (tree.is_sequence() ? "an empty list" : describe(tree)));
      return;
    }
    for (const Tree& item : tree.items) add_value(axis, {yaml_of(item), {}, item.place}, path);
  }

  void add_value(StudyAxis& axis, StudyValue value, const std::string& path) {
    for (const StudyValue& other : axis.values) {
      if (other.text != value.text) continue;
      diagnostics_.error(value.place, path + ": expected different values, found " + value.text + " again");
    }
    axis.values.push_back(std::move(value));
  }

  void read_swap(const Tree& tree, const std::string& path, StudyAxis& axis) {
    check_keys(tree, path, "key of a swap", {"swap"}, diagnostics_);
    const Tree& swaps = *tree.value("swap");
    if (!swaps.is_map() || swaps.entries.empty()) {
      diagnostics_.error(swaps.place, path + ".swap: expected a map of names to what is laid over the graph, found " +
                                          (swaps.is_map() ? "an empty map" : describe(swaps)));
      return;
    }
    for (const TreeEntry& entry : swaps.entries) {
      name_in_one_line(entry.key, entry.place, path + ".swap");
      const std::optional<Overlay> overlay = read_overlay(entry.key, entry.value, path + ".swap." + entry.key);
      if (overlay) axis.values.push_back({entry.key, overlay->patch, entry.place});
    }
  }

  /// A number and the unit behind it, as written.
  std::optional<double> read_end(const Tree& range, const std::string& key, const std::string& path, std::string& unit,
                                 SourceLocation& place) {
    const Tree* tree = range.value(key);
    if (tree == nullptr) {
      diagnostics_.error(range.place, path + ": expected the key " + key + ", found none");
      return std::nullopt;
    }
    place = tree->place;
    double value = 0;
    const char* end = tree->text.data() + tree->text.size();
    const auto parsed = std::from_chars(tree->text.data(), end, value);
    if (tree->is_scalar() && parsed.ec == std::errc{} && std::isfinite(value)) {
      unit = trimmed(std::string_view(parsed.ptr, static_cast<std::size_t>(end - parsed.ptr)));
      if (unit.empty() || parse_unit(unit)) return value;
    }
    diagnostics_.error(tree->place,
                       path + "." + key + ": expected a number with or without unit, found " + describe(*tree));
    return std::nullopt;
  }

  void read_range(const Tree& tree, const std::string& path, StudyAxis& axis) {
    check_keys(tree, path, "key of a range", {"from", "to", "count", "scale", "whole"}, diagnostics_);
    StudyRange range;
    std::string unit_of_to;
    SourceLocation from_place, to_place;
    const std::optional<double> from = read_end(tree, "from", path, range.unit, from_place);
    const std::optional<double> to = read_end(tree, "to", path, unit_of_to, to_place);
    std::int64_t count = 0;
    if (const Tree* t = tree.value("count")) {
      count = read_integer(*t, path + ".count", 2, most_values, diagnostics_).value_or(0);
    } else {
      diagnostics_.error(tree.place, path + ": expected the key count, found none");
    }
    if (const Tree* t = tree.value("scale")) {
      range.log = read_choice(*t, path + ".scale", {"linear", "log"}, diagnostics_).value_or("linear") == "log";
    }
    if (const Tree* t = tree.value("whole")) {
      range.whole = read_boolean(*t, path + ".whole", diagnostics_).value_or(false);
    }
    if (!from || !to || count == 0) return;
    if (range.unit != unit_of_to) {
      diagnostics_.error(to_place, path + ".to: expected the unit of `from` (" +
                                       (range.unit.empty() ? "none" : range.unit) + "), found " +
                                       (unit_of_to.empty() ? "none" : unit_of_to));
      return;
    }
    if (!(*from < *to)) {
      diagnostics_.error(to_place, path + ".to: expected more than `from` (" + number_text(*from) + "), found " +
                                       number_text(*to) + ": the range is empty");
      return;
    }
    if (range.log && !(*from > 0)) {
      diagnostics_.error(from_place, path + ".from: expected a number above 0, found " + number_text(*from) +
                                         ": a logarithmic range cannot begin at, or go through, 0");
      return;
    }
    range.from = *from;
    range.to = *to;
    for (std::int64_t i = 0; i < count; ++i) {
      const std::string text = range.at(static_cast<double>(i) / static_cast<double>(count - 1));
      // Whole numbers close together fall onto each other.
      if (range.whole && !axis.values.empty() && axis.values.back().text == text) continue;
      add_value(axis, {text, {}, tree.place}, path);
    }
    axis.range = range;
  }

  void read_design(const Tree& tree, StudySpec& study) {
    const std::vector<std::string> designs{"grid", "one_at_a_time", "latin_hypercube"};
    std::string name;
    if (tree.is_map()) {
      check_keys(tree, "design", "design", designs, diagnostics_);
      if (tree.entries.size() != 1) {
        std::vector<std::string> found;
        for (const TreeEntry& entry : tree.entries) found.push_back(entry.key);
        diagnostics_.error(tree.place, "design: expected one of " + joined(designs) + ", found " +
                                           (found.empty() ? "none" : joined(found) + " together"));
        return;
      }
      name = tree.entries[0].key;
      if (name == "latin_hypercube") {
        const Tree& body = tree.entries[0].value;
        const std::string path = "design.latin_hypercube";
        if (!expect_map(body, path, "a map {samples, seed}", diagnostics_)) return;
        check_keys(body, path, "key of a hypercube", {"samples", "seed"}, diagnostics_);
        if (const Tree* t = body.value("samples")) {
          study.samples = integer(*t, path + ".samples", 1, most_values);
        } else {
          diagnostics_.error(body.place, path + ": expected the key samples, found none");
        }
        if (const Tree* t = body.value("seed"))
          study.design_seed = read_seed(*t, path + ".seed", diagnostics_).value_or(1);
      } else if (!tree.entries[0].value.is_null() &&
                 !(tree.entries[0].value.is_map() && tree.entries[0].value.entries.empty())) {
        diagnostics_.error(tree.entries[0].value.place,
                           "design." + name + ": expected nothing, found " + describe(tree.entries[0].value));
      }
    } else {
      name = read_choice(tree, "design", designs, diagnostics_).value_or("grid");
      if (name == "latin_hypercube") {
        diagnostics_.error(tree.place, "design: expected latin_hypercube: {samples: N}, found latin_hypercube alone");
      }
    }
    study.design = name == "one_at_a_time"     ? StudyDesign::one_at_a_time
                   : name == "latin_hypercube" ? StudyDesign::latin_hypercube
                                               : StudyDesign::grid;
  }

  void read_reference(const Tree& tree, StudySpec& study) {
    if (tree.is_scalar()) {
      study.without_reference = read_choice(tree, "reference", {"own", "none"}, diagnostics_).value_or("own") == "none";
      return;
    }
    if (!expect_map(tree, "reference", "own, none, a map {over, set} or {recording}", diagnostics_)) return;
    check_keys(tree, "reference", "key of a reference", {"over", "set", "recording"}, diagnostics_);
    if (const Tree* t = tree.value("recording")) {
      if (tree.entries.size() > 1) {
        diagnostics_.error(t->place,
                           "reference.recording: expected no other key beside it: a recording is used as the reference "
                           "directly, and nothing is run for it");
      }
      const std::string recording = read_text(*t, "reference.recording", diagnostics_).value_or("");
      if (!recording.empty()) study.reference_recording = (study.file.parent_path() / recording).lexically_normal();
      return;
    }
    if (const Tree* t = tree.value("over")) {
      for (Overlay& overlay : read_overlays(*t, "reference.over")) study.reference.push_back(std::move(overlay.patch));
    }
    std::set<std::string> named;
    if (const Tree* t = tree.value("set")) read_set(*t, "reference.set", named, study.reference);
  }

  std::vector<std::string> read_texts(const Tree& tree, const std::string& path) {
    std::vector<std::string> texts;
    if (!tree.is_sequence() || tree.items.empty()) {
      diagnostics_.error(tree.place, path + ": expected a list of names, found " + describe(tree));
      return texts;
    }
    for (const Tree& item : tree.items) {
      const std::string text = read_text(item, path, diagnostics_).value_or("");
      if (!text.empty() && std::find(texts.begin(), texts.end(), text) != texts.end()) {
        diagnostics_.error(item.place, path + ": expected different names, found " + text + " again");
      }
      texts.push_back(text);
    }
    return texts;
  }

  /// Methods of the study by their names.
  void read_bounds(const Tree& tree, StudySpec& study) {
    study.bounds = read_texts(tree, "report.bounds");
    std::vector<std::string> names;
    for (const Overlay& method : study.methods) names.push_back(method.name);
    for (std::size_t i = 0; i < study.bounds.size(); ++i) {
      const std::string& name = study.bounds[i];
      if (std::find(names.begin(), names.end(), name) != names.end()) continue;
      diagnostics_.error(tree.items[i].place,
                         "report.bounds: expected a method of the study, found " + name + did_you_mean(name, names));
    }
  }

  void read_report(const Tree& tree, StudySpec& study) {
    const std::vector<std::string> kinds{"table", "work_precision", "stability"};
    const Tree* kind = &tree;
    if (tree.is_map()) {
      check_keys(tree, "report", "key of a report", {"kind", "error", "time", "bounds", "worst", "record"},
                 diagnostics_);
      kind = tree.value("kind");
      if (kind == nullptr) {
        diagnostics_.error(tree.place, "report: expected the key kind, found none");
        return;
      }
      if (const Tree* t = tree.value("error")) {
        study.error = read_text(*t, "report.error", diagnostics_).value_or("");
        study.error_place = t->place;
      }
      if (const Tree* t = tree.value("time")) {
        const std::string time = read_choice(*t, "report.time", {"both", "run", "tick"}, diagnostics_).value_or("both");
        study.time = time == "run" ? StudyTime::run : time == "tick" ? StudyTime::tick : StudyTime::both;
      }
      if (const Tree* t = tree.value("bounds")) read_bounds(*t, study);
      if (const Tree* t = tree.value("worst")) study.worst = integer(*t, "report.worst", 0, 100);
      if (const Tree* t = tree.value("record")) {
        study.record = read_texts(*t, "report.record");
        for (const Tree& item : t->items) study.record_places.push_back(item.place);
      }
    }
    const std::string name = read_choice(*kind, "report", kinds, diagnostics_).value_or("table");
    study.report_place = kind->place;
    study.report = name == "work_precision" ? StudyReport::work_precision
                   : name == "stability"    ? StudyReport::stability
                                            : StudyReport::table;
    const auto only_for = [&](const char* key, StudyReport report, const char* of) {
      if (!tree.is_map() || tree.find(key) == nullptr || study.report == report) return;
      diagnostics_.error(tree.find(key)->place, std::string("report.") + key + ": expected with kind: " + of +
                                                    " alone, found with kind: " + name);
    };
    only_for("error", StudyReport::work_precision, "work_precision");
    only_for("time", StudyReport::work_precision, "work_precision");
    only_for("bounds", StudyReport::work_precision, "work_precision");
    only_for("worst", StudyReport::stability, "stability");
    only_for("record", StudyReport::stability, "stability");
  }

  void read_timing(const Tree& tree, StudySpec& study) {
    if (!expect_map(tree, "timing", "a map {repeats, warm_up}", diagnostics_)) return;
    check_keys(tree, "timing", "key of timing", {"repeats", "warm_up"}, diagnostics_);
    if (const Tree* t = tree.value("repeats")) study.repeats = integer(*t, "timing.repeats", 1, most_repeats);
    if (const Tree* t = tree.value("warm_up")) study.warm_up = integer(*t, "timing.warm_up", 0, 1000);
  }

  /// What only two keys together show.
  void check_together(const Tree& tree, const StudySpec& study) {
    const auto place_of = [&](const char* key) {
      const Tree* value = tree.value(key);
      return value != nullptr ? value->place : tree.place;
    };
    if (study.design == StudyDesign::latin_hypercube && study.vary.empty()) {
      diagnostics_.error(place_of("design"),
                         "design: latin_hypercube: expected parameters under `vary` to sample, found none");
    }
    if (study.report == StudyReport::work_precision && study.without_reference) {
      diagnostics_.error(
          place_of("reference"),
          "reference: none: expected a report other than work_precision, because its errors need a reference run");
    }
    if (study.report != StudyReport::stability) return;
    if (study.vary.size() != 2) {
      diagnostics_.error(place_of("report"),
                         "report: stability: expected two parameters under `vary`, the axes of the map, found " +
                             std::to_string(study.vary.size()));
    } else if (study.design != StudyDesign::grid) {
      diagnostics_.error(place_of("design"),
                         "design: expected grid, found another: a map of stability needs every cell");
    }
  }

  FileFinder files_;
  Diagnostics& diagnostics_;
  std::set<std::string> named_;
};

/// What the study says under `short` over the rest: `vary` and `set` by key, everything else replaced.
Tree shortened(const Tree& tree) {
  Tree out = tree;
  std::erase_if(out.entries, [](const TreeEntry& e) { return e.key == "short"; });
  const Tree* shorter = tree.value("short");
  if (shorter == nullptr) return out;
  for (const TreeEntry& entry : shorter->entries) {
    TreeEntry* mine = out.find(entry.key);
    if (mine == nullptr) {
      out.entries.push_back(entry);
    } else if ((entry.key == "vary" || entry.key == "set") && mine->value.is_map() && entry.value.is_map()) {
      for (const TreeEntry& one : entry.value.entries) {
        if (TreeEntry* there = mine->value.find(one.key)) {
          *there = one;
        } else {
          mine->value.entries.push_back(one);
        }
      }
    } else {
      *mine = entry;
    }
  }
  return out;
}

StudySpec read_study(const fs::path& file, const Tree& tree, Diagnostics& diagnostics) {
  StudySpec study;
  study.name = file.stem().string();
  if (has_control_characters(study.name)) {
    diagnostics.error({with_visible_controls(file.string()), 0, 0},
                      "expected a name of the file without control characters, since it names the study; rename it");
  }
  study.file = fs::absolute(file).lexically_normal();
  StudyReader(file, diagnostics).read(tree, study);
  return study;
}

}  // namespace

StudySpec load_study(const fs::path& file, bool use_short) {
  Diagnostics diagnostics;
  std::optional<Tree> tree = read_yaml(file, file.string(), graph_file, diagnostics);
  diagnostics.throw_if_any();
  take_format(*tree, diagnostics);
  const Tree* shorter = tree->value("short");
  if (shorter != nullptr && expect_map(*shorter, "short", "a map of keys of a study", diagnostics)) {
    std::vector<std::string> keys = study_keys();
    std::erase(keys, "short");
    check_keys(*shorter, "short", "key of a study", keys, diagnostics);
  }
  if (use_short && shorter == nullptr) {
    diagnostics.error(tree->place, "study: expected the key short, which --short asks for, found none");
  }
  diagnostics.throw_if_any();
  StudySpec full = read_study(file, *tree, diagnostics);
  diagnostics.throw_if_any();
  StudySpec study = std::move(full);
  if (shorter != nullptr) {
    StudySpec brief = read_study(file, shortened(*tree), diagnostics);
    diagnostics.throw_if_any();
    if (use_short) study = std::move(brief);
  }
  study.is_short = use_short;
  study.text = read_input_file(file, max_yaml_bytes);
  return study;
}

}  // namespace tactor
