#include <algorithm>
#include <cmath>

#include "bench/collision/cgal_exact.hpp"
#include "bench/collision/measure.hpp"
#include "bench/collision/ours.hpp"
#include "bench/collision/path.hpp"
#include "bench/collision/peers.hpp"
#include "bench/collision/quantile.hpp"
#include "bench/collision/scenes.hpp"
#include "nodes/physics/mesh/refine.hpp"
#include "nodes/physics/mesh/solid_file.hpp"

namespace tactor::bench {

namespace {

using Json = nlohmann::ordered_json;

double deepest(const Contender& contender) {
  double depth = 0;
  for (const Touch& t : contender.touches()) depth = std::max(depth, t.depth);
  return depth;
}

std::size_t samples_of(const Pair& pair) {
  return pair.fixed.samples.size() + pair.tool.samples.size();
}

/// How much of the deepest penetration the samples of `coarse` miss, against those of `fine`, which hold all of them.
///
/// Signed distance changes by no more than the way moved. A point of the surface that has a sample within rho is
/// therefore at most rho deeper than it, and a shell has one within its spacing. Where the surfaces lie flat on each
/// other, distance hardly changes along the face, and far less is missed.
Json sampling_error(const Pair& coarse, const Pair& fine, const std::vector<Step>& steps) {
  const auto ours = make_tactor(coarse, 0), finer = make_tactor(fine, 0);
  std::vector<double> missed;
  // The finer shell takes long; every tenth sample of the trajectory tells as much.
  for (std::size_t i = 0; i < steps.size(); i += 10) {
    ours->query(steps[i]);
    finer->query(steps[i]);
    if (finer->touching()) missed.push_back(1e3 * (deepest(*finer) - deepest(*ours)));
  }
  return {{"samples", samples_of(coarse)}, {"poses", missed.size()}, {"missed_mm", spread_of(missed)}};
}

}  // namespace

Json peg_scene(const SceneOptions& options) {
  const TriangleMesh plate = load_solid(options.meshes / "plate.off").mesh,
                     peg = load_solid(options.meshes / "peg.off").mesh;
  const auto sampled = [&](double spacing) -> Pair {
    return {{plate, sample_surface(plate, spacing).points}, {peg, sample_surface(peg, spacing).points}};
  };
  const auto divided = [&](double longest_edge) -> Pair {
    return {{plate, vertex_samples(refine(plate, longest_edge).mesh).points},
            {peg, vertex_samples(refine(peg, longest_edge).mesh).points}};
  };
  constexpr double coarse_spacing = 0.004, spacing = 0.002, fine_edge = 0.0005;  // m
  const Pair shell = sampled(spacing), coarse = sampled(coarse_spacing), fine = divided(fine_edge),
             vertices{{plate, vertex_samples(plate).points}, {peg, vertex_samples(peg).points}};
  // With the shell's own samples, so that what is found of each can be compared.
  Pair reference_shell = divided(0.001);
  const auto append = [](Body& body, const Body& more) {
    body.samples.insert(body.samples.end(), more.samples.begin(), more.samples.end());
  };
  append(reference_shell.fixed, shell.fixed);
  append(reference_shell.tool, shell.tool);
  const Samples samples{0, insert_peg_duration / options.samples, options.samples};
  std::vector<Step> steps = insert_peg(samples);
  const auto reference = make_cgal_exact(reference_shell);
  add_exact(*reference, steps);

  constexpr std::size_t all = 1'000'000;
  constexpr auto d = Precision::double_precision;
  const std::vector<Entry> entries = {
      {"tactor, 2 mm shell", Gives::depths, [](const Pair& p) { return make_tactor(p, 0); }},
      {"tactor, 4 mm shell", Gives::depths, [&](const Pair&) { return make_tactor(coarse, 0); }},
      {"tactor, vertices only", Gives::depths, [&](const Pair&) { return make_tactor(vertices, 0); }},
      {"tactor, collision.sdf, 4 mm shell, 0.4 mm margin", Gives::depths,
       [&](const Pair& p) {
         return make_sdf_node(p, {options.meshes / "plate.off", options.meshes / "peg.off"}, 0.0004, coarse_spacing);
       }},
      {"tactor, exact, 2 mm shell", Gives::depths, make_exact},
      {"CGAL, 2 mm shell", Gives::depths, make_cgal_exact},
      {"CGAL, box pairs", Gives::points, make_box_pairs},
      {"FCL double, all contacts", Gives::depths, [=](const Pair& p) { return make_fcl(p, d, all); }},
      {"ODE double, 4,096 contacts", Gives::depths, [](const Pair& p) { return make_ode(p, 4096); }},
      {"Bullet GImpact, float, mm", Gives::depths, [](const Pair& p) { return make_gimpact(p, 1e-3); }}};
  MeasureOptions measured;
  if (!options.cold) measured.cold_blocks = 0;
  Json json = {{"triangles", {plate.faces.size(), peg.faces.size()}},
               {"samples", {shell.fixed.samples.size(), shell.tool.samples.size()}},
               {"reference_samples", {reference_shell.fixed.samples.size(), reference_shell.tool.samples.size()}},
               {"path", describe(steps, samples.period)},
               {"near_mm", 1e3 * measured.near},
               {"deep_mm", 1e3 * measured.deep}};
  json["contenders"] = measure(entries, shell, steps, measured);
  json["fine"] = {{"edge_mm", 1e3 * fine_edge}, {"samples", samples_of(fine)}};
  const auto missed_by = [&](const Pair& pair, Json spacing_mm) {
    Json row = {{"spacing_mm", std::move(spacing_mm)}};
    row.update(sampling_error(pair, fine, steps));
    return row;
  };
  json["sampling"] = {missed_by(vertices, nullptr), missed_by(coarse, 1e3 * coarse_spacing),
                      missed_by(shell, 1e3 * spacing)};
  return json;
}

}  // namespace tactor::bench
