// A ball that is cast against meshes with needles and faces without area, against a look at every face.
#include "nodes/forcefield/ball_cast.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <map>
#include <optional>

#include "framework/core/check.hpp"
#include "tests/support/dice.hpp"
#include "tests/support/shapes.hpp"

BOOST_AUTO_TEST_SUITE(ball_cast_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr int plenty = 1'000'000;

/// m, from x to a segment, which may have no length.
double to_segment(const Vec3& a, const Vec3& b, const Vec3& x) {
  const double square = dot(b - a, b - a);
  const double t = square > 0 ? std::clamp(dot(x - a, b - a) / square, 0.0, 1.0) : 0;
  return norm(x - a - t * (b - a));
}

/// m, from x to the nearest of all faces. Those without a direction count by their edges.
double distance_to(const TriangleMesh& mesh, const Vec3& x) {
  double least = 1e9;
  for (const auto& f : mesh.faces) {
    const Vec3 &a = mesh.vertices[static_cast<std::size_t>(f[0])], &b = mesh.vertices[static_cast<std::size_t>(f[1])],
               &c = mesh.vertices[static_cast<std::size_t>(f[2])];
    least = std::min({least, to_segment(a, b, x), to_segment(b, c, x), to_segment(c, a, x)});
    const Vec3 n = cross(b - a, c - a);
    if (norm(n) < 1e-13) continue;
    const Vec3 unit = n / norm(n), q = x - dot(x - a, unit) * unit;
    if (dot(cross(b - a, q - a), n) >= 0 && dot(cross(c - b, q - b), n) >= 0 && dot(cross(a - c, q - c), n) >= 0) {
      least = std::min(least, std::abs(dot(x - a, unit)));
    }
  }
  return least;
}

/// The share of the way at which the ball first touches, by steps as long as the ball is away; none where it passes.
struct Found {
  std::optional<double> share;
  double nearest = 1e9;  // m, of its surface on the way
};
Found first_touch(const TriangleMesh& mesh, const Vec3& from, const Vec3& way, double radius) {
  Found found;
  double share = 0;
  for (int i = 0; i < 5000 && share <= 1; ++i) {
    const double away = distance_to(mesh, from + share * way) - radius;
    found.nearest = std::min(found.nearest, away);
    if (away < 1e-11) {
      found.share = share;
      return found;
    }
    share += away / norm(way);
  }
  return found;
}

/// Splits the edges of which `choose` says so on one side only, and fills the gap with a face: from an edge to its
/// middle, moved by `height` (m) in a random direction, or where `doubled`, from a corner to another at its place.
TriangleMesh with_needles(const TriangleMesh& mesh, double height, bool doubled, Dice& dice) {
  TriangleMesh made = mesh;
  std::map<std::pair<int, int>, std::size_t> side;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (std::size_t i = 0; i < 3; ++i) side[{mesh.faces[f][i], mesh.faces[f][(i + 1) % 3]}] = f;
  }
  std::vector<bool> used(mesh.faces.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (std::size_t i = 0; i < 3; ++i) {
      const int a = mesh.faces[f][i], b = mesh.faces[f][(i + 1) % 3];
      const std::size_t g = side.at({b, a});
      if (used[f] || used[g]) continue;
      used[f] = used[g] = true;
      const Vec3 &p = mesh.vertices[static_cast<std::size_t>(a)], &q = mesh.vertices[static_cast<std::size_t>(b)];
      const int added = static_cast<int>(made.vertices.size());
      const Vec3 out = dice.in_cube(1);
      made.vertices.push_back((doubled ? p : 0.5 * (p + q)) + (height / norm(out)) * out);
      int c = 0;
      for (const int corner : mesh.faces[g]) c = corner != a && corner != b ? corner : c;
      if (doubled) {
        made.faces[g] = {b, added, c};
      } else {
        made.faces[g] = {b, added, c};
        made.faces.push_back({added, a, c});
      }
      made.faces.push_back({b, a, added});
    }
  }
  return made;
}

/// Casts balls from about the mesh towards its inside and past it, and compares each.
void compare(const TriangleMesh& mesh, double size, Dice& dice) {
  const auto surface = ball_surface(mesh, 0.6);
  int met = 0;
  for (int n = 0; n < 300; ++n) {
    const double radius = n % 3 == 0 ? 1e-7 : n % 3 == 1 ? 0.05 * size : size;
    Vec3 out = dice.in_cube(1);
    out = out / norm(out);
    // Every other one at an edge or a corner of the mesh, where needles are.
    Vec3 aim = 0.8 * dice.in_cube(size);
    if (n % 2 == 0) {
      const auto& f = mesh.faces[static_cast<std::size_t>(dice(0, static_cast<double>(mesh.faces.size())))];
      const double share = dice(0, 1);
      aim = share * mesh.vertices[static_cast<std::size_t>(f[0])] +
            (1 - share) * mesh.vertices[static_cast<std::size_t>(f[1])];
    }
    const Vec3 from = aim + (6 * size) * out, way = (-8 * size) * out;
    if (distance_to(mesh, from) < radius) continue;
    BallHit hit;
    int looks = plenty;
    BOOST_REQUIRE(surface->cast(from, way, radius, hit, looks));
    const Found expected = first_touch(mesh, from, way, radius);
    // A ball that grazes meets or passes by rounding.
    if (!expected.share && expected.nearest < 1e-8) continue;
    BOOST_REQUIRE(hit.met == expected.share.has_value());
    if (!hit.met) continue;
    ++met;
    BOOST_REQUIRE(std::isfinite(hit.share) && is_finite(hit.n) && is_finite(hit.shaded));
    BOOST_REQUIRE(std::abs(norm(hit.n) - 1) < 1e-9);
    BOOST_REQUIRE(std::abs(norm(hit.shaded) - 1) < 1e-9);
    BOOST_REQUIRE(dot(hit.n, way) < 0);
    const Vec3 centre = from + hit.share * way;
    BOOST_REQUIRE(std::abs(distance_to(mesh, centre) - radius) < 1e-9);
    BOOST_REQUIRE(std::abs(hit.share - *expected.share) * norm(way) < 1e-7);
    // What it met lies a radius away, against the normal.
    BOOST_REQUIRE(distance_to(mesh, centre - radius * hit.n) < 1e-8);
  }
  BOOST_TEST(met > 100);
}

