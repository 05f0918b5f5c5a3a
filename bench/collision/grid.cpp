#include "bench/collision/grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "nodes/collision/exact_distance.hpp"

namespace tactor::bench {

namespace {

struct Value {
  double distance = 0;  // m
  Vec3 gradient;
};

class Grid {
 public:
  Grid(const TriangleMesh& mesh, int cells) {
    Vec3 low = mesh.vertices.front(), high = low;
    for (const Vec3& v : mesh.vertices) {
      for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], v[k]), high[k] = std::max(high[k], v[k]);
    }
    const Vec3 size = high - low;
    cell_ = std::max({size.x, size.y, size.z}) / cells;
    // Two cells of room around it.
    origin_ = low - Vec3{2 * cell_, 2 * cell_, 2 * cell_};
    for (int k = 0; k < 3; ++k) corners_[index(k)] = static_cast<int>(std::ceil(size[k] / cell_)) + 5;
    values_.resize(index(corners_[0]) * index(corners_[1]) * index(corners_[2]));
    fill(ExactDistance(mesh, "grid"));
  }

  /// By how much a sphere must be further out than it is large to be left out.
  [[nodiscard]] double slack() const { return 2 * cell_; }

  [[nodiscard]] Value at(const Vec3& x) const {
    std::array<std::size_t, 3> i{};
    Vec3 u;
    double outside = 0;
    for (int k = 0; k < 3; ++k) {
      const double scaled = (x[k] - origin_[k]) / cell_;
      const double inside = std::clamp(scaled, 0.0, corners_[index(k)] - 1.001);
      outside = std::max(outside, std::abs(scaled - inside));
      i[index(k)] = static_cast<std::size_t>(inside);
      u[k] = inside - std::floor(inside);
    }
    if (outside > 0) return {cell_ * (outside + 1), {}};
    const float* v = &values_[place(i[0], i[1], i[2])];
    const std::size_t dy = index(corners_[0]), dz = dy * index(corners_[1]);
    const auto c = [&](std::size_t offset) { return static_cast<double>(v[offset]); };
    const auto mix = [](double a, double b, double t) { return a + t * (b - a); };
    const double x00 = mix(c(0), c(1), u.x), x10 = mix(c(dy), c(dy + 1), u.x);
    const double x01 = mix(c(dz), c(dz + 1), u.x), x11 = mix(c(dy + dz), c(dy + dz + 1), u.x);
    const double y0 = mix(x00, x10, u.y), y1 = mix(x01, x11, u.y);
    const double gx =
        mix(mix(c(1) - c(0), c(dy + 1) - c(dy), u.y), mix(c(dz + 1) - c(dz), c(dy + dz + 1) - c(dy + dz), u.y), u.z);
    const Vec3 g{gx, mix(x10 - x00, x11 - x01, u.z), y1 - y0};
    const double length = norm(g);
    return {mix(y0, y1, u.z), length > 0 ? g / length : g};
  }

 private:
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] std::size_t place(std::size_t i, std::size_t j, std::size_t k) const {
    return i + index(corners_[0]) * (j + index(corners_[1]) * k);
  }

  /// Exact within `band` of the surface; further away blocks of corners share a bound that is too near.
  void fill(const ExactDistance& exact) {
    constexpr int block = 8;
    constexpr double band = 0.004;  // m
    int hint = -1;
    for (int k = 0; k < corners_[2]; k += block) {
      for (int j = 0; j < corners_[1]; j += block) {
        for (int i = 0; i < corners_[0]; i += block) {
          const double half = 0.5 * (block - 1);
          const Nearest middle = exact.query(origin_ + cell_ * Vec3{i + half, j + half, k + half}, hint);
          hint = middle.face;
          const double spare = std::abs(middle.distance) - std::sqrt(3.0) * half * cell_;
          for (int c = k; c < std::min(k + block, corners_[2]); ++c) {
            for (int b = j; b < std::min(j + block, corners_[1]); ++b) {
              for (int a = i; a < std::min(i + block, corners_[0]); ++a) {
                double d = std::copysign(spare, middle.distance);
                if (spare < band) {
                  const Vec3 x = origin_ + cell_ * Vec3{double(a), double(b), double(c)};
                  const Nearest nearest = exact.query(x, hint);
                  d = nearest.distance, hint = nearest.face;
                }
                values_[place(index(a), index(b), index(c))] = static_cast<float>(d);
              }
            }
          }
        }
      }
    }
  }

  double cell_ = 0;  // m
  Vec3 origin_;
  std::array<int, 3> corners_{};
  std::vector<float> values_;
};

