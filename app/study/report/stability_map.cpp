#include "app/study/report/stability_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "app/output.hpp"
#include "app/report/chart.hpp"
#include "app/report/figure.hpp"
#include "app/report/html_page.hpp"
#include "app/report/run_report.hpp"
#include "app/run/recorded_reference.hpp"
#include "app/run/summary.hpp"
#include "app/study/report/report_parts.hpp"
#include "app/study/table/warnings.hpp"
#include "app/study/table/where.hpp"
#include "framework/core/plain_name.hpp"
#include "framework/core/user_folders.hpp"
#include "framework/graph/plan.hpp"
#include "framework/graph/text_table.hpp"
#include "framework/node/registry.hpp"
#include "framework/record/recorder.hpp"

namespace tactor {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

/// By the number of the verdict. The colours grow darker from stable to the worst.
const std::vector<CellKind>& kinds() {
  static const std::vector<CellKind> all{{"stable", "#dcebd5", "s"},         {"limit cycle", "#f0b040", "L"},
                                         {"pushed through", "#7fb2e0", "P"}, {"energy growth", "#d08ab8", "E"},
                                         {"not finite", "#909090", "N"},     {"refused, or failed", "#ffffff", "x"}};
  return all;
}

int number(StabilityVerdict verdict) {
  return static_cast<int>(verdict);
}

std::string reason_of(const StabilityCell& cell) {
  switch (cell.verdict) {
    case StabilityVerdict::stable:
    case StabilityVerdict::refused:
      return cell.reason;
    case StabilityVerdict::limit_cycle:
      return fmt::format("at rest it oscillates by {} mm to each side at {} Hz", pretty(1e3 * cell.amplitude_m),
                         pretty(cell.frequency_Hz));
    case StabilityVerdict::pushed_through:
      return "it rests where the static balance does not allow it";
    case StabilityVerdict::energy:
      return fmt::format("the hand got {} mJ more than it and the tool's weight had given",
                         pretty(1e3 * cell.passivity_violation_J));
    case StabilityVerdict::not_finite:
      return "a signal became NaN or infinite";
  }
  return {};
}

StabilityCell cell_of(const CompareRow& row, std::size_t seed) {
  StabilityCell cell;
  cell.seed = seed;
  const RunResult& run = row.runs[seed];
  cell.peak_energy_J = run.metric("stability.peak_energy_J");
  cell.passivity_violation_J = run.metric("stability.passivity_violation_J");
  cell.amplitude_m = run.metric("stability.oscillation_amplitude_m");
  cell.frequency_Hz = run.metric("stability.oscillation_frequency_Hz");
  const double verdict = run.metric("stability.verdict");
  if (row.status[seed] == RunStatus::done && std::isfinite(verdict)) {
    cell.verdict = static_cast<StabilityVerdict>(static_cast<int>(verdict));
  } else {
    cell.verdict = StabilityVerdict::refused;
    cell.failed = row.status[seed] == RunStatus::failed;
    cell.reason = row.message[seed].empty() ? "it was not judged" : row.message[seed];
  }
  cell.reason = reason_of(cell);
  return cell;
}

/// Larger is worse; refused cells come before stable ones, for nothing moved.
auto badness(const StabilityCell& cell) {
  const auto value = [](double v) { return std::isfinite(v) ? v : 0.0; };
  const bool refused = cell.verdict == StabilityVerdict::refused && !cell.failed;
  return std::tuple(refused ? 0 : number(cell.verdict), value(cell.passivity_violation_J), value(cell.amplitude_m));
}

/// Whether the port was passive with every seed.
std::optional<bool> all_passive(const CompareRow& row) {
  bool passive = true;
  for (const RunResult& run : row.runs) {
    const double told = run.metric("stability.passive");
    if (!std::isfinite(told)) return std::nullopt;
    passive = passive && told > 0;
  }
  return passive;
}

StabilityCell worst_seed(const CompareRow& row, std::size_t index) {
  StabilityCell worst = cell_of(row, 0);
  for (std::size_t s = 1; s < row.status.size(); ++s) {
    const StabilityCell cell = cell_of(row, s);
    // A seed that is refused is all the same worth telling.
    const bool refused = cell.verdict == StabilityVerdict::refused && worst.verdict == StabilityVerdict::stable;
    if (refused || badness(cell) > badness(worst)) worst = cell;
  }
  worst.row = index;
  worst.passive = all_passive(row);
  return worst;
}

std::string map_name(const StabilityMap& map) {
  return map.graph + (map.method.empty() ? "" : " " + map.method);
}

std::vector<std::string> names_of(const StudyAxis& axis) {
  std::vector<std::string> names;
  for (const StudyValue& value : axis.values) names.push_back(value.text);
  return names;
}

CellMap drawing_of(const StabilityMaps& maps, const StabilityMap& map) {
  CellMap drawing{map_name(map), maps.x.name, maps.y.name, names_of(maps.x), names_of(maps.y),
                  kinds(),       {},          {},          map_name(map)};
  if (map.own_x && map.own_y) drawing.framed = {*map.own_x, *map.own_y};
  for (const auto& row : map.cells) {
    drawing.kind.emplace_back();
    for (const StabilityCell& cell : row) drawing.kind.back().push_back(number(cell.verdict));
  }
  return drawing;
}

/// The texts as a list that YAML reads as texts, whatever they are.
std::string flow_list(const std::vector<std::string>& texts) {
  std::string list;
  for (const std::string& text : texts) {
    list += list.empty() ? "'" : ", '";
    for (const char c : text) list += c == '\'' ? std::string("''") : std::string(1, c);
    list += "'";
  }
  return "[" + list + "]";
}

/// What a cell is worth looking at: where the tool goes and what it is pushed by.
std::string record_setting(const Plan& plan, const std::vector<std::string>& asked) {
  if (!asked.empty()) return "record=" + flow_list(asked);
  std::vector<std::string> found;
  for (const NodeSpec& node : plan.nodes) {
    for (const auto& [role, output] : {std::pair{Role::dynamics, "state"},
                                       {Role::coupling, "force"},
                                       {Role::device, "state"},
                                       {Role::device, "commanded"},
                                       {Role::collision, "contacts"}}) {
      if (node.info->role == role && node.info->output(output) != nullptr) found.push_back(node.name + "." + output);
    }
  }
  return "record=" + flow_list(found);
}

/// What is wrong with what `set` lays over the case's graph; empty where nothing is, or only other things are.
std::string error_at(const RunCase& c, const std::string& set, Registry& registry) {
  Overrides overrides = c.overrides;
  overrides.push_back(set_patch(set));
  try {
    static_cast<void>(load_graph(c.graph, registry, overrides));
  } catch (const GraphError& error) {
    for (const Diagnostic& one : error.diagnostics()) {
      if (one.place.file != overrides.back().place.file) continue;
      const std::size_t colon = one.message.find(": ");
      return colon == std::string::npos ? one.message : one.message.substr(colon + 2);
    }
  }
  return {};
}

/// The graph with what is laid over it, as text; empty where it is refused.
std::string graph_text(const RunCase& c, const Overrides& overrides, Registry& registry) {
  try {
    return to_yaml(make_plan(load_graph(c.graph, registry, overrides)).graph);
  } catch (const InputError&) {
    return {};
  }
}

/// The verdicts that a cell of the maps has, from the best to the worst.
std::set<StabilityVerdict> verdicts_of(const StabilityMaps& maps) {
  std::set<StabilityVerdict> found;
  for (const StabilityMap& map : maps.maps) {
    for (const auto& row : map.cells) {
      for (const StabilityCell& cell : row) found.insert(cell.verdict);
    }
  }
  return found;
}

/// What a verdict says, as a sentence for readers of the page.
const char* meaning_of(StabilityVerdict verdict) {
  switch (verdict) {
    case StabilityVerdict::stable:
      return "Stable: none of the verdicts below.";
    case StabilityVerdict::limit_cycle:
      return "Limit cycle: the tool keeps oscillating when it should be at rest.";
    case StabilityVerdict::pushed_through:
      return "Pushed through: the tool rests where the static balance does not allow it.";
    case StabilityVerdict::energy:
      return "Energy growth: the hand got more energy from the device than it and the tool's weight had given.";
    case StabilityVerdict::not_finite:
      return "Not finite: a signal became NaN or infinite.";
    case StabilityVerdict::refused:
      return "Refused or failed: there was no whole run to judge.";
  }
  return "";
}

/// The cell of the graph's own values, or null.
const StabilityCell* own_cell(const StabilityMap& map) {
  return map.own_x && map.own_y ? &map.cells[*map.own_y][*map.own_x] : nullptr;
}

bool any_own(const StabilityMaps& maps) {
  return std::any_of(maps.maps.begin(), maps.maps.end(),
                     [](const StabilityMap& map) { return own_cell(map) != nullptr; });
}

}  // namespace

