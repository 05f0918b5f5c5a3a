// What can be repaired in a mesh is repaired exactly and told; what cannot is refused with its place and the remedy.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <functional>

#include "framework/core/check.hpp"
#include "nodes/physics/mesh/make_solid.hpp"
#include "nodes/physics/mesh/mass_properties.hpp"
#include "tests/nodes/physics/mesh/mesh_files.hpp"
#include "tests/support/shapes.hpp"

BOOST_AUTO_TEST_SUITE(solid_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

PolygonSoup soup_of(const TriangleMesh& mesh) {
  PolygonSoup soup{mesh.vertices, {}};
  for (const auto& f : mesh.faces) {
    soup.polygons.push_back(
        {static_cast<std::size_t>(f[0]), static_cast<std::size_t>(f[1]), static_cast<std::size_t>(f[2])});
  }
  return soup;
}

/// A box of 2 x 3 x 4 units; faces 0 and 1 have z = -2, faces 2 and 3 z = 2.
PolygonSoup brick() {
  return soup_of(test::box({2, 3, 4}));
}
constexpr double brick_volume = 24;

void append(PolygonSoup& soup, const PolygonSoup& other) {
  const std::size_t n = soup.points.size();
  soup.points.insert(soup.points.end(), other.points.begin(), other.points.end());
  for (auto polygon : other.polygons) {
    for (std::size_t& corner : polygon) corner += n;
    soup.polygons.push_back(polygon);
  }
}

void turn(std::vector<std::size_t>& polygon) {
  std::reverse(polygon.begin(), polygon.end());
}

struct Repaired {
  TriangleMesh mesh;
  MeshReport report;
  double volume = 0;
};

Repaired repair(PolygonSoup soup) {
  Repaired result;
  result.mesh = make_solid(std::move(soup), "part.off", result.report);
  result.volume = mass_properties(result.mesh).volume;
  for (const std::string& repair : result.report.repairs) BOOST_TEST_MESSAGE(repair);
  return result;
}

std::string refusal(PolygonSoup soup) {
  try {
    repair(std::move(soup));
  } catch (const InputError& e) {
    BOOST_TEST_MESSAGE(e.what());
    return e.what();
  }
  return "accepted";
}

bool refuses(PolygonSoup soup, const std::vector<std::string>& phrases) {
  const std::string message = refusal(std::move(soup));
  BOOST_TEST_INFO(message);
  return message.starts_with("part.off: ") &&
         std::all_of(phrases.begin(), phrases.end(),
                     [&](const std::string& phrase) { return message.find(phrase) != std::string::npos; });
}

using Phrases = std::vector<std::string>;

/// Every face counter-clockwise from outside, by the volume of tetrahedra, and every edge used once in each direction.
bool is_closed_and_consistent(const TriangleMesh& mesh) {
  std::map<std::pair<int, int>, int> uses;
  for (const auto& f : mesh.faces) {
    for (std::size_t i = 0; i < 3; ++i) ++uses[{f[i], f[(i + 1) % 3]}];
  }
  return std::all_of(uses.begin(), uses.end(), [&](const auto& use) {
    const auto back = uses.find({use.first.second, use.first.first});
    return use.second == 1 && back != uses.end() && back->second == 1;
  });
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_sound_mesh_stays_as_it_is_and_nothing_is_told) {
  const TriangleMesh ball = test::icosphere(0.05, 3);
  const Repaired repaired = repair(soup_of(ball));
  BOOST_TEST((repaired.mesh.vertices == ball.vertices));
  BOOST_TEST((repaired.mesh.faces == ball.faces));
  BOOST_TEST((repaired.report == MeshReport{}));
}

BOOST_AUTO_TEST_CASE(faces_that_look_inwards_are_turned_round_one_some_or_all) {
  const std::size_t all = brick().polygons.size();
  for (const std::size_t turned : {std::size_t{1}, std::size_t{5}, all - 1, all}) {
    PolygonSoup soup = brick();
    for (std::size_t i = 0; i < turned; ++i) turn(soup.polygons[i]);
    const Repaired repaired = repair(soup);
    BOOST_TEST(repaired.volume == brick_volume, tt::tolerance(1e-14));
    BOOST_TEST(is_closed_and_consistent(repaired.mesh));
    BOOST_TEST(repaired.report.repairs == Phrases{std::to_string(turned) + (turned == 1 ? " face was" : " faces were") +
                                                  " turned round to look out of the material"},
               tt::per_element());
  }
}

BOOST_AUTO_TEST_CASE(the_corners_of_faces_that_have_them_alone_are_stitched) {
  PolygonSoup soup;
  const TriangleMesh box = test::box({2, 3, 4});
  for (const auto& f : box.faces) {
    for (const int i : f) soup.points.push_back(box.vertices[static_cast<std::size_t>(i)]);
    const std::size_t n = soup.points.size();
    soup.polygons.push_back({n - 3, n - 2, n - 1});
  }
  // Zero has two signs and one place.
  for (Vec3& p : soup.points) p.x += 1;
  soup.points[0].x = soup.points[0].x == 0 ? -0.0 : soup.points[0].x;
  const Repaired repaired = repair(soup);
  BOOST_TEST(repaired.mesh.vertices.size() == 8U);
  BOOST_TEST(repaired.volume == brick_volume, tt::tolerance(1e-14));
  BOOST_TEST(repaired.report.repairs == Phrases{"28 duplicated vertices were stitched"}, tt::per_element());
}

BOOST_AUTO_TEST_CASE(isolated_vertices_and_duplicated_faces_are_left_out) {
  PolygonSoup soup = brick();
  soup.points.insert(soup.points.begin() + 3, Vec3{7, 7, 7});
  for (auto& polygon : soup.polygons) {
    for (std::size_t& corner : polygon) corner += corner >= 3 ? 1 : 0;
  }
  soup.polygons.push_back(soup.polygons[4]);
  std::rotate(soup.polygons.back().begin(), soup.polygons.back().begin() + 1, soup.polygons.back().end());
  soup.polygons.push_back(soup.polygons[2]);
  turn(soup.polygons.back());
  const Repaired repaired = repair(soup);
  BOOST_TEST(repaired.mesh.vertices.size() == 8U);
  BOOST_TEST(repaired.mesh.faces.size() == 12U);
  BOOST_TEST(repaired.volume == brick_volume, tt::tolerance(1e-14));
  BOOST_TEST(repaired.report.repairs == (Phrases{"1 isolated vertex was left out", "2 duplicated faces were removed"}),
             tt::per_element());
}

BOOST_AUTO_TEST_CASE(faces_without_area_are_taken_out_where_the_rest_stays_closed) {
  // Two corners at one place between two neighbours.
  PolygonSoup needle = brick();
  const auto [a, b, c] = std::array{needle.polygons[0][0], needle.polygons[0][1], needle.polygons[0][2]};
  needle.points.push_back(needle.points[a]);
  needle.polygons[0] = {needle.points.size() - 1, b, c};
  needle.polygons.push_back({a, b, needle.points.size() - 1});
  // On an edge a vertex that one side alone has, and a flat face that closes the gap.
  PolygonSoup cap = brick();
  cap.points.push_back(0.5 * (cap.points[a] + cap.points[b]));
  const std::size_t m = cap.points.size() - 1;
  cap.polygons[0] = {a, m, c};
  cap.polygons.push_back({m, b, c});
  cap.polygons.push_back({a, b, m});
  // A flat face beside a closed rest.
  PolygonSoup beside = brick();
  beside.points.push_back(0.5 * (beside.points[a] + beside.points[b]));
  beside.polygons.push_back({a, b, beside.points.size() - 1});
  for (const PolygonSoup& soup : {needle, cap, beside}) {
    const Repaired repaired = repair(soup);
    BOOST_TEST(repaired.volume == brick_volume, tt::tolerance(1e-14));
    BOOST_TEST(is_closed_and_consistent(repaired.mesh));
    BOOST_TEST(repaired.report.repairs.back() == "1 face without area was removed");
  }
}

BOOST_AUTO_TEST_CASE(polygons_are_cut_into_triangles_convex_or_not) {
  // An L-shaped prism: area 3, height 2.
  PolygonSoup prism;
  const double outline[6][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  for (const double z : {0.0, 2.0}) {
    for (const auto& p : outline) prism.points.push_back({p[0], p[1], z});
  }
  // The fan of the lid from its first corner would be right; from this one it would leave the face.
  prism.polygons.push_back({1, 0, 5, 4, 3, 2});
  prism.polygons.push_back({8, 9, 10, 11, 6, 7});
  for (std::size_t i = 0; i < 6; ++i) prism.polygons.push_back({i, (i + 1) % 6, 6 + (i + 1) % 6, 6 + i});
  const Repaired repaired = repair(prism);
  BOOST_TEST(repaired.mesh.faces.size() == 20U);
  BOOST_TEST(repaired.volume == 6, tt::tolerance(1e-14));
  BOOST_TEST(surface_area(repaired.mesh) == 2 * 3 + 8 * 2, tt::tolerance(1e-14));
  BOOST_TEST(repaired.report.repairs == Phrases{"8 polygons were cut into triangles"}, tt::per_element());
}

BOOST_AUTO_TEST_CASE(a_cavity_is_turned_to_look_into_itself_and_bodies_apart_are_kept) {
  PolygonSoup soup = brick();
  append(soup, soup_of(test::box({1, 1, 1})));
  append(soup, soup_of(test::box({1, 2, 1}, {10, 0, 0})));
  const Repaired repaired = repair(soup);
  BOOST_TEST(repaired.volume == brick_volume - 1 + 2, tt::tolerance(1e-14));
  BOOST_TEST(repaired.report.repairs == Phrases{"12 faces were turned round to look out of the material"},
             tt::per_element());
  // The right way round from the beginning.
  for (std::size_t i = 12; i < 24; ++i) turn(soup.polygons[i]);
  const Repaired sound = repair(soup);
  BOOST_TEST(sound.volume == brick_volume - 1 + 2, tt::tolerance(1e-14));
  BOOST_TEST(sound.report.repairs.empty());
}

BOOST_AUTO_TEST_CASE(all_faults_at_once_are_mended) {
  PolygonSoup soup = brick();
  append(soup, soup_of(test::box({1, 1, 1})));
  for (const std::size_t i : {1, 5, 13, 22}) turn(soup.polygons[i]);
  soup.points.push_back(soup.points[3]);
  soup.polygons[6] = soup.polygons[6];
  for (std::size_t& corner : soup.polygons[7]) corner = corner == 3 ? soup.points.size() - 1 : corner;
  soup.polygons.push_back(soup.polygons[9]);
  soup.points.push_back({1, 1, 1});
  const Repaired repaired = repair(soup);
  BOOST_TEST(repaired.volume == brick_volume - 1, tt::tolerance(1e-14));
  BOOST_TEST(is_closed_and_consistent(repaired.mesh));
}

BOOST_AUTO_TEST_CASE(a_surface_that_is_not_closed_is_refused_with_the_number_and_place_of_its_borders) {
  PolygonSoup open = brick();
  open.polygons.pop_back();
  BOOST_TEST(refuses(
      open, {"is not closed: 3 edges have a face on one side only", "(1, -1.5, ", "at face", "fill the holes"}));
  PolygonSoup apart = brick();
  apart.points.push_back(apart.points[0] + Vec3{1e-9, 0, 0});
  for (std::size_t& corner : apart.polygons[0]) corner = corner == 0 ? 8 : corner;
  BOOST_TEST(refuses(apart, {"is not closed", "merge vertices that nearly coincide"}));
  PolygonSoup sheet{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}};
  BOOST_TEST(refuses(sheet, {"is not closed: 3 edges"}));
}

BOOST_AUTO_TEST_CASE(a_surface_that_is_not_manifold_is_refused_with_its_edge_or_vertex) {
  // Two boxes that share an edge, and an inner wall.
  PolygonSoup edge = soup_of(test::box({2, 2, 2}));
  append(edge, soup_of(test::box({2, 2, 2}, {2, 2, 0})));
  BOOST_TEST(refuses(
      edge, {"not manifold: 1 edge belongs to more than two faces", "(1, 1, -1) to (1, 1, 1)", "to the faces"}));
  PolygonSoup wall = soup_of(test::box({2, 2, 2}));
  append(wall, soup_of(test::box({2, 2, 2}, {2, 0, 0})));
  BOOST_TEST(refuses(wall, {"not manifold: 4 edges belong", "inner walls"}));
  PolygonSoup vertex = soup_of(test::box({2, 2, 2}));
  append(vertex, soup_of(test::box({2, 2, 2}, {2, 2, 2})));
  BOOST_TEST(refuses(vertex, {"not manifold: parts of it touch in 1 vertex, the first at (1, 1, 1)"}));
  PolygonSoup twisted = brick();
  twisted.polygons.push_back({0, 1, 0, 2});
  BOOST_TEST(refuses(twisted, {"face 12 touches itself at (-1, -1.5, -2)"}));
}

BOOST_AUTO_TEST_CASE(a_closed_surface_of_one_side_is_refused) {
  // The projective plane of six vertices (half an icosahedron), in three dimensions only with cuts, but closed.
  PolygonSoup plane;
  for (int i = 0; i < 6; ++i) plane.points.push_back({1.0 * i, 1.0 * i * i, 1.0 * i * i * i});
  plane.polygons = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 1},
                    {1, 2, 4}, {2, 3, 5}, {3, 4, 1}, {4, 5, 2}, {5, 1, 3}};
  BOOST_TEST(refuses(plane, {"only one side"}));
}

