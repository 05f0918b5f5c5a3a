#include <fstream>

#include <CGAL/IO/OFF.h>
#include <CGAL/subdivision_method_3.h>

#include "bench/collision/measure.hpp"
#include "bench/collision/ours.hpp"
#include "bench/collision/path.hpp"
#include "bench/collision/peers.hpp"
#include "bench/collision/scenes.hpp"
#include "framework/core/check.hpp"
#include "meshes/decimate.hpp"

namespace tactor::bench {

namespace {

using Json = nlohmann::ordered_json;

/// 0.15 m high along y, and centred.
void bring_to_size(TriangleMesh& mesh) {
  Vec3 low = mesh.vertices.front(), high = low;
  for (const Vec3& v : mesh.vertices) {
    for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], v[k]), high[k] = std::max(high[k], v[k]);
  }
  const double scale = 0.15 / (high.y - low.y);
  for (Vec3& v : mesh.vertices) v = scale * (v - 0.5 * (low + high));
}

TriangleMesh bunny(const Surface& source, std::size_t faces) {
  Surface surface = source;
  TriangleMesh mesh;
  if (faces < source.number_of_faces()) {
    mesh = decimate(surface, faces, "bunny00.off");
  } else {
    // Each subdivision cuts a face into four and smooths.
    while (surface.number_of_faces() < faces) CGAL::Subdivision_method_3::Loop_subdivision(surface);
    mesh = indexed(surface);
  }
  bring_to_size(mesh);
  return mesh;
}

Json row(const TriangleMesh& mesh, double deepest, int samples) {
  constexpr std::size_t all = 1'000'000;
  const Body body{mesh, sample_surface(mesh, 0)};
  const Pair pair{body, body};
  // The first of the four times that the depth comes and goes.
  std::vector<Step> steps = press_and_slide(pair, {0, 1.75 / samples, samples}, deepest);
  MeasureOptions options;
  options.cold_blocks = 0;
  options.compare = false;
  const std::vector<Entry> entries = {
      {"tactor, exact", Gives::depths, [](const Pair& p) { return make_sample_tree(p, 0); }},
      {"FCL double, all contacts", Gives::depths,
       [](const Pair& p) { return make_fcl(p, Precision::double_precision, all); }},
      {"ODE double, 4,096 contacts", Gives::depths, [](const Pair& p) { return make_ode(p, 4096); }}};
  return {{"triangles", mesh.faces.size()},
          {"deepest_mm", 1e3 * deepest},
          {"contenders", measure(entries, pair, steps, options)}};
}

}  // namespace

Json growth_scene(const SceneOptions& options) {
  const auto path = options.meshes / "data/meshes/bunny00.off";
  Surface source;
  std::ifstream in(path);
  if (!in || !CGAL::IO::read_OFF(in, source)) {
    throw InputError(path.string() + ": cannot be read as OFF; build the target tactor_meshes first");
  }
  const std::size_t all_faces = source.number_of_faces();
  Json same_depth = Json::array(), same_contacts = Json::array();
  for (const std::size_t faces : {std::size_t{5'240}, std::size_t{20'990}, all_faces, 4 * all_faces}) {
    const TriangleMesh mesh = bunny(source, faces);
    const int samples = options.samples / 4;
    same_depth.push_back(row(mesh, 0.002, samples));
    // The area in contact grows as the depth does, and with it the number of samples inside.
    same_contacts.push_back(row(mesh, 0.002 * 5240 / static_cast<double>(mesh.faces.size()), samples));
  }
  return {{"same_depth", same_depth}, {"same_contacts", same_contacts}};
}

}  // namespace tactor::bench
