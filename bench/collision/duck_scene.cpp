#include <cmath>
#include <numbers>

#include "bench/collision/closest_point.hpp"
#include "bench/collision/measure.hpp"
#include "bench/collision/quantile.hpp"
#include "bench/collision/scenes.hpp"
#include "bench/collision/timed_loop.hpp"
#include "nodes/physics/cgal/exact_distance.hpp"
#include "nodes/physics/mesh/solid_file.hpp"

namespace tactor::bench {

namespace {

using Json = nlohmann::ordered_json;

struct Point {
  Vec3 x;               // m, in the frame of the mesh
  double distance = 0;  // m, exact, negative inside
};

/// A point that creeps over the surface at 50 mm/s in directions that turn, from 1 mm inside to 1 mm outside.
std::vector<Point> beside(const ExactDistance& exact, int count) {
  constexpr double period = 0.001, speed = 0.05, height = 0.001;
  std::vector<Point> points;
  Nearest on = exact.nearest({0, 0, 1});
  for (int i = 0; i < count; ++i) {
    const double t = i * period;
    const Vec3 heading{std::cos(1.7 * t), std::sin(1.1 * t), std::sin(0.6 * t + 1)};
    const Vec3 along = heading - dot(heading, on.gradient) * on.gradient;
    // The step goes off the surface where that is curved; the next nearest point is back on it.
    on = exact.nearest(on.p + speed * period / norm(along) * along + 1e-4 * on.gradient, on.face);
    const Vec3 x = on.p + height * std::sin(2 * std::numbers::pi * t) * on.gradient;
    points.push_back({x, exact.nearest(x, on.face).distance});
  }
  return points;
}

/// Rounds about the duck, further and further out, to 1 m.
std::vector<Point> far(const ExactDistance& exact, int count) {
  std::vector<Point> points;
  int hint = -1;
  for (int i = 0; i < count; ++i) {
    const double u = static_cast<double>(i) / count, angle = 20 * u;
    const double r = 0.08 * std::pow(12.5, u);
    const Vec3 x = r * Vec3{std::cos(angle) * std::cos(3 * u), std::sin(angle) * std::cos(3 * u), std::sin(3 * u)};
    const Nearest nearest = exact.nearest(x, hint);
    hint = nearest.face;
    points.push_back({x, nearest.distance});
  }
  return points;
}

struct Candidate {
  const ClosestPointEntry* entry = nullptr;
  std::unique_ptr<ClosestPoint> contender;
  double build_ms = 0, memory_mb = 0;
};

/// The times in us and the distances that each finds, in turns of 100. After a rest the point before is asked again,
/// not timed.
void run(const std::vector<Candidate>& all, const std::vector<Point>& points, std::vector<std::vector<double>>& us,
         std::vector<std::vector<double>>& found) {
  constexpr std::size_t block = 100;
  TimedLoop loop;
  std::size_t round = 0;
  for (std::size_t begin = 0; begin < points.size(); begin += block, ++round) {
    for (std::size_t k = 0; k < all.size(); ++k) {
      const std::size_t who = (k + round) % all.size();
      for (std::size_t i = begin; i < std::min(begin + block, points.size()); ++i) {
        if (loop.rest_if_due() && i > 0) all[who].contender->distance(points[i - 1].x);
        double distance = 0;
        us[who].push_back(microseconds([&] { distance = all[who].contender->distance(points[i].x); }));
        found[who].push_back(distance);
      }
    }
  }
}

/// Runs all over the points and compares with the exact distances.
Json measure_points(std::vector<Candidate>& all, const std::vector<Point>& points) {
  std::vector<std::vector<double>> us(all.size()), found(all.size());
  run(all, points, us, found);
  Json rows = Json::array();
  for (std::size_t k = 0; k < all.size(); ++k) {
    std::vector<double> error;
    std::size_t wrong_sign = 0;
    const bool sign = all[k].entry->sign == Sign::inside_negative;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double exact = points[i].distance;
      error.push_back(1e6 * std::abs(found[k][i] - (sign ? exact : std::abs(exact))));
      wrong_sign += sign && found[k][i] * exact < 0;
    }
    Json row = {{"name", all[k].entry->name},
                {"us", spread_of(us[k])},
                {"ratio_median", quantile(us[k], 0.5) / quantile(us[0], 0.5)},
                {"ratio_p99", quantile(us[k], 0.99) / quantile(us[0], 0.99)},
                {"signed", sign},
                {"error_um", spread_of(error)}};
    if (sign) row["wrong_sign"] = wrong_sign;
    row["memory_MB"] = all[k].memory_mb;
    row["build_ms"] = all[k].build_ms;
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

Json duck_scene(const SceneOptions& options) {
  const TriangleMesh mesh = load_solid(options.meshes / "duck.off").mesh;
  const ExactDistance exact(mesh);
  const std::vector<ClosestPointEntry> entries = {{"tactor", Sign::inside_negative, make_cell_distance},
                                                  {"tactor, exact", Sign::inside_negative, make_exact_distance},
                                                  {"CGAL", Sign::none, make_cgal_closest},
                                                  {"Embree, float", Sign::none, make_embree},
                                                  {"FCL double", Sign::none, make_fcl_distance}};
  std::vector<Candidate> all;
  for (const ClosestPointEntry& entry : entries) {
    Candidate r{&entry, nullptr, 0, 0};
    const std::size_t before = heap_in_use();
    r.build_ms = 1e-3 * microseconds([&] { r.contender = entry.make(mesh); });
    r.memory_mb = 1e-6 * (static_cast<double>(heap_in_use()) - static_cast<double>(before));
    all.push_back(std::move(r));
  }
  return {{"triangles", mesh.faces.size()},
          {"points", options.samples},
          {"beside", measure_points(all, beside(exact, options.samples))},
          {"far", measure_points(all, far(exact, options.samples))}};
}

}  // namespace tactor::bench
