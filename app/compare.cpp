#include "app/compare.hpp"

#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <exception>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "app/summary.hpp"

namespace tactor {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

const std::vector<Column>& error_columns() {
  static const std::vector<Column> columns{
      {"delivered.force.rms_error_N", "RMS error N"},
      {"delivered.force.max_error_N", "max error N"},
      {"delivered.force.delay_ms", "delay ms"},
      {"delivered.force.rms_d1_N_per_ms", "RMS 1st diff N/ms"},
      {"delivered.force.rms_d2_N_per_ms2", "RMS 2nd diff N/ms²"},
      {"delivered.force.max_step_N", "largest step N"},
      {"delivered.force.error_above_30hz_N", "error above 30 Hz N"},
      {"delivered.force.share_beyond_jnd", "beyond JND"},
      {"delivered.force.overshoot_after_loss_N", "pull-in after loss N"},
      {"delivered.torque.rms_error_Nm", "torque RMS error N m"},
      {"one_step.force.rms_error_N", "one-step RMS N"},
      {"one_step.force.rms_error_hold_N", "one-step RMS of hold N"},
      {"reference.force.rms_N", "reference RMS N"},
      {"physics.force.rms_error_N", "physics RMS error N"},
      {"physics.rate_hz_median", "physics Hz"},
      {"contacts.median", "contacts"},
      {"contacts.max", "most contacts"},
      {"fallbacks", "fallbacks"},
      {"drops", "drops"},
  };
  return columns;
}

/// CPU time in us of all steps that predict and interpolate, for each message of the physics force, or for each tick of
/// the device.
double method_us(const RunResult& run, bool per_tick) {
  double total_s = 0;
  double ticks = 0;
  for (const NodeCost& node : run.nodes) {
    const std::string_view stage = std::string_view(node.type).substr(0, node.type.find('.'));
    if (stage == "prediction" || stage == "interpolation" || stage == "forcefield") total_s += node.total_s;
    if (stage == "device") ticks += static_cast<double>(node.steps);
  }
  return 1e6 * total_s / (per_tick ? ticks : run.figure("physics.steps"));
}

/// A figure by its dotted name, or one of the run's own.
double value_of(const RunResult& run, const std::string& name) {
  if (name == "cpu_ms_per_s") return 1e3 * run.cpu_s / run.duration_s;
  if (name == "method_us_per_result") return method_us(run, false);
  if (name == "method_us_per_tick") return method_us(run, true);
  constexpr std::string_view cost = "cost_us.";
  if (name.starts_with(cost)) {
    for (const NodeCost& node : run.nodes) {
      if (name == fmt::format("cost_us.{}.median", node.node)) return node.median_us;
    }
    return std::nan("");
  }
  return run.figure(name);
}

/// Runs `work(i)` for i in [0, count) on `jobs` threads; the first exception is thrown again.
template <class Work>
void in_parallel(std::size_t count, unsigned jobs, Work work) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex mutex;
  const auto loop = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        next = count;
      }
    }
  };
  std::vector<std::thread> threads;
  for (unsigned t = 1; t < jobs; ++t) threads.emplace_back(loop);
  loop();
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}

void judge(Comparison& comparison) {
  const auto pooled = [](const CompareRow& row) {
    std::vector<double> all;
    for (const RunResult& run : row.runs) {
      if (const Series* errors = run.curve("one_step_error")) {
        all.insert(all.end(), errors->value.begin(), errors->value.end());
      }
    }
    return all;
  };
  const auto figures = [](const CompareRow& row, std::string_view name) {
    std::vector<double> all;
    for (const RunResult& run : row.runs) all.push_back(run.figure(name));
    return all;
  };
  for (std::size_t i = 0; i < comparison.rows.size(); ++i) {
    CompareRow& row = comparison.rows[i];
    if (row.against == i) continue;
    const CompareRow& first = comparison.rows[row.against];
    row.one_step_anova = one_way_anova(pooled(first), pooled(row));
    for (const auto& [target, name] :
         {std::pair{&row.one_step, "one_step.force.rms_error_N"}, {&row.delivered, "delivered.force.rms_error_N"}}) {
      const std::vector<double> a = figures(first, name);
      const std::vector<double> b = figures(row, name);
      if (std::isfinite(mean(a)) && std::isfinite(mean(b))) *target = paired_difference(a, b);
    }
  }
}

}  // namespace

std::span<const double> CompareRow::figure(std::string_view name, const std::vector<Column>& columns) const {
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (columns[c].figure == name) return values[c];
  }
  return {};
}