void check_record(const StudySpec& spec, const std::vector<RunCase>& cases, Registry& registry) {
  std::vector<Diagnostic> errors;
  const auto is_right = [&](const RunCase& c) {
    return error_at(c, "record=" + flow_list(spec.record), registry).empty();
  };
  if (std::all_of(cases.begin(), cases.end(), is_right)) return;
  for (std::size_t i = 0; i < spec.record.size(); ++i) {
    const std::string set = "record=" + flow_list({spec.record[i]});
    for (const RunCase& c : cases) {
      const std::string found = error_at(c, set, registry);
      if (found.empty()) continue;
      errors.push_back({spec.record_places[i], fmt::format("report.record: {} (in {})", found,
                                                           case_name(graph_name(c.graph), c.configuration))});
      break;
    }
  }
  if (!errors.empty()) throw GraphError(std::move(errors));
}

StabilityMaps stability_maps(const Study& study) {
  StabilityMaps maps{study.spec.vary[0], study.spec.vary[1], {}};
  bool judged = false, ran = false;
  for (const CompareRow& row : study.comparison.rows) {
    for (std::size_t s = 0; s < row.runs.size(); ++s) {
      ran = ran || row.status[s] == RunStatus::done;
      judged = judged || std::isfinite(row.runs[s].metric("stability.verdict"));
    }
  }
  if (ran && !judged) {
    throw InputError(
        study.spec.file.string() +
        ": report: stability: expected a graph whose sink.metrics tells stability.verdict, found none; connect its "
        "inputs state and device, and give `rest`, the time at the end in which the tool should be at rest");
  }
  const std::size_t columns = maps.x.values.size(), rows = maps.y.values.size();
  const std::size_t cells = columns * rows;
  for (std::size_t first = 0; first < study.comparison.rows.size(); first += cells) {
    StabilityMap map{study.comparison.rows[first].graph, study.configuration(first).method, {}};
    map.cells.assign(rows, std::vector<StabilityCell>(columns));
    // The last axis, y, goes fastest.
    for (std::size_t i = 0; i < cells; ++i) {
      map.cells[i % rows][i / rows] = worst_seed(study.comparison.rows[first + i], first + i);
    }
    maps.maps.push_back(std::move(map));
  }
  return maps;
}

