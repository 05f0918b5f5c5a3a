// A mesh file is loaded as a solid once and comes from the cache after that; bodies of another unit are caught.
#include <boost/test/unit_test.hpp>

#include <cstdlib>
#include <functional>
#include <limits>

#include "framework/core/check.hpp"
#include "framework/core/disk_cache.hpp"
#include "framework/core/temporary_folder.hpp"
#include "nodes/physics/mesh/body_mesh.hpp"
#include "nodes/physics/mesh/solid_file.hpp"
#include "tests/nodes/physics/mesh/mesh_files.hpp"
#include "tests/support/shapes.hpp"

BOOST_AUTO_TEST_SUITE(solid_file_test)

using namespace tactor;
namespace fs = std::filesystem;

namespace {

std::string message_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const InputError& e) {
    BOOST_TEST_MESSAGE(e.what());
    return e.what();
  }
  return "accepted";
}

bool has(const std::string& text, const std::string& phrase) {
  BOOST_TEST_INFO(text);
  return text.find(phrase) != std::string::npos;
}

std::vector<fs::path> files_in(const fs::path& folder) {
  if (!fs::exists(folder)) return {};
  return {fs::directory_iterator(folder), fs::directory_iterator()};
}

Body body_of(const fs::path& mesh, std::optional<double> scale = {}) {
  Body body;
  body.name = "stone";
  body.shape = MeshShape{mesh, scale};
  return body;
}

/// The cache of this test program alone.
struct Fixture {
  Fixture() { setenv("TACTOR_CACHE", cache.path().c_str(), 1); }
  TemporaryFolder cache;
};

}  // namespace

BOOST_GLOBAL_FIXTURE(Fixture);

BOOST_AUTO_TEST_CASE(the_second_load_is_the_first_with_its_report_and_comes_from_the_cache) {
  const TemporaryFolder folder;
  const fs::path file = test::write(folder.path() / "box.stl", test::as_binary_stl(test::box({1, 1, 20000})));
  const fs::path cache = folder.path() / "cache";
  const SolidFile first = load_solid(file, cache);
  BOOST_TEST(first.report.repairs.size() == 1U);
  BOOST_TEST(first.report.warnings.size() == 1U);
  BOOST_TEST(files_in(cache).size() == 1U);
  const SolidFile second = load_solid(file, cache);
  BOOST_TEST((second.mesh.vertices == first.mesh.vertices));
  BOOST_TEST((second.mesh.faces == first.mesh.faces));
  BOOST_TEST((second.report == first.report));
  BOOST_TEST(first.notes.empty());
  BOOST_TEST(second.notes.empty());
  // Another name for the same bytes is the same entry; other bytes are another.
  load_solid(test::write(folder.path() / "other.stl", test::as_binary_stl(test::box({1, 1, 20000}))), cache);
  BOOST_TEST(files_in(cache).size() == 1U);
  const SolidFile other = load_solid(test::write(file, test::as_binary_stl(test::box({1, 1, 4}))), cache);
  BOOST_TEST(other.mesh.vertices[7].z == 2);
  BOOST_TEST(files_in(cache).size() == 2U);
}

BOOST_AUTO_TEST_CASE(a_damaged_cache_is_noted_and_made_again_and_one_that_cannot_be_written_is_noted) {
  const TemporaryFolder folder;
  const fs::path file = test::write(folder.path() / "box.off", test::as_off(test::box({1, 1, 1})));
  const fs::path cache = folder.path() / "cache";
  const SolidFile first = load_solid(file, cache);
  fs::resize_file(files_in(cache).at(0), 100);
  const SolidFile second = load_solid(file, cache);
  BOOST_TEST_REQUIRE(second.notes.size() == 1U);
  BOOST_TEST(has(second.notes[0], "the cached file is damaged; computed again"));
  BOOST_TEST((second.mesh.vertices == first.mesh.vertices));
  BOOST_TEST(load_solid(file, cache).notes.empty());
  const SolidFile third = load_solid(file, file / "cache");
  BOOST_TEST_REQUIRE(third.notes.size() == 1U);
  BOOST_TEST(has(third.notes[0], "the cache cannot be written"));
  BOOST_TEST((third.mesh.faces == first.mesh.faces));
}

