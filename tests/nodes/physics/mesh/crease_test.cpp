// The parts of a surface that folds, and how much of them counts in which direction.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/physics/mesh/crease.hpp"
#include "nodes/physics/mesh/surface_samples.hpp"
#include "tests/support/dice.hpp"
#include "tests/support/shapes.hpp"

BOOST_AUTO_TEST_SUITE(crease_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

constexpr double degree = std::numbers::pi / 180;

/// The tip of a needle of `sides` faces that points down, `half` rad from its axis.
std::vector<FacingArea> tip(int sides, double half) {
  std::vector<FacingArea> faces;
  for (int i = 0; i < sides; ++i) {
    const double turn = 2 * std::numbers::pi * i / sides;
    faces.push_back({1, {std::cos(half) * std::cos(turn), std::cos(half) * std::sin(turn), -std::sin(half)}});
  }
  return faces;
}

double whole(const Crease& crease) {
  double sum = 0;
  for (std::size_t i = 0; i < crease.parts; ++i) sum += crease.part[i].area;
  return sum;
}

/// A cube's corner with faces of 3, 2 and 1.
Crease corner() {
  return find_crease({{3, {1, 0, 0}}, {2, {0, 1, 0}}, {1, {0, 0, 1}}}).value();
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_smooth_surface_is_no_crease_however_far_it_bends) {
  std::vector<FacingArea> bend;
  for (int i = 0; i <= 9; ++i) bend.push_back({1, {std::cos(20 * i * degree), std::sin(20 * i * degree), 0}});
  BOOST_TEST(!find_crease(bend));
  BOOST_TEST(!find_crease(tip(24, 10 * degree)));
  BOOST_TEST(!find_crease({}));
  BOOST_TEST(!find_crease({{1, {0, 0, 1}}}));
  for (const double angle : {10.0, 31.0, 32.5, 90.0, 179.0}) {
    const Vec3 n{std::cos(angle * degree), std::sin(angle * degree), 0};
    BOOST_TEST(find_crease({{1, {1, 0, 0}}, {1, n}}).has_value() == (angle > 32));
  }
}

BOOST_AUTO_TEST_CASE(parts_have_the_area_and_the_mean_normal_of_their_faces_in_whatever_order_they_come) {
  // Two of one face of a cube, two that are almost so, and another.
  std::vector<FacingArea> faces{{1, {0, 0, 1}},
                                {2, {0, 0, 1}},
                                {1.5, {std::sin(0.3), 0, std::cos(0.3)}},
                                {1.5, {-std::sin(0.3), 0, std::cos(0.3)}},
                                {4, {1, 0, 0}}};
  const auto less = [](const FacingArea& a, const FacingArea& b) { return a.area < b.area; };
  std::sort(faces.begin(), faces.end(), less);
  do {
    const std::optional<Crease> crease = find_crease(faces);
    BOOST_REQUIRE(crease.has_value());
    BOOST_REQUIRE(crease->parts == 2U);
    const FacingArea &top = crease->part[crease->part[0].area > 5 ? 0 : 1],
                     &side = crease->part[crease->part[0].area > 5 ? 1 : 0];
    BOOST_TEST(top.area == 6.0, tt::tolerance(1e-12));
    BOOST_TEST(norm(top.normal - Vec3{0, 0, (3 + 3 * std::cos(0.3)) / 6}) < 1e-12);
    BOOST_TEST(side.area == 4.0, tt::tolerance(1e-12));
    BOOST_TEST(norm(side.normal - Vec3{1, 0, 0}) < 1e-12);
  } while (std::next_permutation(faces.begin(), faces.end(), less));
}

BOOST_AUTO_TEST_CASE(of_more_than_three_parts_the_most_alike_become_one) {
  const Crease four = find_crease({{1, {1, 0, 0}}, {2, {-1, 0, 0}}, {3, {0, 1, 0}}, {4, {0, 0.6, 0.8}}}).value();
  BOOST_REQUIRE(four.parts == 3U);
  std::array<double, 3> areas{four.part[0].area, four.part[1].area, four.part[2].area};
  std::sort(areas.begin(), areas.end());
  BOOST_TEST(areas[0] == 1.0);
  BOOST_TEST(areas[1] == 2.0);
  BOOST_TEST(areas[2] == 7.0, tt::tolerance(1e-12));
  for (const int sides : {4, 5, 7, 9}) {
    const Crease crease = find_crease(tip(sides, 3 * degree)).value();
    BOOST_TEST(crease.parts == 3U);
    BOOST_TEST(whole(crease) == 1.0 * sides, tt::tolerance(1e-12));
  }
}

BOOST_AUTO_TEST_CASE(a_sliver_decides_nothing) {
  // One that faces nowhere in particular, at the edge of a cube, and a blunt end at the tip of a needle.
  const FacingArea sliver{1e-3, {0.6, 0.48, -0.64}};
  const Crease edge = find_crease({{1, {0, 0, 1}}, sliver, {1, {1, 0, 0}}}).value();
  BOOST_TEST(edge.parts == 2U);
  BOOST_TEST(area_towards(edge, {0, 0, 1}) == 1.0, tt::tolerance(0.003));
  BOOST_TEST(!find_crease({{1, {0, 0, 1}}, sliver}));
  std::vector<FacingArea> blunt = tip(4, 3 * degree);
  blunt.push_back({1e-3, {0, 0, -1}});
  BOOST_TEST(area_towards(find_crease(blunt).value(), {0, 0, -1}) > 0.9 * 4);
  // What is larger is a face of its own: the end of a chisel.
  const double c = std::cos(3 * degree), s = std::sin(3 * degree);
  const Crease chisel = find_crease({{1, {c, 0, -s}}, {1, {-c, 0, -s}}, {0.5, {0, 0, -1}}}).value();
  BOOST_TEST(area_towards(chisel, {0, 0, -1}) == 0.5 + 2 * (s * s + 0.001) / 1.001, tt::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(what_lies_on_the_other_body_counts) {
  const Crease crease = corner();
  BOOST_TEST(area_towards(crease, {1, 0, 0}) == 3 + 3 * 0.001 / 1.001, tt::tolerance(1e-12));
  BOOST_TEST(area_towards(crease, {0, 1, 0}) == 2 + 4 * 0.001 / 1.001, tt::tolerance(1e-12));
  BOOST_TEST(area_towards(crease, {0, 0, 1}) == 1 + 5 * 0.001 / 1.001, tt::tolerance(1e-12));
  // Edge-on both faces count, corner-on all three.
  const double r = std::sqrt(0.5), t = std::sqrt(1.0 / 3);
  BOOST_TEST(area_towards(crease, {r, r, 0}) == 5 + 0.001 / 0.501, tt::tolerance(1e-12));
  BOOST_TEST(area_towards(crease, {t, t, t}) == 6.0, tt::tolerance(1e-12));
  // Tilted by a little, what a face adds goes with the square of the tilt.
  BOOST_TEST(area_towards(crease, {std::cos(0.05), std::sin(0.05), 0}) == 3 + 2 * std::pow(std::tan(0.05), 2),
             tt::tolerance(0.002));
  // All face away.
  BOOST_TEST(area_towards(crease, {-t, -t, -t}) == 6.0, tt::tolerance(1e-12));
  BOOST_TEST(area_towards(crease, {-1, 0, 0}) == 6.0, tt::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(no_less_counts_than_the_part_that_faces_most_and_no_more_than_all) {
  test::Dice dice(5);
  const Crease crease = corner();
  for (int i = 0; i < 2000; ++i) {
    const Vec3 v = dice.in_cube(1), u = v / norm(v);
    const double area = area_towards(crease, u);
    double most = -1, least = 0;
    for (const FacingArea& part : crease.part) {
      if (dot(part.normal, u) > most) most = dot(part.normal, u), least = part.area;
    }
    BOOST_TEST(area >= least);
    BOOST_TEST(area <= 6 * (1 + 1e-12));
  }
}

BOOST_AUTO_TEST_CASE(a_needle_keeps_all_of_its_area_on_its_tip) {
  for (const int sides : {3, 4, 6, 8, 12, 32}) {
    for (const double half : {0.5, 3.0, 15.0}) {
      const std::optional<Crease> crease = find_crease(tip(sides, half * degree));
      // A tip of many sides is smooth, and a sample there has no other weight than all.
      if (!crease) continue;
      BOOST_TEST(area_towards(*crease, {0, 0, -1}) == 1.0 * sides, tt::tolerance(1e-9));
      BOOST_TEST(area_towards(*crease, {0, 0, 1}) == 1.0 * sides, tt::tolerance(1e-9));
      // Tilted by as much as it is sharp it keeps a third.
      const double tilt = half * degree;
      BOOST_TEST(area_towards(*crease, {std::sin(tilt), 0, -std::cos(tilt)}) > sides / 3.0);
    }
  }
}

BOOST_AUTO_TEST_CASE(what_counts_changes_continuously_all_the_way_round) {
  test::Dice dice(5);
  const double step = 0.1 * degree;
  const auto largest_change = [&](const Crease& crease, const Vec3& from, const Vec3& side) {
    double largest = 0, last = area_towards(crease, from);
    for (int i = 1; i <= 3600; ++i) {
      const double now = area_towards(crease, std::cos(i * step) * from + std::sin(i * step) * side);
      largest = std::max(largest, std::abs(now - last));
      last = now;
    }
    return largest;
  };
  const Crease edge = find_crease({{1, {1, 0, 0}}, {1, {0, 1, 0}}}).value();
  // Once round the edge: the steepest is where one face turns away while the other does already.
  BOOST_TEST(largest_change(edge, {1, 0, 0}, {0, 1, 0}) < 0.037);
  BOOST_TEST(largest_change(edge, {1, 0, 0}, {0, 1, 0}) > 0.03);
  const std::vector<Crease> creases{edge, corner(), find_crease(tip(4, 2 * degree)).value()};
  for (const Crease& crease : creases) {
    for (int i = 0; i < 50; ++i) {
      const Vec3 v = dice.in_cube(1), w = dice.in_cube(1), from = v / norm(v), across = w - dot(w, from) * from;
      BOOST_TEST(largest_change(crease, from, across / norm(across)) <= 64 * step * whole(crease));
    }
  }
  // While a face is within 45 degrees of the other body.
  for (int i = -450; i < 450; ++i) {
    const double a = i * step, b = a + step;
    BOOST_TEST(std::abs(area_towards(edge, {std::cos(b), std::sin(b), 0}) -
                        area_towards(edge, {std::cos(a), std::sin(a), 0})) <= 5 * step);
  }
}

BOOST_AUTO_TEST_CASE(samples_of_round_meshes_are_at_no_crease_and_those_of_a_box_at_its_edges_alone) {
  for (const int levels : {2, 3, 4}) {
    const TriangleMesh ball = test::icosphere(0.04, levels);
    BOOST_TEST(vertex_samples(ball).creases.empty());
    for (const double spacing : {0.1, 0.02, 0.006}) BOOST_TEST(sample_surface(ball, spacing).creases.empty());
  }
  const Vec3 size{0.04, 0.03, 0.02};
  for (const double spacing : {0.1, 0.01, 0.004}) {
    const SurfaceSamples samples = sample_surface(test::box(size), spacing);
    for (const SurfaceSample& s : samples.points) {
      std::size_t faces = 0;
      for (int axis = 0; axis < 3; ++axis) faces += std::abs(s.p[axis]) > size[axis] / 2 - 1e-12 ? 1 : 0;
      BOOST_TEST((s.crease >= 0) == (faces > 1));
      if (s.crease < 0) continue;
      const Crease& crease = samples.creases[static_cast<std::size_t>(s.crease)];
      BOOST_TEST(crease.parts == faces);
      BOOST_TEST(whole(crease) == s.area, tt::tolerance(1e-9));
      for (std::size_t i = 0; i < crease.parts; ++i) {
        // Each looks out of the box.
        const Vec3& n = crease.part[i].normal;
        BOOST_TEST(std::abs(norm(n) - 1) < 1e-12);
        BOOST_TEST(std::abs(n.x * s.p.x / size.x + n.y * s.p.y / size.y + n.z * s.p.z / size.z - 0.5) < 1e-9);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(the_parts_that_face_as_a_face_does_sum_to_its_area) {
  const Vec3 size{0.04, 0.03, 0.002};
  const TriangleMesh mesh = test::box(size);
  const auto facing = [](const SurfaceSamples& samples, const Vec3& n, const Vec3& half) {
    double sum = 0;
    for (const SurfaceSample& s : samples.points) {
      if (s.crease >= 0) {
        const Crease& crease = samples.creases[static_cast<std::size_t>(s.crease)];
        for (std::size_t i = 0; i < crease.parts; ++i) {
          if (dot(crease.part[i].normal, n) > 0.9) sum += crease.part[i].area;
        }
      } else if (std::abs(dot(s.p, n) - std::abs(dot(half, n))) < 1e-9) {
        sum += s.area;
      }
    }
    return sum;
  };
  for (const SurfaceSamples& samples : {vertex_samples(mesh), sample_surface(mesh, 0.004)}) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double side : {-1.0, 1.0}) {
        Vec3 n;
        n[axis] = side;
        BOOST_TEST(facing(samples, n, 0.5 * size) == size[(axis + 1) % 3] * size[(axis + 2) % 3], tt::tolerance(1e-9));
      }
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