Comparison compare(const std::vector<CompareCase>& cases, Registry& registry, const std::vector<fs::path>& mesh_folders,
                   const CompareOptions& options) {
  Comparison comparison;
  for (int s = 0; s < options.seeds; ++s) comparison.seeds.push_back(options.first_seed + static_cast<unsigned>(s));
  const std::size_t seeds = comparison.seeds.size();
  std::mutex mutex;
  const auto plan_of = [&](std::size_t c, std::size_t s) {
    Overrides overrides = cases[c].overrides;
    overrides.seed = comparison.seeds[s];
    const std::lock_guard lock(mutex);
    return make_plan(load_graph(cases[c].graph, registry, overrides, mesh_folders));
  };
  // All graphs are checked before anything runs.
  for (std::size_t c = 0; c < cases.size(); ++c) {
    const GraphSpec graph = plan_of(c, 0).graph;
    comparison.rows.push_back(
        {graph.name, cases[c].setting, graph.title, cases[c].against, std::vector<RunResult>(seeds), {}, {}, {}, {}});
  }

  std::size_t done = 0;
  const auto tell = [&](const std::string& what) {
    const std::lock_guard lock(mutex);
    const double share = static_cast<double>(done++) / static_cast<double>(2 * cases.size() * seeds);
    if (options.progress && !options.progress(share, what)) throw RunError("interrupted");
  };
  // Asked by several threads at once, so it only looks whether the user has had enough.
  const auto go_on = [&options](double) { return !options.interrupted || !options.interrupted(); };
  std::mutex notes;
  const auto note = [&](const std::string& text) {
    const std::lock_guard lock(notes);
    if (options.note) options.note(text);
  };
  const auto run_name = [&](std::size_t c, std::size_t s) {
    const CompareRow& row = comparison.rows[c];
    return fmt::format("{}{}{}, seed {}: ", row.graph, row.setting.empty() ? "" : " ", row.setting,
                       comparison.seeds[s]);
  };
  // An error of a run says which it was.
  const auto at_run = [&](std::size_t c, std::size_t s, const auto& work) {
    try {
      return work();
    } catch (const InputError& error) {
      throw InputError(run_name(c, s) + error.what());
    } catch (const RunError& error) {
      throw RunError(run_name(c, s) + error.what());
    }
  };
  // Graphs that differ in what comes after physics share a reference, so one graph a seed is prepared at a time and
  // the others find it.
  for (std::size_t c = 0; c < cases.size(); ++c) {
    in_parallel(seeds, options.jobs, [&](std::size_t s) {
      tell("reference runs");
      at_run(c, s, [&] { return prepare_reference(plan_of(c, s), options.cache_folder, go_on, note); });
    });
  }
  in_parallel(seeds * cases.size(), options.run_jobs, [&](std::size_t i) {
    const std::size_t s = i / cases.size();
    const std::size_t c = i % cases.size();
    tell(comparison.rows[c].graph + " " + comparison.rows[c].setting);
    RunOptions run_options;
    run_options.cache_folder = options.cache_folder;
    run_options.note = note;
    run_options.progress = [&](double, const char*) { return go_on(0); };
    RunResult result = at_run(c, s, [&] { return execute(plan_of(c, s), run_options); });
    if (result.interrupted) throw RunError("interrupted");
    if (result.failure) throw RunError(run_name(c, s) + *result.failure);
    if (s > 0 || !options.curves) {
      std::erase_if(result.series, [](const Series& curve) { return curve.name != "one_step_error"; });
    }
    comparison.rows[c].runs[s] = std::move(result);
  });
  if (options.progress) options.progress(1.0, "done");

  comparison.columns = error_columns();
  comparison.columns.push_back({"cpu_ms_per_s", "CPU ms per s", true});
  comparison.columns.push_back({"method_us_per_result", "method us a result", true});
  comparison.columns.push_back({"method_us_per_tick", "method us a tick", true});
  std::set<std::string> seen;
  for (const CompareRow& row : comparison.rows) {
    for (const NodeCost& node : row.runs.front().nodes) {
      if (seen.insert(node.node).second) {
        comparison.columns.push_back({fmt::format("cost_us.{}.median", node.node), node.node + " us", true});
      }
    }
  }
  for (CompareRow& row : comparison.rows) {
    for (const Column& column : comparison.columns) {
      std::vector<double> values;
      for (const RunResult& run : row.runs) values.push_back(value_of(run, column.figure));
      row.values.push_back(std::move(values));
    }
  }
  // A column that nothing reports is no column.
  for (std::size_t c = comparison.columns.size(); c-- > 0;) {
    bool any = false;
    for (const CompareRow& row : comparison.rows) any = any || std::isfinite(mean(row.values[c]));
    if (any) continue;
    comparison.columns.erase(comparison.columns.begin() + static_cast<std::ptrdiff_t>(c));
    for (CompareRow& row : comparison.rows) row.values.erase(row.values.begin() + static_cast<std::ptrdiff_t>(c));
  }
  judge(comparison);
  return comparison;
}

