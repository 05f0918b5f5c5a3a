#include "nodes/physics/mesh/surface_samples.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "framework/core/check.hpp"
#include "nodes/physics/mesh/refine.hpp"

namespace tactor {

namespace {

/// The longest edge between candidates, in spacings.
constexpr double candidate_share = 0.25;
/// The cosine of the largest angle between the normal of a sample's face and those it stands for.
constexpr double same_sheet = 0.5;

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// The faces at each vertex.
class Fans {
 public:
  explicit Fans(const TriangleMesh& mesh) : begin_(mesh.vertices.size() + 2), faces_(3 * mesh.faces.size()) {
    for (const auto& face : mesh.faces) {
      for (const int v : face) ++begin_[index(v) + 2];
    }
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    // Each entry moves up from where its vertex begins to where the next one does.
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      for (const int v : mesh.faces[f]) faces_[begin_[index(v) + 1]++] = f;
    }
  }

  template <class F>
  void for_each(int v, F&& look) const {
    for (std::size_t i = begin_[index(v)]; i < begin_[index(v) + 1]; ++i) look(faces_[i]);
  }

 private:
  std::vector<std::size_t> begin_, faces_;
};

/// Finds how the surface about each sample faces, and the creases that samples are at. `owner`: of each vertex, the
/// sample that it gives its area to; `normal`: of each face, unit, or zero where it has none.
template <class Owner, class Normal>
void add_facing(const TriangleMesh& mesh, const Owner& owner, const Normal& normal, SurfaceSamples& samples) {
  // The faces of each sample, once for each corner that it owns.
  std::vector<std::size_t> begin(samples.points.size() + 2);
  std::vector<std::uint32_t> faces(3 * mesh.faces.size());
  for (const auto& face : mesh.faces) {
    for (const int v : face) ++begin[index(owner(v)) + 2];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (const int v : mesh.faces[f]) faces[begin[index(owner(v)) + 1]++] = static_cast<std::uint32_t>(f);
  }
  std::vector<FacingArea> about;
  for (std::size_t s = 0; s < samples.points.size(); ++s) {
    about.clear();
    bool alike = true;
    Vec3 sum;  // m^2
    for (std::size_t i = begin[s]; i < begin[s + 1]; ++i) {
      const Vec3& n = normal(faces[i]);
      if (n == Vec3{}) continue;
      const double third = norm(doubled_area_normal(mesh, mesh.faces[faces[i]])) / 6;
      if (about.empty() || !(about.back().normal == n)) {
        about.push_back({0, n});
        alike = alike && dot(about.front().normal, n) >= same_part;
      }
      about.back().area += third;
      sum += third * n;
    }
    if (norm(sum) > 0) samples.points[s].normal = sum / norm(sum);
    if (alike) continue;
    if (const std::optional<Crease> crease = find_crease(about)) {
      samples.points[s].crease = static_cast<std::int32_t>(samples.creases.size());
      samples.creases.push_back(*crease);
    }
  }
}

/// Unit, or zero where the face has no area.
Vec3 unit_normal(const TriangleMesh& mesh, const std::array<int, 3>& face) {
  const Vec3 n = doubled_area_normal(mesh, face);
  return norm(n) > 0 ? n / norm(n) : Vec3{};
}

/// Greedy elimination: a candidate is kept unless one kept before stands for it, so candidates that come first decide.
class Elimination {
 public:
  Elimination(const TriangleMesh& mesh, double spacing)
      : refined_(refine(mesh, candidate_share * spacing)),
        fans_(refined_.mesh),
        radius_(spacing * (1 - candidate_share / std::sqrt(3.0))),
        nearest_(points().size(), std::numeric_limits<double>::infinity()),
        owner_(points().size(), -1),
        seen_(points().size(), -1) {
    // A face without area has no normal; its corners are those of others.
    for (const auto& face : mesh.faces) normals_.push_back(unit_normal(mesh, face));
    for (const int candidate : in_order(mesh.vertices.size())) {
      if (owner_[index(candidate)] < 0) keep(candidate);
    }
  }

  SurfaceSamples samples() {
    SurfaceSamples samples{std::move(samples_), {}};
    for (const auto& face : refined_.mesh.faces) {
      const double third = norm(doubled_area_normal(refined_.mesh, face)) / 6;
      for (const int corner : face) samples.points[index(owner_[index(corner)])].area += third;
    }
    add_facing(
        refined_.mesh, [this](int v) { return owner_[index(v)]; },
        [this](std::uint32_t face) -> const Vec3& { return normals_[index(refined_.parent_face[face])]; }, samples);
    return samples;
  }

 private:
  const std::vector<Vec3>& points() const { return refined_.mesh.vertices; }

