#include "nodes/forcefield/ball_cast.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/core/value_error.hpp"
#include "nodes/physics/geometry/face_tree.hpp"
#include "nodes/physics/geometry/shape_distance.hpp"
#include "nodes/physics/mesh/box_mesh.hpp"

namespace tactor {

namespace {

/// A way at a smaller angle to the surface, or that comes nearer to it by less than so many m, runs along it: what is
/// left of the rounding of a way in a plane.
constexpr double least_approach = 1e-12, least_approach_m = 1e-15;
/// Of a face's edge, by how much a face reaches beyond it, so that nothing falls between two of them.
constexpr double overlap = 1e-9;
/// An edge whose neighbour lies lower than this share of its length is convex.
constexpr double least_fold = 1e-9;
/// Of a face's longest edge: the normal of a face that is less high is off by more than 1e-7 for rounding. That of one
/// that is less than thin_height is too far off to tell whether a neighbour lies below it.
constexpr double least_height = 1e-9, thin_height = 1e-5;

Vec3 unit_or(const Vec3& v, const Vec3& otherwise) {
  const double length = norm(v);
  return length > 0 ? v / length : otherwise;
}

bool approaches(const Vec3& n, const Vec3& way) {
  return dot(n, way) < -(least_approach * norm(way) + least_approach_m);
}

/// When |m + t way| first is `radius`, t >= 0, coming nearer; none where it is not before `before`. For vectors across
/// an axis it is a cylinder that is met, else a ball.
std::optional<double> first_at(const Vec3& m, const Vec3& way, double radius, double before) {
  const double b = dot(m, way), c = dot(m, m) - radius * radius;
  if (b >= 0) return std::nullopt;
  if (c <= 0) return before > 0 ? std::optional(0.0) : std::nullopt;
  const double a = dot(way, way), square = b * b - a * c;
  if (square < 0) return std::nullopt;
  const double t = c / (-b + std::sqrt(square));
  return t < before ? std::optional(t) : std::nullopt;
}

/// A ball against the point that lies `m` away from its centre's begin, m to the centre. `before` as in BallHit::share.
bool meets_point(const Vec3& m, const Vec3& way, double radius, BallHit& hit) {
  const std::optional<double> t = first_at(m, way, radius, hit.share);
  if (!t) return false;
  const Vec3 out = m + *t * way, n = out / norm(out);
  if (!approaches(n, way)) return false;
  hit = {*t, true, n, std::max(0.0, radius - norm(out)), n};
  return true;
}

/// A ball against the segment from v along e; m from v to the centre. Returns the share of e, or none.
std::optional<double> meets_segment(const Vec3& m, const Vec3& e, const Vec3& way, double radius, BallHit& hit) {
  const double ee = dot(e, e);
  if (!(ee > 0)) return std::nullopt;
  const Vec3 across = m - (dot(m, e) / ee) * e, way_across = way - (dot(way, e) / ee) * e;
  const std::optional<double> t = first_at(across, way_across, radius, hit.share);
  if (!t) return std::nullopt;
  const double along = dot(m + *t * way, e) / ee;
  if (along < 0 || along > 1) return std::nullopt;
  const Vec3 out = across + *t * way_across, n = out / norm(out);
  if (!approaches(n, way)) return std::nullopt;
  hit = {*t, true, n, std::max(0.0, radius - norm(out)), n};
  return along;
}

/// A segment against eight boxes: which of them the ball may meet before `share`.
class SlabTest {
 public:
  SlabTest(const Vec3& from, const Vec3& way, double radius) : radius_(radius) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      from_[i] = from[axis];
      // Without a component along the axis the quotient is far outside of the way, on either side.
      const double w = way[axis];
      inverse_[i] = 1 / (std::abs(w) > 1e-100 ? w : std::copysign(1e-100, w));
    }
  }
  [[nodiscard]] bool may_meet(const FaceTree::Node& node, std::size_t k, double share) const {
    double begin = 0, end = share;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double low = (static_cast<double>(node.low[axis][k]) - radius_ - from_[axis]) * inverse_[axis];
      const double high = (static_cast<double>(node.high[axis][k]) + radius_ - from_[axis]) * inverse_[axis];
      begin = std::max(begin, std::min(low, high));
      end = std::min(end, std::max(low, high));
    }
    return begin <= end;
  }

 private:
  std::array<double, 3> from_{}, inverse_{};
  double radius_;
};