BOOST_AUTO_TEST_CASE(a_surface_that_cuts_itself_is_refused_with_the_first_pair_of_faces) {
  PolygonSoup dented = brick();
  dented.points[7] = {-0.2, -0.4, -3};
  BOOST_TEST(refuses(dented, {"cuts itself", "the first faces ", "near (", "Boolean union"}));
  PolygonSoup crossing = brick();
  append(crossing, soup_of(test::box({2, 3, 4}, {1, 1, 1})));
  BOOST_TEST(refuses(crossing, {"cuts itself", "pairs of faces"}));
  PolygonSoup touching = brick();
  append(touching, soup_of(test::box({1, 1, 1}, {1.5, 0, 0})));
  BOOST_TEST(refuses(touching, {"cuts itself"}));
}

BOOST_AUTO_TEST_CASE(what_has_no_faces_or_no_thickness_is_refused) {
  BOOST_TEST(refuses({{{0, 0, 0}}, {}}, {"the file has no faces"}));
  BOOST_TEST(refuses({{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}, {0, 2, 1}, {0, 0, 1}}}, {""}));
  PolygonSoup flat = brick();
  for (Vec3& p : flat.points) p.z = 0;
  BOOST_TEST(refusal(flat) != "accepted");
  PolygonSoup foil = brick();
  for (Vec3& p : foil.points) p.z *= 1e-12;
  BOOST_TEST(refuses(foil, {"encloses almost no volume"}));
  PolygonSoup tiny = brick();
  for (Vec3& p : tiny.points) p *= 1e-200;
  BOOST_TEST(refusal(tiny) != "accepted");
}