  /// Those of the faces at a candidate, without those in the plane of another.
  void find_normals(int candidate, std::vector<Vec3>& found) const {
    found.clear();
    int last = -1;
    fans_.for_each(candidate, [&](std::size_t face) {
      const int parent = refined_.parent_face[face];
      if (parent == last) return;
      last = parent;
      const Vec3& n = normals_[index(parent)];
      if (n == Vec3{}) return;
      if (std::none_of(found.begin(), found.end(), [&](const Vec3& o) { return dot(o, n) > 1 - 1e-12; })) {
        found.push_back(n);
      }
    });
  }

  /// Corners, then edges, then the rest; of alike ones vertices of the mesh, then in an order without a pattern.
  std::vector<int> in_order(std::size_t mesh_vertices) const {
    std::vector<std::pair<std::uint64_t, int>> keyed;
    keyed.reserve(points().size());
    std::vector<Vec3> around;
    for (std::size_t i = 0; i < points().size(); ++i) {
      const int candidate = static_cast<int>(i);
      find_normals(candidate, around);
      // 1 on a face, 0.71 on an edge of a box, 0.58 at its corner; eighths, so that what differs little is alike.
      const Vec3 sum = std::accumulate(around.begin(), around.end(), Vec3{});
      const double size = std::max(1.0, static_cast<double>(around.size()));
      const auto flatness = static_cast<std::uint64_t>(std::lround(8 * norm(sum) / size));
      // Multiples of the golden ratio of 2^32 that overflow scatter, and no two of them are alike.
      const std::uint32_t scattered = static_cast<std::uint32_t>(i) * 2654435769U;
      keyed.emplace_back(flatness << 33 | std::uint64_t{i >= mesh_vertices} << 32 | scattered, candidate);
    }
    std::sort(keyed.begin(), keyed.end());
    std::vector<int> order;
    order.reserve(keyed.size());
    for (const auto& [key, candidate] : keyed) order.push_back(candidate);
    return order;
  }

  /// Keeps the candidate, and finds what it stands for by walking over the surface as far as it reaches.
  void keep(int kept) {
    const int sample = static_cast<int>(samples_.size());
    const Vec3 p = points()[index(kept)];
    samples_.push_back({.p = p});
    nearest_[index(kept)] = 0;
    owner_[index(kept)] = sample;
    find_normals(kept, own_);
    const auto visit = [&](int candidate) {
      if (seen_[index(candidate)] == sample) return;
      seen_[index(candidate)] = sample;
      to_visit_.push_back(candidate);
    };
    visit(kept);
    while (!to_visit_.empty()) {
      const int candidate = to_visit_.back();
      to_visit_.pop_back();
      const double distance = norm(points()[index(candidate)] - p);
      if (distance > radius_) continue;
      bool all = true;
      int last = -1;
      fans_.for_each(candidate, [&](std::size_t face) {
        for (const int corner : refined_.mesh.faces[face]) visit(corner);
        if (refined_.parent_face[face] == last) return;
        last = refined_.parent_face[face];
        const Vec3& n = normals_[index(last)];
        all = all && n != Vec3{} &&
              std::any_of(own_.begin(), own_.end(), [&](const Vec3& o) { return dot(o, n) >= same_sheet; });
      });
      if (all && distance < nearest_[index(candidate)]) {
        nearest_[index(candidate)] = distance;
        owner_[index(candidate)] = sample;
      }
    }
  }

  RefinedMesh refined_;
  Fans fans_;
  double radius_;              // m, how far from a sample the candidates are that it stands for
  std::vector<Vec3> normals_;  // of the faces of the mesh
  std::vector<double> nearest_;
  std::vector<int> owner_, seen_;  // samples, by candidates
  std::vector<SurfaceSample> samples_;
  std::vector<Vec3> own_;
  std::vector<int> to_visit_;
};

}  // namespace

SurfaceSamples vertex_samples(const TriangleMesh& mesh) {
  SurfaceSamples samples;
  samples.points.reserve(mesh.vertices.size());
  for (const Vec3& v : mesh.vertices) samples.points.push_back({.p = v});
  std::vector<Vec3> normals;
  normals.reserve(mesh.faces.size());
  for (const auto& face : mesh.faces) {
    const double third = norm(doubled_area_normal(mesh, face)) / 6;
    for (const int corner : face) samples.points[index(corner)].area += third;
    normals.push_back(unit_normal(mesh, face));
  }
  add_facing(
      mesh, [](int v) { return v; }, [&](std::uint32_t face) -> const Vec3& { return normals[face]; }, samples);
  return samples;
}

SurfaceSamples sample_surface(const TriangleMesh& mesh, double spacing) {
  TACTOR_DEMAND(spacing > 0);
  try {
    return Elimination(mesh, spacing).samples();
  } catch (const InputError& error) {
    throw InputError("a spacing of " + std::to_string(1e3 * spacing) + " mm is too small: " + error.what());
  }
}

}  // namespace tactor