BOOST_AUTO_TEST_CASE(an_index_or_count_out_of_range_under_a_right_checksum_is_read_anew_and_told) {
  const TemporaryFolder folder;
  const fs::path file = test::write(folder.path() / "box.off", test::as_off(test::box({1, 1, 1})));
  const fs::path cache = folder.path() / "cache";
  const SolidFile good = load_solid(file, cache);
  const fs::path entry = files_in(cache).at(0);
  const DiskCache disk("mesh", 2, cache);
  const std::string key = entry.stem().string();
  BOOST_REQUIRE(disk.load(key).bytes.has_value());
  std::vector<std::string> entries{"", "x", to_bytes(good) + "x", std::string(200, '\xff')};
  const auto add = [&](const std::function<void(SolidFile&)>& change) {
    SolidFile bad = good;
    change(bad);
    entries.push_back(to_bytes(bad));
  };
  for (const int index : {0x7fffffff, 8, -1, std::numeric_limits<int>::min()}) {
    add([&](SolidFile& s) { s.mesh.faces[5][1] = index; });
  }
  add([](SolidFile& s) { s.mesh.faces[5][1] = s.mesh.faces[5][0]; });
  add([](SolidFile& s) { s.mesh.faces.clear(); });
  add([](SolidFile& s) { s.mesh.vertices.pop_back(); });
  add([](SolidFile& s) { s.mesh.vertices[0].x = std::numeric_limits<double>::quiet_NaN(); });
  add([](SolidFile& s) { s.mesh.vertices[0].y = 1e300; });
  // A count of the vertices that asks for more than the entry holds.
  for (const char byte : {'\x7f', '\xff'}) {
    entries.push_back(to_bytes(good));
    entries.back().replace(0, 8, 8, byte);
  }
  for (const std::string& bytes : entries) {
    BOOST_TEST(disk.store(key, bytes) == "");
    const SolidFile again = load_solid(file, cache);
    BOOST_TEST((again.mesh.faces == good.mesh.faces));
    BOOST_TEST((again.mesh.vertices == good.mesh.vertices));
    BOOST_TEST_REQUIRE(again.notes.size() == 1U);
    BOOST_TEST(again.notes[0] == entry.string() + ": the cached file holds no solid; computed again and replaced");
    BOOST_TEST(load_solid(file, cache).notes.empty());
  }
}

BOOST_AUTO_TEST_CASE(what_is_refused_is_not_kept_and_names_its_file) {
  const TemporaryFolder folder;
  TriangleMesh open = test::box({1, 1, 1});
  open.faces.pop_back();
  const fs::path file = test::write(folder.path() / "open.obj", test::as_obj(open));
  const fs::path cache = folder.path() / "cache";
  for (int i = 0; i < 2; ++i) {
    BOOST_TEST(message_of([&] { load_solid(file, cache); }).starts_with(file.string() + ": the surface is not closed"));
  }
  BOOST_TEST(files_in(cache).empty());
  BOOST_TEST(has(message_of([&] { load_solid(folder.path() / "none.off"); }), "none.off: there is no such file"));
  BOOST_TEST(has(message_of([&] { load_solid(folder.path()); }), "expected a file, found a folder"));
  const fs::path text = test::write(folder.path() / "broken.off", "OFF\n4 4 0\n0 0 0\n1 0 O\n");
  BOOST_TEST(message_of([&] {
               load_body_mesh(body_of(text));
             }).starts_with("body 'stone': " + text.string() + ":4: expected a coordinate of a vertex, found 'O'"));
}

BOOST_AUTO_TEST_CASE(a_body_of_another_unit_is_refused_unless_it_says_its_scale) {
  const TemporaryFolder folder;
  const auto mesh = [&](const std::string& name, double length) {
    return test::write(folder.path() / name, test::as_off(test::box({length, length / 2, length / 4})));
  };
  const fs::path large = mesh("large.off", 70.2), small = mesh("small.off", 0.0005);
  BOOST_TEST(has(message_of([&] { load_body_mesh(body_of(large)); }),
                 "body 'stone': " + large.string() + ": is 70.2 m long; is it in mm? write scale: 0.001"));
  BOOST_TEST(has(message_of([&] { load_body_mesh(body_of(small)); }), "is 0.5 mm long; write its scale"));
  for (const auto& [file, scale, length] :
       {std::tuple{large, 1.0, 70.2}, {small, 1.0, 0.0005}, {large, 2.0, 140.4}, {large, 1e-6, 70.2e-6}}) {
    Notes notes;
    const TriangleMesh loaded = load_body_mesh(body_of(file, scale), &notes);
    BOOST_TEST(loaded.vertices[7].x == length / 2, boost::test_tools::tolerance(1e-14));
    BOOST_TEST_REQUIRE(notes.size() == 1U);
    BOOST_TEST(has(notes[0], "unusual"));
  }
  // The usual sizes and both ends of them need no scale, and a scale that brings a body there is nothing to speak of.
  for (const double length : {0.001, 0.07, 10.0}) {
    Notes notes;
    load_body_mesh(body_of(mesh("usual.off", length)), &notes);
    load_body_mesh(body_of(large, 0.001), &notes);
    BOOST_TEST(notes.empty());
  }
}

BOOST_AUTO_TEST_CASE(repairs_and_warnings_are_told_once_with_body_and_file) {
  const TemporaryFolder folder;
  TriangleMesh box = test::box({0.0001, 0.0001, 2});
  std::swap(box.faces[0][0], box.faces[0][1]);
  Body body = body_of(test::write(folder.path() / "box.ply", test::as_ascii_ply(box)));
  body.motion = Motion::rigid;
  Notes notes;
  load_body_mesh(body, &notes);
  body_inertia(body, &notes);
  load_body_mesh(body, &notes);
  BOOST_TEST_REQUIRE(notes.size() == 2U);
  BOOST_TEST(notes[0] == "body 'stone': " + body.mesh()->file.string() +
                             ": repaired: 1 face was turned round to look out of the material");
  BOOST_TEST(
      has(notes[1], "body 'stone': " + body.mesh()->file.string() + ": warning: 8 faces are more than 10,000 times"));
}

BOOST_AUTO_TEST_SUITE_END()
