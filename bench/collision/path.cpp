#include "bench/collision/path.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/collision/quantile.hpp"
#include "framework/core/check.hpp"
#include "nodes/physics/cgal/exact_distance.hpp"
#include "nodes/physics/geometry/sample_tree.hpp"

namespace tactor::bench {

namespace {

/// The depth of the deepest vertex of either body in the other.
class Deepest {
 public:
  explicit Deepest(const Pair& pair)
      : fixed_(pair.fixed.mesh),
        tool_(pair.tool.mesh),
        of_fixed_(vertex_samples(pair.fixed.mesh).points),
        of_tool_(vertex_samples(pair.tool.mesh).points) {}

  /// m; -reach where none is nearer than that.
  double operator()(const Pose& X_AB) {
    double least = reach;
    const auto look = [&](SampleTree& tree, const ExactDistance& other, const Pose& X) {
      for (const NearSample& n : tree.find(other, X, reach)) least = std::min(least, n.distance);
    };
    look(of_tool_, fixed_, X_AB);
    look(of_fixed_, tool_, inverse(X_AB));
    return -least;
  }

  static constexpr double reach = 3e-4;  // m

 private:
  ExactDistance fixed_, tool_;
  SampleTree of_fixed_, of_tool_;
};

double wave(double t, double frequency, double phase = 0) {
  return std::sin(2 * std::numbers::pi * frequency * t + phase);
}

Pose slide_and_turn(double t) {
  constexpr double degree = std::numbers::pi / 180;
  return {
      {0.008 * wave(t, 0.5), 0.006 * wave(t, 0.35, 0.6), 0},
      from_rotation_vector({8 * degree * wave(t, 0.25), 6 * degree * wave(t, 0.3, 1), 8 * degree * wave(t, 0.2, 2)})};
}

/// 0 to 1 and back in 1.75 s.
double depth_profile(double t) {
  return 0.5 * (1 - std::cos(2 * std::numbers::pi * t / 1.75));
}

double extent(const TriangleMesh& mesh) {
  double most = 0;
  for (const Vec3& v : mesh.vertices) most = std::max(most, norm(v));
  return most;
}

}  // namespace

std::vector<Step> press_and_slide(const Pair& pair, const Samples& samples, double deepest) {
  Deepest depth(pair);
  const double apart = extent(pair.fixed.mesh) + extent(pair.tool.mesh);
  double offset = apart;
  bool met = false;
  std::vector<Step> steps;
  for (int i = 0; i < samples.count; ++i) {
    const double t = samples.begin + i * samples.period;
    Pose X = slide_and_turn(t);
    const double wanted = deepest * depth_profile(t);
    const auto too_deep = [&](double z) {
      X.p.z = z;
      return depth(X) > wanted;
    };
    // From outside, or from the last offset, to a bracket of it; no step is so long that it could jump through a part.
    const double stride = met ? 2e-4 : 2e-3;
    double high = offset, low = offset;
    while (too_deep(high)) high += stride;
    if (high == offset) {
      while (!too_deep(low)) {
        high = low;
        low -= stride;
        if (low < -apart) throw RunError("press and slide: the bodies do not meet along z");
      }
    } else {
      low = high - stride;
    }
    met = true;
    while (high - low > 1e-9) {
      const double middle = 0.5 * (low + high);
      (too_deep(middle) ? low : high) = middle;
    }
    offset = high;
    X.p.z = offset;
    steps.push_back({X, {}});
  }
  return steps;
}

std::vector<Step> insert_peg(const Samples& samples) {
  constexpr double degree = std::numbers::pi / 180;
  struct WayPoint {
    double t;
    Vec3 p, r;  // m, rotation vector in rad
  };
  static constexpr WayPoint points[] = {{0, {0, 0, 0.060}, {}},
                                        {1, {0, 0, 0.060}, {}},
                                        {2, {0.001, 0, 0.036}, {}},
                                        {3, {0, 0, 0.034}, {2 * degree, 0, 0}},
                                        {4, {0, 0, 0.020}, {0, -2 * degree, 0}},
                                        {5, {0.0008, 0, 0.005}, {}},
                                        {6, {0, -0.0008, 0.005}, {0, 0, 20 * degree}},
                                        {7, {0, 0, 0.015}, {-2 * degree, 0, 0}},
                                        {8, {0, 0, 0.060}, {}}};
  std::vector<Step> steps;
  std::size_t leg = 0;
  for (int i = 0; i < samples.count; ++i) {
    const double t = samples.begin + i * samples.period;
    while (leg + 2 < std::size(points) && t >= points[leg + 1].t) ++leg;
    const WayPoint &a = points[leg], &b = points[leg + 1];
    const double u = std::clamp((t - a.t) / (b.t - a.t), 0.0, 1.0);
    const double s = u * u * u * (10 + u * (6 * u - 15));
    steps.push_back({{a.p + s * (b.p - a.p), from_rotation_vector(a.r + s * (b.r - a.r))}, {}});
  }
  return steps;
}

void add_exact(Contender& reference, std::vector<Step>& steps) {
  for (Step& step : steps) {
    reference.query(step);
    step.exact = reference.touches();
    step.exact.shrink_to_fit();
  }
}

nlohmann::ordered_json describe(const std::vector<Step>& steps, double period) {
  constexpr double per_degree = 180 / std::numbers::pi;
  std::vector<double> slide, turn, press, depth, inside;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    double deepest = 0;
    for (const Touch& touch : steps[i].exact) deepest = std::max(deepest, touch.depth);
    depth.push_back(1e3 * deepest);
    inside.push_back(static_cast<double>(steps[i].exact.size()));
    if (i == 0) continue;
    const Pose &a = steps[i - 1].X_AB, &b = steps[i].X_AB;
    slide.push_back(1e3 * std::hypot(b.p.x - a.p.x, b.p.y - a.p.y) / period);
    press.push_back(1e3 * std::abs(b.p.z - a.p.z) / period);
    turn.push_back(per_degree * norm(to_rotation_vector(b.R * inverse(a.R))) / period);
  }
  const auto spread = [](std::vector<double> values) -> nlohmann::ordered_json {
    return {{"median", quantile(values, 0.5)}, {"max", quantile(values, 1)}};
  };
  return {{"samples", steps.size()},         {"rate_hz", 1 / period},      {"slide_mm_s", spread(slide)},
          {"along_z_mm_s", spread(press)},   {"turn_deg_s", spread(turn)}, {"deepest_mm", spread(depth)},
          {"samples_inside", spread(inside)}};
}

}  // namespace tactor::bench