BOOST_AUTO_TEST_CASE(very_thin_faces_and_very_many_are_warned_of) {
  const Repaired rod = repair(soup_of(test::box({1, 1, 20000})));
  BOOST_TEST_REQUIRE(rod.report.warnings.size() == 1U);
  BOOST_TEST(rod.report.warnings[0].find("8 faces are more than 10,000 times as long as high, the first face 4") == 0U);
  BOOST_TEST(rod.report.repairs.empty());
  const Repaired fine = repair(soup_of(test::icosphere(1, 7)));
  BOOST_TEST_REQUIRE(fine.report.warnings.size() == 1U);
  BOOST_TEST(fine.report.warnings[0].find("it has 327680 faces") == 0U);
}

BOOST_AUTO_TEST_CASE(every_format_gives_the_same_mass_properties) {
  // Exact in single precision, which binary STL has.
  const TriangleMesh box = test::box({0.5, 0.25, 1}, {2, -4, 8});
  for (const test::MeshFile& file : test::in_every_format(box)) {
    const Repaired repaired = repair(test::read_soup(file.name, file.bytes));
    const MassProperties p = mass_properties(repaired.mesh);
    BOOST_TEST_CONTEXT(file.name) {
      BOOST_TEST(p.volume == 0.125, tt::tolerance(1e-14));
      BOOST_TEST(norm(p.center - Vec3{2, -4, 8}) < 1e-13);
      BOOST_TEST(p.inertia(0, 0) == 0.125 / 12 * (0.0625 + 1), tt::tolerance(1e-12));
      BOOST_TEST(p.inertia(1, 1) == 0.125 / 12 * (0.25 + 1), tt::tolerance(1e-12));
      BOOST_TEST(p.inertia(2, 2) == 0.125 / 12 * (0.25 + 0.0625), tt::tolerance(1e-12));
      BOOST_TEST(repaired.mesh.vertices.size() == 8U);
    }
  }
}