bool find_own_values(StabilityMaps& maps, const Study& study, const std::vector<RunCase>& cases, Registry& registry,
                     const std::function<bool()>& interrupted) {
  bool stopped = false;
  const auto find_in = [&](const StudyAxis& axis, const RunCase& c, const Overrides& plain,
                           const std::string& wanted) -> std::optional<std::size_t> {
    for (std::size_t i = 0; i < axis.values.size(); ++i) {
      if (stopped || interrupted()) {
        stopped = true;
        break;
      }
      Overrides with = plain;
      const StudyValue& value = axis.values[i];
      if (value.swap) with.push_back(*value.swap);
      for (const std::string& path : axis.paths) with.push_back({value.place, Assignment{path, value.text}});
      if (graph_text(c, with, registry) == wanted) return i;
    }
    return std::nullopt;
  };
  for (StabilityMap& map : maps.maps) {
    if (stopped || interrupted()) return false;
    const std::size_t first = map.cells[0][0].row;
    Overrides plain = cases[first].unvaried;
    plain.push_back(option_patch("--seed", "seed", std::to_string(study.comparison.seeds.front())));
    const std::string wanted = graph_text(cases[first], plain, registry);
    if (wanted.empty()) continue;
    map.own_x = find_in(maps.x, cases[first], plain, wanted);
    map.own_y = find_in(maps.y, cases[first], plain, wanted);
  }
  return !stopped;
}

std::vector<StabilityCell*> worst_cells(StabilityMaps& maps, const Study& study) {
  try {
    static_cast<void>(load_record_library());
  } catch (const InputError&) {
    return {};  // this build has no HDF5
  }
  std::vector<StabilityCell*> bad;
  for (StabilityMap& map : maps.maps) {
    for (auto& row : map.cells) {
      for (StabilityCell& cell : row) {
        if (cell.verdict != StabilityVerdict::stable && cell.verdict != StabilityVerdict::refused) bad.push_back(&cell);
      }
    }
  }
  std::stable_sort(bad.begin(), bad.end(), [](const auto* a, const auto* b) { return badness(*a) > badness(*b); });
  if (bad.size() > static_cast<std::size_t>(study.spec.worst)) bad.resize(static_cast<std::size_t>(study.spec.worst));
  return bad;
}

