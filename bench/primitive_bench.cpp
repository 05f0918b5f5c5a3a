// What a query of collision.primitive costs: a ball that slides over the duck, is pressed into it and lifted off, as
// primitive collision finds it and as an exact search of all faces does, and pairs of primitives.
//
//   primitive_bench build/release/meshes/duck.off
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "framework/core/check.hpp"
#include "nodes/collision/exact.hpp"
#include "nodes/collision/primitive.hpp"
#include "nodes/physics/cgal/exact_distance.hpp"
#include "nodes/physics/mesh/body_mesh.hpp"
#include "tests/support/nodes.hpp"

using namespace tactor;

namespace {

Body body(const std::string& name, const Shape& shape, Motion motion = Motion::fixed) {
  Body b;
  b.name = name;
  b.shape = shape;
  b.motion = motion;
  return b;
}

/// Centres of a ball of radius r round the mesh, the surface's distance from the ball going from -0.5 to `lift` mm and
/// back at 0.05 to 0.1 m/s and 1 kHz.
std::vector<Vec3> slide(const TriangleMesh& mesh, double r, double lift) {
  const ExactDistance distance(mesh);
  Vec3 middle;
  for (const Vec3& v : mesh.vertices) middle += v / static_cast<double>(mesh.vertices.size());
  std::vector<Vec3> path;
  for (int i = 0; i < 20'000; ++i) {
    const double t = 1e-3 * i;
    const double gap = r - 0.0005 + (lift + 0.0005) * 0.5 * (1 - std::cos(2 * t));
    Vec3 way{std::cos(1.3 * t) * std::cos(0.7 * t), std::sin(1.3 * t) * std::cos(0.7 * t), std::sin(0.7 * t)};
    double low = 0, high = 0.5;
    int hint = -1;
    while (high - low > 1e-9) {
      const double at = 0.5 * (low + high);
      const Nearest n = distance.nearest(middle + at * way, hint);
      hint = n.face;
      (n.distance < gap ? low : high) = at;
    }
    path.push_back(middle + low * way);
  }
  return path;
}

struct Metrics {
  double median, p99, contacts;
};

template <class Query>
Metrics measure(const std::vector<Vec3>& path, const Query& query) {
  std::vector<double> ns;
  double contacts = 0;
  ContactSet set;
  for (int round = 0; round < 3; ++round) {
    for (const Vec3& p : path) {
      const auto begin = std::chrono::steady_clock::now();
      query(p, set);
      const auto end = std::chrono::steady_clock::now();
      if (round == 0) continue;
      ns.push_back(std::chrono::duration<double, std::nano>(end - begin).count());
      contacts += set.count;
    }
  }
  const auto at = [&](double share) {
    const auto k = static_cast<std::ptrdiff_t>(share * static_cast<double>(ns.size()));
    std::nth_element(ns.begin(), ns.begin() + k, ns.end());
    return ns[static_cast<std::size_t>(k)];
  };
  return {at(0.5), at(0.99), contacts / static_cast<double>(ns.size())};
}

template <class N>
Metrics measure_node(const Scene& scene, const std::vector<Vec3>& path) {
  N node(test::default_params<N>(), test::context_for(scene));
  return measure(path, [&](const Vec3& p, ContactSet& set) { node.query({p, {}}, set); });
}

void print(const std::string& name, const Metrics& f, const Metrics& clock) {
  std::printf("%-58s %8.0f %8.0f ns  %5.2f contacts\n", name.c_str(), f.median - clock.median, f.p99 - clock.median,
              f.contacts);
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: primitive_bench DUCK.off\n");
    return 2;
  }
  const std::string file = arguments[1];
  const TriangleMesh duck = load_body_mesh(body("duck", MeshShape{file}));
  const double r = 0.004;
  Scene scene;
  scene.bodies = {body("duck", MeshShape{file}), body("tool", SphereShape{r}, Motion::translation)};
  const std::vector<Vec3> near = slide(duck, r, 0.001), far = slide(duck, r, 0.1);
  const Metrics clock = measure(near, [](const Vec3&, ContactSet& set) { set.count = 0; });
  std::printf("%-58s %8s %8s\n", "a query, less the clock's own", "median", "p99");
  for (const auto& [name, path] : {std::pair{"within 1 mm", &near}, std::pair{"up to 100 mm away", &far}}) {
    print(std::string("ball on duck, ") + name + ": collision.primitive",
          measure_node<PrimitiveCollision>(scene, *path), clock);
    print(std::string("ball on duck, ") + name + ": collision.exact", measure_node<ExactCollision>(scene, *path),
          clock);
  }
  for (const auto& [name, tool] : {std::pair<const char*, Shape>{"ball", SphereShape{r}},
                                   std::pair<const char*, Shape>{"capsule", CapsuleShape{r, 0.02}},
                                   std::pair<const char*, Shape>{"box", BoxShape{{0.008, 0.008, 0.02}}}}) {
    scene.bodies = {body("tool", tool, Motion::rigid), body("floor", PlaneShape{}),
                    body("block", BoxShape{{0.05, 0.05, 0.05}}), body("ball", SphereShape{0.03})};
    scene.bodies[1].X_WB.p = {0, 0, -0.03};
    scene.bodies[2].X_WB.p = {0.03, 0, 0};
    scene.bodies[3].X_WB.p = {-0.04, 0, 0.02};
    print(std::string(name) + " among plane, box and sphere", measure_node<PrimitiveCollision>(scene, near), clock);
  }
  scene.bodies = {body("tool", SphereShape{r}, Motion::translation)};
  for (int i = 0; i < 100; ++i) {
    scene.bodies.push_back(body("ball" + std::to_string(i), SphereShape{0.01}));
    scene.bodies.back().X_WB.p = {0.03 * i, 1, 0};
  }
  print("ball among 100 spheres out of reach", measure_node<PrimitiveCollision>(scene, near), clock);
  return 0;
}
