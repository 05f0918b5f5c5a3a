// Contacts of meshes by this project and by other libraries, side by side on one core.
//
// collision_bench --meshes FOLDER [--scene bunny|peg|duck|growth|physics|dynamics|build]... [--samples N] [--no-cold]
// [--no-grids]
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <map>

#include "bench/collision/scenes.hpp"
#include "bench/collision/timed_loop.hpp"
#include "framework/core/temporary_folder.hpp"

using namespace tactor;
using namespace tactor::bench;

int main(int argc, char** argv) try {
  static const std::map<std::string, nlohmann::ordered_json (*)(const SceneOptions&)> scenes = {
      {"bunny", bunny_scene},     {"peg", peg_scene},           {"duck", duck_scene},  {"growth", growth_scene},
      {"physics", physics_scene}, {"dynamics", dynamics_scene}, {"build", build_scene}};
  SceneOptions options;
  std::vector<std::string> wanted = {"bunny", "peg", "duck", "growth", "physics", "dynamics", "build"};
  bool warm_alone = false, no_grids = false, no_realtime = false;
  CLI::App app("Contacts of meshes by this project and by other libraries, side by side, as JSON.");
  app.add_option("--meshes", options.meshes, "folder of bunny.off, peg.off, plate.off and duck.off")->required();
  app.add_option("--scene", wanted, "which scenes")->check(CLI::IsMember(scenes));
  app.add_option("--samples", options.samples, "of a trajectory")->check(CLI::Range(8, 1'000'000));
  app.add_flag("--no-cold", warm_alone, "leave out the queries with swept caches");
  app.add_flag("--no-grids", no_grids, "leave out the grids of several resolutions, which take long to make");
  app.add_flag("--no-realtime", no_realtime, "run as any program, for a check that looks at no time");
  CLI11_PARSE(app, argc, argv);
  options.cold = !warm_alone;
  options.grids = !no_grids;

  // What a query of ours builds is built here, and leaves nothing behind.
  const TemporaryFolder cache;
  setenv("TACTOR_CACHE", cache.path().c_str(), 1);
  const int core = static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN)) - 1;
  const ThreadGrant grant = time_loops_on(no_realtime ? std::nullopt : std::optional(core));
  nlohmann::ordered_json json = {
      {"core", nullptr},
      {"policy", grant.granted.policy == SchedulingPolicy::fifo ? "SCHED_FIFO" : "SCHED_OTHER"},
      {"refused", nlohmann::ordered_json::array()}};
  if (grant.granted.cpu) json["core"] = *grant.granted.cpu;
  for (const Refusal& refusal : grant.refused) json["refused"].push_back(refusal.what);
  for (const std::string& name : wanted) {
    std::fprintf(stderr, "%s\n", name.c_str());
    json["scenes"][name] = scenes.at(name)(options);
  }
  std::printf("%s\n", json.dump(1).c_str());
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "collision_bench: %s\n", e.what());
  return 1;
}