std::string record_cell(const StabilityCell& cell, const Study& study, const RunCase& c, Registry& registry,
                        const fs::path& folder, const std::function<bool()>& interrupted) {
  Overrides overrides = c.overrides;
  overrides.push_back(option_patch("--seed", "seed", std::to_string(study.comparison.seeds[cell.seed])));
  const Plan plain = make_plan(load_graph(c.graph, registry, overrides));
  overrides.push_back(set_patch(record_setting(plain, study.spec.record)));
  const Plan plan = make_plan(load_graph(c.graph, registry, overrides));
  const std::string name = plain_name(graph_name(plan.graph.file) + "_" + c.configuration);
  const fs::path out = make_folder(folder / "worst" / name);
  RunOptions options;
  options.cache_folder = default_cache_folder();
  options.recording = out / "recording.h5";
  options.without_reference = study.spec.without_reference;
  options.judge_whole = study.spec.judge == JudgedPart::whole;
  // As the cell was: where all that is compared with it is warm.
  if (!options.judge_whole) options.judge_from = c.judged.from;
  std::optional<Plan> reference;
  if (c.reference) {
    Overrides of_reference = *c.reference;
    of_reference.push_back(option_patch("--seed", "seed", std::to_string(study.comparison.seeds[cell.seed])));
    reference = make_plan(load_graph(c.graph, registry, of_reference));
    options.reference = &*reference;
  }
  if (!c.reference_recording.empty()) {
    options.reference_recording = recording_of(c.reference_recording, graph_name(plan.graph.file), plan.graph.seed);
  }
  options.progress = [&](double, const char*) { return !interrupted(); };
  const RunResult result = execute(plan, options);
  if (result.interrupted || result.reference_interrupted) {
    std::error_code ignored;
    fs::remove_all(out, ignored);
    return {};
  }
  write_file(out / "summary.json", to_json(result).dump(2) + "\n");
  write_file(out / "graph.yaml", result.graph_yaml);
  write_file(out / "report.html", run_report(result, &plan.graph));
  return "worst/" + name;
}

std::string stability_table(const Study& study, const StabilityMaps& maps, std::size_t columns) {
  std::string out = fmt::format("\n{}: {} seed{} from {}, a cell is as bad as its worst\n", study.spec.name,
                                study.comparison.seeds.size(), study.comparison.seeds.size() == 1 ? "" : "s",
                                study.comparison.seeds.front());
  std::string key;
  for (const StabilityVerdict verdict : verdicts_of(maps)) {
    const CellKind& kind = kinds()[static_cast<std::size_t>(number(verdict))];
    key += fmt::format("{}{} {}", key.empty() ? "" : ", ", kind.letter, kind.name);
  }
  for (const StabilityMap& map : maps.maps) {
    out += fmt::format("\n{}: {} across, {} upwards\n", map_name(map), maps.x.name, maps.y.name);
    std::vector<TextTable::Column> heads{{"", TextTable::Align::right}};
    std::vector<std::string> across{""};
    for (const StudyValue& value : maps.x.values) {
      heads.push_back({"", TextTable::Align::right});
      across.push_back(value.text);
    }
    TextTable table(std::move(heads));
    for (std::size_t row = map.cells.size(); row-- > 0;) {
      std::vector<std::string> cells{maps.y.values[row].text};
      for (const StabilityCell& cell : map.cells[row]) {
        const std::string& letter = kinds()[static_cast<std::size_t>(number(cell.verdict))].letter;
        cells.push_back(&cell == own_cell(map) ? "[" + letter + "]" : letter);
      }
      table.add(std::move(cells));
    }
    table.add(std::move(across));
    out += table.text(columns);
    for (const auto& row : map.cells) {
      for (const StabilityCell& cell : row) {
        if (cell.verdict == StabilityVerdict::stable) continue;
        out += fmt::format("  {}: {}: {}{}\n", study.comparison.rows[cell.row].configuration,
                           kinds()[static_cast<std::size_t>(number(cell.verdict))].name, cell.reason,
                           cell.recording.empty() ? "" : " (" + cell.recording + ")");
      }
    }
  }
  return wrapped(out + "\n" + key + (any_own(maps) ? "; [ ] the graph's own values\n" : "\n"), columns);
}