/// Bounding spheres over samples, halved along the longest side.
class Spheres {
 public:
  explicit Spheres(const std::vector<SurfaceSample>& samples) : samples_(samples) {
    std::vector<int> order(samples.size());
    std::iota(order.begin(), order.end(), 0);
    build(order.begin(), order.end());
  }

  /// Calls found(sample, x in the frame of the grid, value) for each sample inside.
  template <class F>
  void find(const Grid& grid, const Pose& X_OB, F&& found) const {
    for (std::size_t i = 0; i < nodes_.size();) {
      const Node& node = nodes_[i];
      const Vec3 x = transform(X_OB, node.center);
      const Value value = grid.at(x);
      if (node.sample >= 0) {
        if (value.distance < 0) found(node.sample, x, value);
        ++i;
      } else {
        i = value.distance > node.radius + grid.slack() ? node.after : i + 1;
      }
    }
  }

 private:
  using Iterator = std::vector<int>::iterator;
  struct Node {
    Vec3 center;
    double radius = 0;
    int sample = -1;
    std::size_t after = 0;
  };

  [[nodiscard]] const Vec3& at(int i) const { return samples_[static_cast<std::size_t>(i)].p; }

  void build(Iterator begin, Iterator end) {
    const std::size_t me = nodes_.size();
    nodes_.push_back({at(*begin), 0, *begin, me + 1});
    if (end - begin == 1) return;
    Vec3 low = at(*begin), high = low;
    for (auto i = begin; i != end; ++i) {
      for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], at(*i)[k]), high[k] = std::max(high[k], at(*i)[k]);
    }
    Node node{0.5 * (low + high), 0, -1, 0};
    for (auto i = begin; i != end; ++i) node.radius = std::max(node.radius, norm(at(*i) - node.center));
    const Vec3 size = high - low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const auto middle = begin + (end - begin) / 2;
    std::nth_element(begin, middle, end, [&](int a, int b) { return at(a)[axis] < at(b)[axis]; });
    build(begin, middle);
    build(middle, end);
    node.after = nodes_.size();
    nodes_[me] = node;
  }

  const std::vector<SurfaceSample>& samples_;
  std::vector<Node> nodes_;
};

class Trilinear final : public Contender {
 public:
  Trilinear(const Pair& pair, int cells)
      : fixed_(pair.fixed.mesh, cells),
        tool_(pair.tool.mesh, cells),
        of_fixed_(pair.fixed.samples),
        of_tool_(pair.tool.samples) {}

  void query(const Step& step) override {
    found_.clear();
    const Pose& X = step.X_AB;
    of_tool_.find(fixed_, X, [&](int sample, const Vec3& x, const Value& v) {
      found_.push_back({x, v.gradient, -v.distance, Side::tool, sample});
    });
    of_fixed_.find(tool_, inverse(X), [&](int sample, const Vec3& x, const Value& v) {
      found_.push_back({transform(X, x), -rotate(X.R, v.gradient), -v.distance, Side::fixed, sample});
    });
  }
  [[nodiscard]] bool touching() const override { return !found_.empty(); }
  [[nodiscard]] Touches touches() const override { return found_; }

 private:
  Grid fixed_, tool_;
  Spheres of_fixed_, of_tool_;
  Touches found_;
};

}  // namespace

std::unique_ptr<Contender> make_trilinear(const Pair& pair, int cells) {
  return std::make_unique<Trilinear>(pair, cells);
}

}  // namespace tactor::bench