/// A wedge with an edge of about 11 degrees along y.
TriangleMesh wedge() {
  TriangleMesh mesh;
  for (const double y : {-0.01, 0.01}) {
    mesh.vertices.insert(mesh.vertices.end(), {{0, y, 0}, {0.02, y, -0.002}, {0.02, y, 0.002}});
  }
  mesh.faces = {{0, 1, 2}, {3, 5, 4}, {0, 3, 4}, {0, 4, 1}, {0, 2, 5}, {0, 5, 3}, {1, 4, 5}, {1, 5, 2}};
  return mesh;
}

bool inside_of_wedge(const Vec3& x) {
  return std::abs(x.y) < 0.01 && x.x > 0 && x.x < 0.02 && std::abs(x.z) < 0.1 * x.x;
}

}  // namespace

BOOST_AUTO_TEST_CASE(meshes_without_needles_are_met_where_a_look_at_every_face_says) {
  Dice dice(1);
  compare(icosphere(0.01, 2), 0.01, dice);
  compare(box({0.02, 0.012, 0.02}), 0.01, dice);
  compare(wedge(), 0.01, dice);
}

BOOST_AUTO_TEST_CASE(faces_without_area_and_needles_change_nothing) {
  Dice dice(2);
  for (const TriangleMesh& mesh : {icosphere(0.01, 1), box({0.02, 0.012, 0.02}), wedge()}) {
    for (const double height : {0.0, 1e-19, 1e-15, 1e-12, 1e-10, 1e-8}) {
      compare(with_needles(mesh, height, false, dice), 0.01, dice);
      compare(with_needles(mesh, height, true, dice), 0.01, dice);
    }
  }
}

BOOST_AUTO_TEST_CASE(next_to_needles_inside_and_outside_are_told_apart) {
  Dice dice(3);
  for (const bool doubled : {false, true}) {
    for (const double height : {0.0, 1e-15, 1e-12}) {
      const TriangleMesh mesh = with_needles(wedge(), height, doubled, dice);
      const auto surface = ball_surface(mesh, 0.6);
      int inside = 0;
      for (int n = 0; n < 2000; ++n) {
        // About the sharp edge, and the others.
        const Vec3 x = n % 2 == 0 ? Vec3{dice(-0.004, 0.004), dice(-0.009, 0.009), dice(-0.002, 0.002)}
                                  : Vec3{dice(-0.005, 0.025), dice(-0.015, 0.015), dice(-0.005, 0.005)};
        const Nearest nearest = surface->nearest(x);
        const double distance = distance_to(mesh, x);
        if (distance < 1e-9) continue;
        BOOST_REQUIRE(std::abs(std::abs(nearest.distance) - distance) < 1e-9);
        BOOST_REQUIRE((nearest.distance < 0) == inside_of_wedge(x));
        BOOST_REQUIRE(norm(nearest.p + nearest.distance * nearest.gradient - x) < 1e-9);
        inside += nearest.distance < 0 ? 1 : 0;
      }
      BOOST_TEST(inside > 50);
      // On the surface there is a direction too.
      for (const Vec3& v : mesh.vertices) BOOST_REQUIRE(std::abs(norm(surface->nearest(v).gradient) - 1) < 1e-9);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_mesh_of_needles_alone_is_refused) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0.01, 0, 0}, {0.02, 0, 0}};
  mesh.faces = {{0, 1, 2}, {0, 2, 1}};
  BOOST_CHECK_THROW(ball_surface(mesh, 0.6), InputError);
}

BOOST_AUTO_TEST_CASE(looks_are_counted_and_bounded) {
  Dice dice(4);
  const auto surface = ball_surface(icosphere(0.01, 4), 0.6);
  int ended = 0, whole = 0;
  for (int n = 0; n < 500; ++n) {
    Vec3 out = dice.in_cube(1);
    out = out / norm(out);
    const Vec3 from = 0.03 * out + dice.in_cube(0.01), way = -0.04 * out;
    BallHit all, some;
    int many = plenty, few = static_cast<int>(dice(1, 300));
    const int given = few;
    BOOST_REQUIRE(surface->cast(from, way, 0.002, all, many));
    const bool knows = surface->cast(from, way, 0.002, some, few);
    // A leaf of eight faces is looked at as a whole.
    BOOST_REQUIRE(given - few < given + 8);
    BOOST_REQUIRE(knows == (plenty - many <= given - few));
    if (knows) {
      ++whole;
      BOOST_REQUIRE(some.met == all.met);
      BOOST_REQUIRE(some.share == all.share);
    } else {
      ++ended;
    }
  }
  BOOST_TEST(ended > 50);
  BOOST_TEST(whole > 50);
}

BOOST_AUTO_TEST_SUITE_END()
