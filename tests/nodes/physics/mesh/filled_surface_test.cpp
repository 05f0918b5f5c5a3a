// A surface is filled with tetrahedra once, the same each time, and comes from the cache after that.
#include <cstdlib>
#include <filesystem>
#include <limits>

#include <boost/test/unit_test.hpp>

#include "framework/core/check.hpp"
#include "framework/core/disk_cache.hpp"
#include "nodes/physics/mesh/filled_surface.hpp"
#include "tests/nodes/physics/mesh/volume_checks.hpp"
#include "tests/support/shapes.hpp"

BOOST_AUTO_TEST_SUITE(filled_surface_test)

using namespace tactor;
namespace fs = std::filesystem;

namespace {

std::vector<fs::path> files_in(const fs::path& folder) {
  if (!fs::exists(folder)) return {};
  return {fs::directory_iterator(folder), fs::directory_iterator()};
}

bool same(const TetMesh& a, const TetMesh& b) {
  return a.nodes == b.nodes && a.tets == b.tets && a.faces == b.faces;
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_same_surface_gives_the_same_tetrahedra_whatever_was_made_before) {
  const TemporaryFolder folder;
  std::vector<std::string> notes;
  const TriangleMesh ball = test::icosphere(0.05, 3), box = test::box({0.1, 0.06, 0.04});
  for (const TriangleMesh& surface : {ball, box}) {
    const TetMesh first = filled_surface(surface, {.tetrahedra = 2000}, "a.off", notes, folder.path() / "1");
    filled_surface(test::box({1, 1, 1}), {.tetrahedra = 300}, "b.off", notes, folder.path() / "2");
    const std::vector<std::vector<char>> holes(1000, std::vector<char>(700));
    const TetMesh second = filled_surface(surface, {.tetrahedra = 2000}, "c.off", notes, folder.path() / "3");
    BOOST_TEST(same(first, second));
    test::check_sound(first);
  }
  BOOST_TEST(notes.empty());
}

BOOST_AUTO_TEST_CASE(tetrahedra_come_from_the_cache_under_surface_and_fineness) {
  const TemporaryFolder folder;
  std::vector<std::string> notes;
  const TriangleMesh ball = test::icosphere(0.05, 2);
  const auto fill = [&](const TriangleMesh& surface, const VolumeFineness& fineness) {
    return filled_surface(surface, fineness, "ball.off", notes, folder.path());
  };
  const TetMesh first = fill(ball, {.tetrahedra = 400});
  BOOST_TEST(files_in(folder.path()).size() == 1U);
  BOOST_TEST(same(fill(ball, {.tetrahedra = 400}), first));
  BOOST_TEST(files_in(folder.path()).size() == 1U);
  fill(ball, {.tetrahedra = 500});
  BOOST_TEST(files_in(folder.path()).size() == 2U);
  fill(ball, {.tetrahedra = 500, .edge = 0.02});
  fill(ball, {.tetrahedra = 600, .edge = 0.02});
  BOOST_TEST(files_in(folder.path()).size() == 3U);
  TriangleMesh larger = ball;
  for (Vec3& v : larger.vertices) v *= 2;
  const TetMesh twice = fill(larger, {.tetrahedra = 400});
  BOOST_TEST(files_in(folder.path()).size() == 4U);
  // Only the unit differs.
  BOOST_TEST_REQUIRE(twice.nodes.size() == first.nodes.size());
  for (std::size_t i = 0; i < first.nodes.size(); ++i) BOOST_TEST(norm(twice.nodes[i] - 2 * first.nodes[i]) < 1e-12);
  BOOST_TEST(notes.empty());
}

BOOST_AUTO_TEST_CASE(an_entry_with_anything_out_of_range_is_made_anew_and_told) {
  const TemporaryFolder folder;
  std::vector<std::string> notes;
  const TriangleMesh ball = test::icosphere(0.05, 2);
  const auto fill = [&] { return filled_surface(ball, {.tetrahedra = 300}, "ball.off", notes, folder.path()); };
  const TetMesh good = fill();
  const fs::path entry = files_in(folder.path()).at(0);
  const DiskCache disk("tetrahedra", 3, folder.path());
  const std::string key = entry.stem().string();
  BOOST_REQUIRE(disk.load(key).bytes.has_value());
  std::vector<std::string> entries{"", "x", to_bytes(good) + "x", std::string(200, '\xff'), to_bytes(TetMesh{})};
  const auto add = [&](const auto& change) {
    TetMesh bad = good;
    change(bad);
    entries.push_back(to_bytes(bad));
  };
  for (const int index : {0x7fffffff, static_cast<int>(good.nodes.size()), -1, std::numeric_limits<int>::min()}) {
    add([&](TetMesh& m) { m.tets[5][1] = index; });
  }
  add([](TetMesh& m) { m.tets[5][1] = m.tets[5][0]; });
  add([](TetMesh& m) { std::swap(m.tets[5][1], m.tets[5][0]); });
  add([](TetMesh& m) { m.tets.push_back(m.tets[0]); });
  add([](TetMesh& m) { m.nodes.pop_back(); });
  add([](TetMesh& m) { m.nodes.push_back({}); });
  add([](TetMesh& m) { m.nodes[0].x = std::numeric_limits<double>::quiet_NaN(); });
  add([](TetMesh& m) { m.nodes[0].y = 1e300; });
  for (const std::string& bytes : entries) {
    BOOST_TEST(disk.store(key, bytes) == "");
    notes.clear();
    BOOST_TEST(same(fill(), good));
    BOOST_TEST_REQUIRE(notes.size() == 1U);
    BOOST_TEST(notes[0] == entry.string() + ": the cached file holds no tetrahedra; computed again and replaced");
  }
  notes.clear();
  BOOST_TEST(same(fill(), good));
  BOOST_TEST(notes.empty());
}

BOOST_AUTO_TEST_CASE(a_surface_without_volume_is_refused) {
  std::vector<std::string> notes;
  TriangleMesh inward = test::icosphere(0.05, 1);
  for (auto& f : inward.faces) std::swap(f[0], f[1]);
  BOOST_CHECK_EXCEPTION(filled_surface(inward, {}, "inward.off", notes), InputError, [](const InputError& e) {
    return std::string(e.what()).starts_with("inward.off: the surface encloses a volume of -");
  });
}

BOOST_AUTO_TEST_SUITE_END()