/// Of its longest edge; 0 where it has no area.
double height_share(const TriangleMesh& mesh, const std::array<int, 3>& face) {
  double longest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto at = [&](std::size_t k) { return mesh.vertices[static_cast<std::size_t>(face[k % 3])]; };
    longest = std::max(longest, norm(at(i + 1) - at(i)));
  }
  return longest > 0 ? norm(doubled_area_normal(mesh, face)) / (longest * longest) : 0;
}

TriangleMesh without_needles(TriangleMesh mesh) {
  std::erase_if(mesh.faces, [&](const auto& face) { return !(height_share(mesh, face) > least_height); });
  if (mesh.faces.empty()) throw InputError("no face of the mesh has an area");
  return mesh;
}

/// The solid angle of a face about x over 4 pi, positive from behind: the sum over a closed mesh is 1 inside and 0
/// outside (A. Van Oosterom, J. Strackee, "The solid angle of a plane triangle", 1983).
double turns_about(const std::array<Vec3, 3>& corners, const Vec3& x) {
  const Vec3 a = corners[0] - x, b = corners[1] - x, c = corners[2] - x;
  const double A = norm(a), B = norm(b), C = norm(c);
  const double volume = dot(a, cross(b, c));
  return std::atan2(volume, A * B * C + dot(a, b) * C + dot(b, c) * A + dot(c, a) * B) / (2 * std::numbers::pi);
}

class MeshBallSurface final : public BallSurface {
 public:
  /// `mesh` has no needles.
  MeshBallSurface(const TriangleMesh& mesh, double crease) : surface_(mesh), tree_(surface_) { prepare(mesh, crease); }

  bool cast(const Vec3& from, const Vec3& way, double radius, BallHit& hit, int& looks) const override {
    const SlabTest slabs(from - tree_.origin, way, radius);
    std::array<std::int32_t, 8 * FaceTree::most_levels> open;
    std::size_t count = 0;
    open[count++] = 0;
    while (count > 0) {
      const std::int32_t next = open[--count];
      if (looks <= 0) return false;
      if (next < 0) {
        for (std::int32_t k = 0; k < 8; ++k) {
          const std::int32_t face = tree_.records[static_cast<std::size_t>(~next + k)].face;
          if (face < 0) continue;
          --looks;
          cast_face(static_cast<std::size_t>(face), from, way, radius, hit);
        }
        continue;
      }
      --looks;
      const FaceTree::Node& node = tree_.nodes[static_cast<std::size_t>(next)];
      for (std::size_t k = 0; k < 8; ++k) {
        if (node.child[k] != FaceTree::no_child && slabs.may_meet(node, k, hit.share)) open[count++] = node.child[k];
      }
    }
    return true;
  }

  [[nodiscard]] Nearest nearest(const Vec3& x) const override {
    Nearest nearest = surface_.signed_distance(tree_.nearest(surface_, x, -1), x);
    const Border& border = borders_[static_cast<std::size_t>(nearest.face)];
    const bool one_sided = (nearest.feature == Feature::edge && border.edge_alone[nearest.of_face]) ||
                           (nearest.feature == Feature::corner && border.corner_alone[nearest.of_face]);
    if (!one_sided) return nearest;
    // The pseudo-normal lacks a face.
    const Vec3 away = x - nearest.p;
    const double length = norm(away);
    if (!(length > 0)) {
      nearest.gradient = surface_.normals[static_cast<std::size_t>(nearest.face)].face;
      return nearest;
    }
    double turns = 0;
    for (const auto& corners : surface_.corners) turns += turns_about(corners, x);
    const double sign = turns > 0.5 ? -1 : 1;
    nearest.distance = sign * length;
    nearest.gradient = away * (sign / length);
    return nearest;
  }

 private:
  /// Of a face: what of its border a ball can meet before it meets a face, and how it is shaded.
  struct Border {
    std::array<bool, 3> edge_met{}, corner_met{};
    std::array<bool, 3> edge_crease{}, corner_crease{};
    std::array<bool, 3> edge_alone{}, corner_alone{};  // no other face has the edge; the corner is the end of such
    std::array<Vec3, 3> shaded;                        // unit, at the corners
  };

