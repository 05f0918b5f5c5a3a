#include "nodes/collision/mesh.hpp"

#include <algorithm>
#include <numeric>

#include "nodes/scene/body_mesh.hpp"

namespace tactor {

namespace {

TriangleMesh mesh_of(const Body& body) {
  if (body.mesh() != nullptr) return load_body_mesh(body);
  if (body.motion == Motion::fixed) {
    throw InputError("collision.mesh: the fixed body '" + body.name +
                     "' is a sphere; give it a mesh, or use a sphere as tool with collision.sphere");
  }
  throw InputError("collision.mesh: the tool '" + body.name + "' is a sphere; use collision.sphere");
}

ExactDistance distance_of(const Body& body, const TriangleMesh& mesh) {
  return {mesh, body.mesh()->file.string()};
}

}  // namespace

MeshCollision::MeshCollision(const Params& params, const NodeContext& context) : params_(params) {
  const Body* tool = context.scene->tool();
  if (tool == nullptr) throw InputError("collision.mesh needs a moving body in the scene");
  const TriangleMesh tool_mesh = mesh_of(*tool);
  X_WT_start_ = tool->X_WB;
  samples_ = sample_surface(tool_mesh, params.spacing);
  distance_ = std::make_unique<ExactDistance>(distance_of(*tool, tool_mesh));
  std::size_t most = 0;
  for (const Body& body : context.scene->bodies) {
    if (body.motion != Motion::fixed) continue;
    const TriangleMesh mesh = mesh_of(body);
    std::vector<SurfaceSample> samples = sample_surface(mesh, params.spacing);
    most += samples.size() + samples_.size();
    SampleTree tree(samples);
    obstacles_.push_back({body.X_WB, combine(tool->material, body.material), std::move(samples),
                          distance_of(body, mesh), std::move(tree), SampleTree(samples_)});
  }
  found_.reserve(std::min<std::size_t>(most, 4096));
  order_.reserve(std::min<std::size_t>(most, 4096));
}

void MeshCollision::query(const Pose& X_WT, ContactSet& set) {
  found_.clear();
  for (Obstacle& obstacle : obstacles_) add_pair(obstacle, X_WT);

  order_.resize(found_.size());
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  set.bodies.count = 1;
  set.bodies.X_WB[0] = X_WT;
  set.truncated = 0;
  if (order_.size() > ContactSet::capacity) {
    set.truncated = static_cast<std::int32_t>(order_.size()) - ContactSet::capacity;
    std::nth_element(order_.begin(), order_.begin() + ContactSet::capacity, order_.end(),
                     [&](std::size_t a, std::size_t b) {
                       const double da = found_[a].distance, db = found_[b].distance;
                       return da != db ? da < db : a < b;
                     });
    order_.resize(ContactSet::capacity);
    std::sort(order_.begin(), order_.end());
  }
  set.count = static_cast<std::int32_t>(order_.size());
  set.penetrating = 0;
  const auto pressure = [](const Contact& c) { return c.weight * std::max(0.0, -c.distance); };
  double kept = 0, all = 0;
  for (const Contact& c : found_) all += pressure(c);
  for (std::size_t i = 0; i < order_.size(); ++i) {
    set.contact[i] = found_[order_[i]];
    kept += pressure(set.contact[i]);
    if (set.contact[i].distance < 0) ++set.penetrating;
  }
  if (set.truncated > 0 && kept > 0) {
    for (std::size_t i = 0; i < order_.size(); ++i) set.contact[i].weight *= all / kept;
  }
}

void MeshCollision::add_pair(Obstacle& obstacle, const Pose& X_WT) {
  const Pose X_ST = inverse(obstacle.X_WS) * X_WT;
  const std::vector<NearSample>& of_tool = obstacle.tool_tree.find(obstacle.distance, X_ST, params_.margin);
  const std::vector<NearSample>& of_obstacle = obstacle.tree.find(*distance_, inverse(X_ST), params_.margin);

  const auto extent = [&](const std::vector<NearSample>& near, const std::vector<SurfaceSample>& samples) {
    double sum = 0;
    for (const NearSample& n : near) {
      sum += samples[static_cast<std::size_t>(n.sample)].area * (params_.margin - n.distance);
    }
    return sum;
  };
  const double tool_extent = extent(of_tool, samples_), obstacle_extent = extent(of_obstacle, obstacle.samples);
  const double total = tool_extent + obstacle_extent;
  if (total <= 0) return;
  const Material& m = obstacle.material;
  Contact c{.stiffness = m.stiffness, .damping = m.damping, .friction = m.friction};
  for (const NearSample& n : of_tool) {
    const SurfaceSample& s = samples_[static_cast<std::size_t>(n.sample)];
    c.p_TC = s.p;
    c.p_WC = transform(obstacle.X_WS, n.nearest.p);
    c.n_W = rotate(obstacle.X_WS.R, n.nearest.gradient);
    c.distance = n.distance;
    c.weight = tool_extent / total * s.area / m.patch_area;
    found_.push_back(c);
  }
  for (const NearSample& n : of_obstacle) {
    const SurfaceSample& s = obstacle.samples[static_cast<std::size_t>(n.sample)];
    c.p_TC = n.nearest.p;
    c.p_WC = transform(obstacle.X_WS, s.p);
    c.n_W = -rotate(X_WT.R, n.nearest.gradient);
    c.distance = n.distance;
    c.weight = obstacle_extent / total * s.area / m.patch_area;
    found_.push_back(c);
  }
}

NodeInfo MeshCollision::declare() {
  Declare<MeshCollision> d("collision.mesh", "Exact contacts of a mesh tool with fixed meshes, from both sides.");
  d.details(
      "Points of either surface against the other's exact signed distance (CGAL's AABB tree, angle-weighted "
      "pseudo-normals), culled by spheres that remember their last distance. A query does work in proportion to "
      "the penetrating contacts. Thin parts must be thicker than the deepest penetration: beyond the middle of a part "
      "the nearest surface is the far one. With spacing 0 only vertices touch; large faces need a spacing.");
  declare_collision(d);
  d.real("spacing", &Params::spacing,
         {.doc = "longest edge between contact samples; 0: the vertices only",
          .unit = "m",
          .default_value = 0,
          .min = 0,
          .max = 1});
  return d.info();
}

}  // namespace tactor