Json to_json(const CompareRow& row, const std::vector<Column>& columns) {
  const auto difference = [](const std::optional<PairedDifference>& d) -> Json {
    if (!d) return nullptr;
    return {{"pairs", d->pairs},
            {"mean_N", d->mean},
            {"low_N", d->low},
            {"high_N", d->high},
            {"effect_size", d->effect_size},
            {"p_wilcoxon", d->p_wilcoxon}};
  };
  Json json;
  json["graph"] = row.graph;
  if (!row.setting.empty()) json["setting"] = row.setting;
  json["title"] = row.title;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const std::vector<double>& values = row.values[c];
    Json& figure = json["figures"][columns[c].figure];
    const double centre = mean(values);
    figure = {{"mean", std::isfinite(centre) ? Json(centre) : Json()}, {"sd", standard_deviation(values)}};
    figure["by_seed"] = Json::array();
    for (const double v : values) figure["by_seed"].push_back(std::isfinite(v) ? Json(v) : Json());
  }
  if (row.one_step_anova) {
    json["against_first"]["one_step_anova"] = {
        {"F", row.one_step_anova->F}, {"p", row.one_step_anova->p}, {"df_within", row.one_step_anova->df_within}};
  }
  json["against_first"]["one_step_rms"] = difference(row.one_step);
  json["against_first"]["delivered_rms"] = difference(row.delivered);
  return json;
}

Json to_json(const Comparison& comparison) {
  Json json;
  json["tactor"] = TACTOR_VERSION;
  json["seeds"] = comparison.seeds;
  json["graphs"] = Json::array();
  for (const CompareRow& row : comparison.rows) json["graphs"].push_back(to_json(row, comparison.columns));
  return json;
}

std::string judged_text(const Comparison& comparison) {
  std::string out;
  for (std::size_t i = 0; i < comparison.rows.size(); ++i) {
    const CompareRow& row = comparison.rows[i];
    if (row.against == i) continue;
    out += fmt::format("  {}{}{}", row.graph, row.setting.empty() ? "" : " ", row.setting);
    if (row.one_step_anova) {
      out +=
          fmt::format(": one-step ANOVA F = {}, p = {}", pretty(row.one_step_anova->F), pretty(row.one_step_anova->p));
    }
    for (const auto& [name, d] : {std::pair{"one-step", row.one_step}, {"delivered", row.delivered}}) {
      if (d) {
        out += fmt::format("; {} {:+.4f} N [{:+.4f}, {:+.4f}], d_z = {:+.2f}, p = {}", name, d->mean, d->low, d->high,
                           d->effect_size, pretty(d->p_wilcoxon));
      }
    }
    out += "\n";
  }
  return out;
}

std::string comparison_table(const Comparison& comparison) {
  std::string out =
      fmt::format("\nmean over {} seed{}\n\n", comparison.seeds.size(), comparison.seeds.size() == 1 ? "" : "s");
  std::size_t label = 22;
  std::size_t width = 12;
  for (const Column& column : comparison.columns) label = std::max(label, column.label.size());
  for (const CompareRow& row : comparison.rows) width = std::max(width, row.graph.size() + 2);
  out += fmt::format("  {:<{}}", "", label);
  for (const CompareRow& row : comparison.rows) out += fmt::format("{:>{}}", row.graph, width);
  out += "\n";
  bool in_run_times = false;
  for (std::size_t c = 0; c < comparison.columns.size(); ++c) {
    if (comparison.columns[c].run_time && !in_run_times) {
      out += "  run time (CPU)\n";
      in_run_times = true;
    }
    out += fmt::format("  {:<{}}", comparison.columns[c].label, label);
    for (const CompareRow& row : comparison.rows) out += fmt::format("{:>{}}", pretty(mean(row.values[c])), width);
    out += "\n";
  }
  out += fmt::format("\n  against {}\n", comparison.rows.front().graph);
  out += judged_text(comparison);
  return out;
}

}  // namespace tactor
