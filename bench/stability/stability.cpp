// Maps where a scene stays stable, for the project's stepping and for ODE's, as JSON.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "bench/stability/run.hpp"
#include "framework/core/check.hpp"

using namespace tactor;
using namespace tactor::bench;

namespace {

nlohmann::ordered_json json_of(const Cell& cell, const std::string& contender, const Finding& f) {
  nlohmann::ordered_json j{{"contender", contender},
                           {"contact_stiffness", cell.contact_stiffness},
                           {"mass", cell.mass},
                           {"rate", cell.rate},
                           {"coupling_stiffness", cell.coupling_stiffness},
                           {"verdict", name_of(f.verdict)},
                           {"generated", f.generated},
                           {"peak_to_peak_m", f.peak_to_peak},
                           {"rest_error_m", f.rest_error},
                           {"step_s", f.step_s},
                           {"query_s", f.query_s},
                           {"left_out", f.left_out},
                           {"simulated_s", f.simulated_s},
                           {"damped_steps", f.damped_steps},
                           {"stopped_steps", f.stopped_steps}};
  if (!f.why.empty()) j["why"] = f.why;
  return j;
}

/// A few cells from the corners and the middle of a scene.
std::vector<Cell> thinned(std::vector<Cell> cells, std::size_t most) {
  if (cells.size() <= most) return cells;
  std::vector<Cell> kept;
  for (std::size_t i = 0; i < most; ++i) kept.push_back(cells[i * (cells.size() - 1) / (most - 1)]);
  return kept;
}

bool wanted(const std::vector<std::string>& names, const std::string& name) {
  return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

bool wanted(const std::vector<double>& values, double value) {
  return values.empty() || std::find(values.begin(), values.end(), value) != values.end();
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Maps where a scene stays stable, for the project's stepping and for ODE's");
  std::string meshes, scratch = ".";
  std::vector<std::string> scenes, names;
  std::vector<double> contact, mass, rate, coupling;
  std::size_t most = 0;
  app.add_option("--meshes", meshes, "folder with bunny.off, peg.off and plate.off")->required();
  app.add_option("--scratch", scratch, "folder for small meshes made here");
  app.add_option("--scene", scenes, "only these");
  app.add_option("--contender", names, "only these");
  app.add_option("--contact-stiffness", contact, "only these, N/m");
  app.add_option("--mass", mass, "only these, kg");
  app.add_option("--rate", rate, "only these, Hz");
  app.add_option("--coupling-stiffness", coupling, "only these, N/m");
  app.add_option("--most", most, "cells a scene, spread over it; 0: all")->check(CLI::Range(0, 100000));
  CLI11_PARSE(app, argc, argv);

  nlohmann::ordered_json out{{"scenes", nlohmann::ordered_json::array()}};
  for (const TrialScene& scene : trial_scenes(meshes, scratch)) {
    if (!wanted(scenes, scene.name)) continue;
    std::vector<Cell> cells = scene.cells();
    std::erase_if(cells, [&](const Cell& c) {
      return !wanted(contact, c.contact_stiffness) || !wanted(mass, c.mass) || !wanted(rate, c.rate) ||
             !wanted(coupling, c.coupling_stiffness);
    });
    if (most > 0) cells = thinned(cells, std::max<std::size_t>(most, 2));
    std::vector<Contender> chosen = contenders();
    std::erase_if(chosen,
                  [&](const Contender& c) { return !wanted(names, c.name) || !wanted(scene.contenders, c.name); });
    nlohmann::ordered_json found = nlohmann::ordered_json::array();
    std::size_t stable = 0;
    // The contenders take turns, so that whatever else the machine does hits all alike.
    for (const Cell& cell : cells) {
      for (const Contender& contender : chosen) {
        const Finding finding = run_cell(scene, cell, contender);
        stable += finding.verdict == StabilityVerdict::stable ? 1 : 0;
        found.push_back(json_of(cell, contender.name, finding));
      }
    }
    std::fprintf(stderr, "%s: %zu of %zu stable\n", scene.name.c_str(), stable, found.size());
    out["scenes"].push_back({{"name", scene.name}, {"title", scene.title}, {"cells", found}});
  }
  std::cout << out.dump(1) << '\n';
  return std::cout.flush() ? 0 : 1;
} catch (const InputError& e) {
  std::fprintf(stderr, "stability_bench: %s\n", e.what());
  return 2;
} catch (const std::exception& e) {
  std::fprintf(stderr, "stability_bench: %s\n", e.what());
  return 1;
}
