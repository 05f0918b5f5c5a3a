#include "nodes/scene/surface_samples.hpp"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

constexpr std::size_t most_samples = 1'000'000;

class Refinement {
 public:
  Refinement(const TriangleMesh& mesh, double spacing) : spacing_(spacing) {
    for (const Vec3& v : mesh.vertices) samples_.push_back({v, 0});
    for (const auto& face : mesh.faces) split(face);
  }
  std::vector<SurfaceSample> take() { return std::move(samples_); }

 private:
  const Vec3& at(int i) const { return samples_[static_cast<std::size_t>(i)].p; }

  void split(const std::array<int, 3>& face) {
    std::size_t longest = 0;
    double longest_length = -1;
    for (std::size_t i = 0; i < 3; ++i) {
      const double length = norm(at(face[(i + 1) % 3]) - at(face[i]));
      if (length > longest_length) longest = i, longest_length = length;
    }
    if (spacing_ <= 0 || longest_length <= spacing_) {
      const double third = norm(cross(at(face[1]) - at(face[0]), at(face[2]) - at(face[0]))) / 6.0;
      for (const int corner : face) samples_[static_cast<std::size_t>(corner)].area += third;
      return;
    }
    const int a = face[longest], b = face[(longest + 1) % 3], c = face[(longest + 2) % 3];
    const int m = midpoint(a, b);
    split({a, m, c});
    split({m, b, c});
  }

  /// Both faces of an edge share its midpoint.
  int midpoint(int a, int b) {
    const auto [entry, added] = midpoints_.try_emplace(std::minmax(a, b), static_cast<int>(samples_.size()));
    if (added) {
      if (samples_.size() == most_samples) {
        throw InputError("a spacing of " + std::to_string(1e3 * spacing_) + " mm gives this mesh more than " +
                         std::to_string(most_samples) + " contact samples; give a larger one");
      }
      samples_.push_back({0.5 * (at(a) + at(b)), 0});
    }
    return entry->second;
  }

  double spacing_;
  std::vector<SurfaceSample> samples_;
  std::map<std::pair<int, int>, int> midpoints_;
};

}  // namespace

std::vector<SurfaceSample> sample_surface(const TriangleMesh& mesh, double spacing) {
  return Refinement(mesh, spacing).take();
}

}  // namespace tactor