  void cast_face(std::size_t face, const Vec3& from, const Vec3& way, double radius, BallHit& hit) const {
    // The ball passes the ball about the face: there is nothing to meet.
    const Vec3 away = middles_[face].p - from;
    const double nearest = std::clamp(dot(away, way) / std::max(dot(way, way), 1e-300), 0.0, hit.share);
    const Vec3 apart = away - nearest * way;
    const double reach = radius + middles_[face].radius;
    if (dot(apart, apart) > reach * reach) return;
    const std::array<Vec3, 3>& corner = surface_.corners[face];
    const Vec3& n = surface_.normals[face].face;
    // All from the ball's begin, so that a small radius does not drown in large coordinates.
    const std::array<Vec3, 3> v{corner[0] - from, corner[1] - from, corner[2] - from};
    const double above = -dot(n, v[0]), closing = -dot(n, way);
    // It stays above the face's plane, in which its edges and corners lie too.
    if (std::min(above, above - hit.share * closing) > radius * (1 + overlap)) return;
    if (above > 0 && approaches(n, way)) {
      const double t = std::max(0.0, (above - radius) / closing);
      if (t < hit.share) {
        const Vec3 centre = t * way, on = centre + dot(n, v[0] - centre) * n;
        std::array<double, 3> weight;  // twice the area beside edge i
        bool inside = true;
        for (std::size_t i = 0; i < 3; ++i) {
          const Vec3 e = v[(i + 1) % 3] - v[i];
          weight[i] = dot(cross(e, on - v[i]), n);
          inside = inside && weight[i] >= -overlap * dot(e, e);
        }
        if (inside) {
          const std::array<Vec3, 3>& s = borders_[face].shaded;
          const Vec3 sum = weight[1] * s[0] + weight[2] * s[1] + weight[0] * s[2];
          hit = {t, true, n, std::max(0.0, radius - above), unit_or(sum, n)};
          return;
        }
      }
    }
    const Border& border = borders_[face];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      if (border.edge_met[i]) {
        if (const auto along = meets_segment(-v[i], v[j] - v[i], way, radius, hit); along && !border.edge_crease[i]) {
          const Vec3 sum = (1 - *along) * border.shaded[i] + *along * border.shaded[j];
          hit.shaded = unit_or(sum, hit.n);
        }
      }
      if (border.corner_met[i] && meets_point(-v[i], way, radius, hit) && !border.corner_crease[i]) {
        hit.shaded = border.shaded[i];
      }
    }
  }

  void prepare(const TriangleMesh& mesh, double crease) {
    const double same = std::cos(crease);
    const std::size_t faces = mesh.faces.size();
    borders_.resize(faces);
    for (const auto& c : surface_.corners) {
      const Vec3 p = (c[0] + c[1] + c[2]) / 3;
      middles_.push_back({p, (1 + overlap) * std::max({norm(c[0] - p), norm(c[1] - p), norm(c[2] - p)})});
    }
    std::map<std::pair<int, int>, std::size_t> side;  // a directed edge and its face
    std::vector<std::vector<std::size_t>> around(mesh.vertices.size());
    const auto index = [&](std::size_t f, std::size_t i) { return mesh.faces[f][i % 3]; };
    std::vector<bool> thin(faces);
    for (std::size_t f = 0; f < faces; ++f) {
      thin[f] = height_share(mesh, mesh.faces[f]) < thin_height;
      for (std::size_t i = 0; i < 3; ++i) {
        side[{index(f, i), index(f, i + 1)}] = f;
        around[static_cast<std::size_t>(index(f, i))].push_back(f);
      }
    }
    std::vector<bool> met(mesh.vertices.size()), folded(mesh.vertices.size()), alone(mesh.vertices.size());
    for (std::size_t f = 0; f < faces; ++f) {
      for (std::size_t i = 0; i < 3; ++i) {
        const int a = index(f, i), b = index(f, i + 1);
        const auto other = side.find({b, a});
        bool convex = true, fold = true;  // where a surface has no neighbour there
        if (other != side.end()) {
          const std::size_t g = other->second;
          std::size_t apex = 0;
          while (apex < 2 && (index(g, apex) == a || index(g, apex) == b)) ++apex;
          const Vec3& start = surface_.corners[f][i];
          const Vec3 e = surface_.corners[f][(i + 1) % 3] - start;
          const double rise = dot(surface_.normals[f].face, surface_.corners[g][apex] - start);
          const double cosine = dot(surface_.normals[f].face, surface_.normals[g].face);
          // Of faces back to back, neither lies below the other.
          convex = rise < -least_fold * norm(e) || cosine < 0 || thin[f] || thin[g];
          fold = cosine < same;
        }
        borders_[f].edge_met[i] = convex;
        borders_[f].edge_crease[i] = fold;
        borders_[f].edge_alone[i] = other == side.end();
        for (const int end : {a, b}) {
          if (other == side.end()) alone[static_cast<std::size_t>(end)] = true;
          if (convex) met[static_cast<std::size_t>(end)] = true;
          if (fold) folded[static_cast<std::size_t>(end)] = true;
        }
      }
    }
    for (std::size_t f = 0; f < faces; ++f) {
      for (std::size_t i = 0; i < 3; ++i) {
        const auto vertex = static_cast<std::size_t>(index(f, i));
        borders_[f].corner_met[i] = met[vertex];
        borders_[f].corner_crease[i] = folded[vertex];
        borders_[f].corner_alone[i] = alone[vertex];
        borders_[f].shaded[i] = shaded_at(mesh, f, index(f, i), around[vertex], same);
      }
    }
  }

  [[nodiscard]] Vec3 shaded_at(const TriangleMesh& mesh, std::size_t face, int vertex,
                               const std::vector<std::size_t>& around, double same) const {
    const Vec3& own = surface_.normals[face].face;
    Vec3 sum;
    for (const std::size_t g : around) {
      const Vec3& n = surface_.normals[g].face;
      if (g != face && dot(own, n) < same) continue;
      const auto& f = mesh.faces[g];
      const auto i = static_cast<std::size_t>(std::find(f.begin(), f.end(), vertex) - f.begin());
      const std::array<Vec3, 3>& c = surface_.corners[g];
      const Vec3 u = c[(i + 1) % 3] - c[i], v = c[(i + 2) % 3] - c[i];
      sum += std::acos(std::clamp(dot(u, v) / (norm(u) * norm(v)), -1.0, 1.0)) * n;
    }
    return unit_or(sum, own);
  }

  /// A ball about a face.
  struct Middle {
    Vec3 p;
    double radius = 0;
  };

  Surface surface_;
  FaceTree tree_;
  std::vector<Border> borders_;
  std::vector<Middle> middles_;
};