BOOST_AUTO_TEST_CASE(damaged_files_are_refused_or_are_solids_and_never_worse) {
  const TriangleMesh ball = test::icosphere(0.05, 1);
  std::uint64_t state = 12345;
  const auto random = [&](std::size_t below) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return static_cast<std::size_t>((state >> 33U) % below);
  };
  std::size_t refused = 0, solids = 0;
  const auto attempt = [&](const std::string& name, std::string_view bytes) {
    try {
      MeshReport report;
      const TriangleMesh mesh = make_solid(test::read_soup(name, bytes), name, report);
      ++solids;
      if (!is_closed_and_consistent(mesh) || !(mass_properties(mesh).volume > 0)) BOOST_ERROR("no solid from " + name);
    } catch (const InputError& e) {
      ++refused;
      if (!std::string(e.what()).starts_with(name + ":")) BOOST_ERROR(e.what());
    }
  };
  for (const test::MeshFile& file : test::in_every_format(ball)) {
    for (std::size_t size = 0; size < file.bytes.size(); ++size)
      attempt(file.name, std::string_view(file.bytes).substr(0, size));
    for (int i = 0; i < 1000; ++i) {
      std::string damaged = file.bytes;
      for (std::size_t flips = 1 + random(3); flips > 0; --flips) {
        char& byte = damaged[random(damaged.size())];
        byte = static_cast<char>(byte ^ (1 << random(8)));
      }
      attempt(file.name, damaged);
    }
  }
  BOOST_TEST_MESSAGE(refused << " refused, " << solids << " solids");
  BOOST_TEST(refused > 0U);
  BOOST_TEST(solids > 0U);
}

BOOST_AUTO_TEST_SUITE_END()