Json to_json(const StabilityMaps& maps) {
  Json json{{"x", maps.x.name}, {"y", maps.y.name}, {"maps", Json::array()}};
  for (const StabilityMap& map : maps.maps) {
    Json cells = Json::array();
    for (std::size_t row = 0; row < map.cells.size(); ++row) {
      for (std::size_t column = 0; column < map.cells[row].size(); ++column) {
        const StabilityCell& cell = map.cells[row][column];
        cells.push_back({{"x", maps.x.values[column].text},
                         {"y", maps.y.values[row].text},
                         {"verdict", name_of(cell.verdict)},
                         {"reason", cell.reason},
                         {"peak_energy_J", number_json(cell.peak_energy_J)},
                         {"passivity_violation_J", number_json(cell.passivity_violation_J)},
                         {"oscillation_amplitude_m", number_json(cell.amplitude_m)},
                         {"oscillation_frequency_Hz", number_json(cell.frequency_Hz)},
                         {"passive", cell.passive ? Json(*cell.passive) : Json()},
                         {"recording", cell.recording}});
      }
    }
    Json own;
    if (const StabilityCell* cell = own_cell(map)) {
      own = {{"x", maps.x.values[*map.own_x].text},
             {"y", maps.y.values[*map.own_y].text},
             {"verdict", name_of(cell->verdict)},
             {"reason", cell->reason}};
    }
    json["maps"].push_back({{"graph", map.graph}, {"method", map.method}, {"own", own}, {"cells", cells}});
  }
  return json;
}

std::string write_stability(const fs::path& folder, const Study& study, const StabilityMaps& maps) {
  std::string meanings;
  for (const StabilityVerdict verdict : verdicts_of(maps)) meanings += std::string(" ") + meaning_of(verdict);
  std::string body = fmt::format(
      "<p class=\"sub\">{}{}{} seed{} from {}; tactor {}</p>\n<p>A cell is as bad as the worst of its seeds.{} The "
      "legend leaves out verdicts that no cell has.{}</p>\n<p>Peak energy is the largest energy of the tool at any "
      "time: kinetic energy, plus the energy of its height if it was above its start.</p>\n",
      escape(study.spec.title), study.spec.title.empty() ? "" : " · ", study.comparison.seeds.size(),
      study.comparison.seeds.size() == 1 ? "" : "s", study.comparison.seeds.front(), TACTOR_VERSION, meanings,
      any_own(maps) ? " A frame is round the cell whose values are the graph's own." : "");
  body += warnings_html(comparison_warnings(study.comparison));
  // The key wants its height too.
  const int height = std::max(360, 190 + 34 * static_cast<int>(maps.y.values.size()));
  const int width = std::clamp(400 + 60 * static_cast<int>(maps.x.values.size()), 700, 1160);
  for (const StabilityMap& map : maps.maps) {
    const CellMap drawing = drawing_of(maps, map);
    const std::string svg = draw(drawing, PictureFormat::svg, width, height);
    const std::string file = plain_name("stability_" + map_name(map));
    write_file(folder / (file + ".svg"), svg);
    const std::string png = draw(drawing, PictureFormat::png, width, height);
    if (!png.empty()) write_file(folder / (file + ".png"), png);
    body += "<h2>" + escape(map_name(map)) + "</h2>\n" + figure_html(svg, drawing, height);
    body +=
        "<div class=\"wide\"><table><thead><tr><th>" + escape(maps.x.name) + "</th><th>" + escape(maps.y.name) +
        "</th><th>verdict</th><th>peak energy, mJ</th><th>passivity violation, mJ</th><th>amplitude, mm</th><th>Hz</th>"
        "<th>reason</th></tr></thead><tbody>\n";
    for (std::size_t row = 0; row < map.cells.size(); ++row) {
      for (std::size_t column = 0; column < map.cells[row].size(); ++column) {
        const StabilityCell& cell = map.cells[row][column];
        const std::string reason = cell.recording.empty() ? escape(cell.reason)
                                                          : fmt::format("{} (<a href=\"{}/report.html\">recorded</a>)",
                                                                        escape(cell.reason), escape(cell.recording));
        body += fmt::format(
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
            escape(maps.x.values[column].text), escape(maps.y.values[row].text),
            escape(kinds()[static_cast<std::size_t>(number(cell.verdict))].name), pretty(1e3 * cell.peak_energy_J),
            pretty(1e3 * cell.passivity_violation_J), pretty(1e3 * cell.amplitude_m), pretty(cell.frequency_Hz),
            reason);
      }
    }
    body += "</tbody></table></div>\n";
  }
  for (std::size_t graph = 0; graph < study.spec.graphs.size(); ++graph) {
    const std::string metrics = named_metrics_html(study, graph);
    if (metrics.empty()) continue;
    body += "<h2>" + escape(study.comparison.rows[graph * study.configurations.size()].graph) + ": metrics</h2>\n" +
            metrics;
  }
  body += where_html(study.comparison);
  return page(study.spec.name, body);
}

}  // namespace tactor
