#include "bench/collision/measure.hpp"
#include "bench/collision/ours.hpp"
#include "bench/collision/path.hpp"
#include "bench/collision/peers.hpp"
#include "bench/collision/scenes.hpp"
#include "bench/collision/sized_bunny.hpp"

namespace tactor::bench {

namespace {

using Json = nlohmann::ordered_json;

/// With or without a shell of samples 4 mm apart, whatever the triangles.
Json row(const TriangleMesh& mesh, double deepest, int samples, bool with_shell) {
  constexpr std::size_t all = 1'000'000;
  const Body body{mesh, vertex_samples(mesh).points};
  const Pair pair{body, body};
  // The first of the four times that the depth comes and goes.
  std::vector<Step> steps = press_and_slide(pair, {0, 1.75 / samples, samples}, deepest);
  MeasureOptions options;
  options.cold_blocks = 0;
  options.compare = false;
  std::vector<Entry> entries = {
      {"tactor", Gives::depths, [](const Pair& p) { return make_tactor(p, 0); }},
      {"tactor, exact", Gives::depths, make_exact},
      {"FCL double, all contacts", Gives::depths,
       [](const Pair& p) { return make_fcl(p, Precision::double_precision, all); }},
      {"ODE double, 4,096 contacts", Gives::depths, [](const Pair& p) { return make_ode(p, 4096); }}};
  Json json = {{"triangles", mesh.faces.size()}, {"deepest_mm", 1e3 * deepest}};
  Pair shells;
  if (with_shell) {
    const Body shell{mesh, sample_surface(mesh, 0.004).points};
    shells = {shell, shell};
    entries.insert(entries.begin() + 1,
                   {"tactor, 4 mm shell", Gives::depths, [&shells](const Pair&) { return make_tactor(shells, 0); }});
    json["shell_samples"] = shell.samples.size();
  }
  json["contenders"] = measure(entries, pair, steps, options);
  return json;
}

}  // namespace

Json growth_scene(const SceneOptions& options) {
  Json same_depth = Json::array(), same_contacts = Json::array();
  for (const TriangleMesh& mesh :
       sized_bunnies(options.meshes / "data/meshes/bunny00.off", {5'240, 20'990, 75'408, 301'632})) {
    const int samples = options.samples / 4;
    same_depth.push_back(row(mesh, 0.002, samples, true));
    // The area in contact grows as the depth does, and with it the number of samples inside. A shell's samples are as
    // many whatever the triangles: at the smallest depths none of them touches.
    same_contacts.push_back(row(mesh, 0.002 * 5240 / static_cast<double>(mesh.faces.size()), samples, false));
  }
  return {{"same_depth", same_depth}, {"same_contacts", same_contacts}};
}

}  // namespace tactor::bench