/// A sphere or a capsule: the points at `radius` of a segment along z.
class RoundBallSurface final : public BallSurface {
 public:
  RoundBallSurface(const Shape& shape, double radius, double length)
      : distance_(shape_distance(shape)), radius_(radius), half_(0.5 * length) {}

  bool cast(const Vec3& from, const Vec3& way, double radius, BallHit& hit, int& looks) const override {
    if (looks <= 0) return false;
    --looks;
    const Vec3 low{0, 0, -half_}, high{0, 0, half_};
    if (half_ > 0) {
      meets_segment(from - low, high - low, way, radius_ + radius, hit);
      meets_point(from - high, way, radius_ + radius, hit);
    }
    meets_point(from - low, way, radius_ + radius, hit);
    return true;
  }
  [[nodiscard]] Nearest nearest(const Vec3& x) const override { return distance_->nearest(x, -1); }

 private:
  std::unique_ptr<SignedDistance> distance_;
  double radius_, half_;  // m
};

class PlaneBallSurface final : public BallSurface {
 public:
  bool cast(const Vec3& from, const Vec3& way, double radius, BallHit& hit, int& looks) const override {
    if (looks <= 0) return false;
    --looks;
    const Vec3 n{0, 0, 1};
    if (!approaches(n, way)) return true;
    const double t = std::max(0.0, (from.z - radius) / -way.z);
    if (t < hit.share) hit = {t, true, n, std::max(0.0, radius - from.z), n};
    return true;
  }
  [[nodiscard]] Nearest nearest(const Vec3& x) const override { return {x.z, {x.x, x.y, 0}, {0, 0, 1}, 0}; }
};

}  // namespace

std::unique_ptr<BallSurface> ball_surface(TriangleMesh mesh, double crease) {
  return std::make_unique<MeshBallSurface>(without_needles(std::move(mesh)), crease);
}

std::unique_ptr<BallSurface> ball_surface(const Body& body, double crease, Notes* notes) {
  if (body.mesh() != nullptr) {
    TriangleMesh mesh = load_body_mesh(body, notes);
    try {
      return ball_surface(std::move(mesh), crease);
    } catch (const InputError& error) {
      throw ValueError("scene.bodies." + body.name + ".mesh",
                       "body '" + body.name + "': " + body.mesh()->file.string() + ": " + error.what());
    }
  }
  if (const auto* box = std::get_if<BoxShape>(&body.shape)) return ball_surface(box_mesh(box->size), crease);
  if (const auto* sphere = std::get_if<SphereShape>(&body.shape)) {
    return std::make_unique<RoundBallSurface>(body.shape, sphere->radius, 0);
  }
  if (const auto* capsule = std::get_if<CapsuleShape>(&body.shape)) {
    return std::make_unique<RoundBallSurface>(body.shape, capsule->radius, capsule->length);
  }
  TACTOR_DEMAND(std::holds_alternative<PlaneShape>(body.shape));
  return std::make_unique<PlaneBallSurface>();
}

}  // namespace tactor
