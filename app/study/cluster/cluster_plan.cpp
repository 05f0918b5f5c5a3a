#include "app/study/cluster/cluster_plan.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "app/study/cluster/own_files.hpp"
#include "app/study/cluster/plan_fields.hpp"
#include "app/study/cluster/shard.hpp"
#include "framework/core/disk_cache.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::array<const char*, 5> stage_names{"warm", "references", "intervals", "runs", "merge"};

constexpr const char* twin_infix = ".twin-";

std::string name_of_shard(std::size_t chunk) {
  return fmt::format("{:07}{}", chunk, shard_ending);
}

/// Cuts units in their order, so that the tasks of a chunk share a graph, and what is read for it.
Stage cut_stage(StageKind kind, std::vector<std::size_t> cases, std::size_t seeds, const std::vector<double>& costs,
                double chunk_s) {
  Stage stage{kind, std::move(cases), {0}};
  double sum = 0;
  for (std::size_t unit = 0; unit < stage.cases.size() * seeds; ++unit) {
    const double cost = costs[stage.cases[unit / seeds]];
    if (sum > 0 && sum + cost > chunk_s) {
      stage.chunk_begin.push_back(unit);
      sum = 0;
    }
    sum += cost;
  }
  stage.chunk_begin.push_back(stage.cases.size() * seeds);
  return stage;
}

std::string plan_header() {
  return fmt::format("tactor {} plan of a study on a cluster\n", TACTOR_VERSION);
}

nlohmann::ordered_json manifest_of(const ClusterPlan& plan) {
  const PlannedCases& planned = plan.planned;
  nlohmann::ordered_json manifest;
  manifest["tactor"] = TACTOR_VERSION;
  manifest["key"] = plan.key;
  manifest["study"] = {{"name", plan.spec.name},
                       {"file", plan.spec.file.string()},
                       {"hash", content_key({plan.spec.text})},
                       {"options", planned.settings.identity.options}};
  manifest["code"] = plan.code;
  manifest["runs"] = planned.runs();
  manifest["seeds"] = planned.settings.seeds;
  manifest["chunk_s"] = plan.chunk_s;
  manifest["stages"] = nlohmann::ordered_json::array();
  for (const Stage& stage : plan.stages) {
    manifest["stages"].push_back({{"name", name_of(stage.kind)}, {"units", stage.units()}, {"tasks", stage.chunks()}});
  }
  // The content of a case is the hash of its resolved graph with the bytes of all files that it names.
  manifest["cases"] = nlohmann::ordered_json::array();
  for (std::size_t c = 0; c < planned.cases.size(); ++c) {
    manifest["cases"].push_back({{"graph", planned.cases[c].graph.string()},
                                 {"configuration", planned.cases[c].configuration},
                                 {"content", planned.checks[c].content}});
  }
  return manifest;
}

}  // namespace

const char* name_of(StageKind stage) {
  return stage_names.at(static_cast<std::size_t>(stage));
}

StageKind stage_of(const std::string& name) {
  for (const StageKind stage : all_stages) {
    if (name == name_of(stage)) return stage;
  }
  throw InputError(fmt::format("expected a stage ({}), found \"{}\"", fmt::join(stage_names, ", "), name));
}

const std::vector<double>& UnitCosts::of(StageKind stage) const {
  return stage == StageKind::warm ? warm : stage == StageKind::references ? references : runs;
}

const Stage* ClusterPlan::stage(StageKind kind) const {
  const auto found = std::find_if(stages.begin(), stages.end(), [&](const Stage& s) { return s.kind == kind; });
  return found == stages.end() ? nullptr : &*found;
}

std::string ClusterPlan::shard_key(StageKind stage) const {
  return stage == StageKind::runs ? content_key({key, to_bytes(planned.judged)}) : key;
}

std::size_t ClusterPlan::run_of(const Stage& stage, std::size_t unit) const {
  return stage.cases[unit / planned.seeds()] * planned.seeds() + unit % planned.seeds();
}

