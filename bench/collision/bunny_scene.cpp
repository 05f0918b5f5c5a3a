#include <algorithm>

#include "bench/collision/cgal_exact.hpp"
#include "bench/collision/measure.hpp"
#include "bench/collision/ours.hpp"
#include "bench/collision/path.hpp"
#include "bench/collision/peers.hpp"
#include "bench/collision/scenes.hpp"
#include "nodes/physics/mesh/solid_file.hpp"

namespace tactor::bench {

namespace {

using Json = nlohmann::ordered_json;

Entry trilinear(int resolution) {
  return {"trilinear, " + std::to_string(resolution), Gives::samples,
          [resolution](const Pair& pair) { return make_trilinear(pair, resolution); }};
}

Entry cells(int resolution) {
  return {"tactor, " + std::to_string(resolution), Gives::samples,
          [resolution](const Pair& pair) { return make_tactor(pair, 0, {.resolution = resolution}); }};
}

/// The longest edge of a triangle, mm: that which a share of the surface does not exceed.
Json longest_edges(const TriangleMesh& mesh) {
  std::vector<std::pair<double, double>> edge_and_area;
  double area = 0;
  for (const auto& f : mesh.faces) {
    double longest = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 &a = mesh.vertices[static_cast<std::size_t>(f[i])],
                 &b = mesh.vertices[static_cast<std::size_t>(f[(i + 1) % 3])];
      longest = std::max(longest, norm(b - a));
    }
    edge_and_area.emplace_back(1e3 * longest, 0.5 * norm(doubled_area_normal(mesh, f)));
    area += edge_and_area.back().second;
  }
  std::sort(edge_and_area.begin(), edge_and_area.end());
  const auto at = [&](double share) {
    double sum = 0;
    for (const auto& [edge, of_it] : edge_and_area) {
      sum += of_it;
      if (sum >= share * area) return edge;
    }
    return edge_and_area.back().first;
  };
  return {{"median", at(0.5)}, {"p99", at(0.99)}, {"max", at(1)}};
}

std::vector<Entry> contenders(const std::filesystem::path& file) {
  constexpr std::size_t all = 1'000'000;
  constexpr auto f = Precision::single_precision, d = Precision::double_precision;
  return {{"tactor", Gives::samples, [](const Pair& p) { return make_tactor(p, 0); }},
          {"tactor, 1 mm margin", Gives::samples, [](const Pair& p) { return make_tactor(p, 0.001); }},
          {"tactor, collision.sdf, default parameters", Gives::samples,
           [=](const Pair& p) {
             return make_sdf_node(p, {file, file});
           }},
          {"tactor, collision.sdf, 1 mm margin", Gives::samples,
           [=](const Pair& p) {
             return make_sdf_node(p, {file, file}, 0.001);
           }},
          {"tactor, exact", Gives::samples, make_exact},
          {"floor", Gives::samples, make_floor},
          {"CGAL", Gives::samples, make_cgal_exact},
          {"FCL double, touching", Gives::touching, [=](const Pair& p) { return make_fcl(p, d, 0); }, false},
          {"FCL double, 20 contacts", Gives::depths, [=](const Pair& p) { return make_fcl(p, d, 20); }, false},
          {"FCL double, all contacts", Gives::depths, [=](const Pair& p) { return make_fcl(p, d, all); }},
          {"FCL float, all contacts", Gives::depths, [=](const Pair& p) { return make_fcl(p, f, all); }},
          {"ODE double, 4,096 contacts", Gives::depths, [](const Pair& p) { return make_ode(p, 4096); }},
          {"Bullet GImpact, float, mm", Gives::depths, [](const Pair& p) { return make_gimpact(p, 1e-3); }}};
}

}  // namespace

Json bunny_scene(const SceneOptions& options) {
  const std::filesystem::path file = options.meshes / "bunny.off";
  const TriangleMesh mesh = load_solid(file).mesh;
  const Body bunny{mesh, vertex_samples(mesh).points};
  const Pair pair{bunny, bunny};
  const Samples samples{0, press_and_slide_duration / options.samples, options.samples};
  std::vector<Step> steps = press_and_slide(pair, samples);
  const auto reference = make_cgal_exact(pair);
  add_exact(*reference, steps);

  MeasureOptions measured;
  if (!options.cold) measured.cold_blocks = 0;
  Json json = {{"triangles", {mesh.faces.size(), mesh.faces.size()}},
               {"samples", {bunny.samples.size(), bunny.samples.size()}},
               {"path", describe(steps, samples.period)},
               {"longest_edge_mm", longest_edges(mesh)},
               {"near_mm", 1e3 * measured.near},
               {"deep_mm", 1e3 * measured.deep}};
  json["contenders"] = measure(contenders(file), pair, steps, measured);
  if (!options.grids) return json;
  std::vector<Entry> grids = {contenders(file).front()};
  for (const int resolution : {64, 128, 192, 256}) {
    grids.push_back(cells(resolution));
    grids.push_back(trilinear(resolution));
  }
  json["grids"] = measure(grids, pair, steps, measured);
  return json;
}

}  // namespace tactor::bench