void cut_into_stages(ClusterPlan& plan) {
  const PlannedCases& planned = plan.planned;
  std::vector<std::size_t> warm, references, runs;
  for (std::size_t c = 0; c < planned.cases.size(); ++c) {
    if (planned.has_to_warm_up(c)) warm.push_back(c);
    if (planned.needs_reference(c) && planned.reference_case[c] == c) references.push_back(c);
    if (!planned.obstacles[c]) runs.push_back(c);
  }
  plan.stages.clear();
  const auto add = [&](StageKind kind, std::vector<std::size_t> cases) {
    if (cases.empty()) return;
    plan.stages.push_back(cut_stage(kind, std::move(cases), planned.seeds(), plan.costs.of(kind), plan.chunk_s));
  };
  add(StageKind::warm, std::move(warm));
  add(StageKind::references, std::move(references));
  add(StageKind::runs, std::move(runs));
}

fs::path ClusterFolder::cache_of(const ClusterPlan& plan) const {
  const RanOn& machine = this_machine();
  return plan.depends_on_processor.empty() ? cache() : cache() / content_key({machine.processor, machine.c_library});
}

fs::path ClusterFolder::shard(StageKind stage, std::size_t chunk) const {
  return shards(stage) / name_of_shard(chunk);
}

fs::path ClusterFolder::part(StageKind stage, std::size_t chunk) const {
  return shards(stage) / (name_of_shard(chunk) + ".part");
}

fs::path ClusterFolder::my_twin(StageKind stage, std::size_t chunk) const {
  return shards(stage) / fmt::format("{}{}{}-{}", name_of_shard(chunk), twin_infix, this_machine().node, getpid());
}

std::vector<fs::path> ClusterFolder::twins(StageKind stage) const {
  std::vector<fs::path> found;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(shards(stage), ignored)) {
    if (entry.path().filename().string().find(shard_ending + std::string(twin_infix)) != std::string::npos) {
      found.push_back(entry.path());
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

bool ClusterFolder::is_twin_of(const fs::path& twin, std::size_t chunk) const {
  return twin.filename().string().starts_with(name_of_shard(chunk) + twin_infix);
}

fs::path ClusterFolder::lost_reference(std::size_t run) const {
  return path() / "lost" / fmt::format("{}.bin", run);
}

bool ClusterFolder::is_there() const {
  std::error_code ignored;
  return fs::exists(plan(), ignored);
}

void demand_own(const ClusterFolder& folder) {
  for (const fs::path& path : {folder.out(), folder.path()}) demand_own(path);
}

void write_plan(ClusterPlan& plan, const ClusterFolder& folder) {
  const std::string bytes = to_bytes(plan);
  plan.key = content_key({plan_header(), bytes});
  publish_bytes(plan_header() + plan.key + bytes, folder.plan());
  publish_bytes(manifest_of(plan).dump(1) + "\n", folder.path() / "manifest.json");
}

ClusterPlan read_plan(const ClusterFolder& folder) {
  const std::string name = folder.plan().string();
  demand_own(folder);
  const std::optional<std::string> there = own_bytes(folder.plan());
  if (!there) throw InputError(name + ": expected the plan of a study on a cluster, found no file");
  const std::string& bytes = *there;
  const std::string header = plan_header();
  if (!bytes.starts_with(header)) {
    throw InputError(
        fmt::format("{}: expected a plan of tactor {}, found another file or version", name, TACTOR_VERSION));
  }
  constexpr std::size_t digits = 32;
  const std::string_view rest = std::string_view(bytes).substr(header.size());
  const std::string_view content = rest.substr(std::min(digits, rest.size()));
  if (rest.substr(0, digits) != content_key({header, content})) throw InputError(name + ": its bytes are damaged");
  auto plan = from_bytes<ClusterPlan>(content);
  plan.key = rest.substr(0, digits);
  return plan;
}

}  // namespace tactor
