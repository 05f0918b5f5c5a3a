// Cells that come from the cache are those that were built; whatever is wrong with the file, they are built anew.
#include <boost/test/unit_test.hpp>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>

#include "nodes/physics/geometry/cell_cache.hpp"
#include "tests/support/shapes.hpp"

BOOST_AUTO_TEST_SUITE(cell_cache_test)

using namespace tactor;
namespace fs = std::filesystem;

namespace {

/// A folder of its own for each test, removed afterwards.
struct Folder {
  Folder() : path(fs::temp_directory_path() / ("tactor_cells_" + std::to_string(::getpid()))) { fs::remove_all(path); }
  ~Folder() { fs::remove_all(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  fs::path path;
};

const TriangleMesh& shape() {
  static const TriangleMesh mesh = test::icosphere(0.05, 2);
  return mesh;
}
constexpr CellOptions options{.resolution = 16, .band = 0.004};

std::string content(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}
void write(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

/// Whether both answer alike, inside, outside and far.
bool same_answers(const CellDistance& a, const CellDistance& b) {
  for (int i = 0; i < 500; ++i) {
    const Vec3 x{0.07 * std::sin(1.7 * i), 0.07 * std::cos(2.3 * i), 0.1 * std::sin(0.9 * i)};
    if (!(a.nearest(x) == b.nearest(x))) return false;
    Points8 points;
    for (std::size_t k = 0; k < 8; ++k) {
      points.x[k] = static_cast<float>(x.x), points.y[k] = static_cast<float>(x.y),
      points.z[k] = static_cast<float>(x.z);
    }
    std::array<float, 8> of_a{}, of_b{};
    a.lower_bounds(points, 0xff, of_a);
    b.lower_bounds(points, 0xff, of_b);
    if (of_a != of_b) return false;
  }
  return true;
}

}  // namespace

BOOST_AUTO_TEST_CASE(what_comes_from_the_cache_is_what_was_built) {
  const Folder folder;
  const DiskCache cache = cell_cache(folder.path);
  std::vector<std::string> notes;
  const CellDistance built = cached_cell_distance(shape(), options, cache, &notes);
  const std::string key = cell_key(shape(), options);
  BOOST_TEST(fs::exists(cache.file(key)));
  const CellDistance loaded = cached_cell_distance(shape(), options, cache, &notes);
  BOOST_TEST(notes.empty());
  BOOST_TEST(to_bytes(built.data()) == to_bytes(loaded.data()));
  BOOST_TEST(same_answers(built, loaded));
  BOOST_TEST(same_answers(loaded, CellDistance(shape(), options)));
}

BOOST_AUTO_TEST_CASE(the_cache_is_what_is_read) {
  // Another bound of rounding would be found nowhere else.
  const Folder folder;
  const DiskCache cache = cell_cache(folder.path);
  CellData data = build_cells(shape(), options);
  data.slack += 0.125;
  BOOST_TEST(cache.store(cell_key(shape(), options), to_bytes(data)) == "");
  BOOST_TEST(cached_cell_distance(shape(), options, cache, nullptr).data().slack == data.slack);
}

BOOST_AUTO_TEST_CASE(every_change_of_mesh_or_options_has_an_entry_of_its_own) {
  const std::string key = cell_key(shape(), options);
  TriangleMesh moved = shape();
  moved.vertices[7].y = std::nextafter(moved.vertices[7].y, 1.0);
  BOOST_TEST(cell_key(moved, options) != key);
  TriangleMesh turned = shape();
  std::rotate(turned.faces[3].begin(), turned.faces[3].begin() + 1, turned.faces[3].end());
  BOOST_TEST(cell_key(turned, options) != key);
  BOOST_TEST(cell_key(shape(), {.resolution = 17, .band = 0.004}) != key);
  BOOST_TEST(cell_key(shape(), {.resolution = 16, .band = 0.005}) != key);
  BOOST_TEST(cell_key(shape(), options) == key);
}

BOOST_AUTO_TEST_CASE(a_file_damaged_anywhere_is_built_anew_and_the_note_names_it) {
  const Folder folder;
  const DiskCache cache = cell_cache(folder.path);
  const CellDistance built = cached_cell_distance(shape(), options, cache, nullptr);
  const fs::path file = cache.file(cell_key(shape(), options));
  const std::string good = content(file);
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < 64; ++i) places.push_back(i);
  for (std::size_t i = 64; i < good.size(); i += good.size() / 40) places.push_back(i);
  places.push_back(good.size() - 1);
  for (const std::size_t place : places) {
    std::string bad = good;
    bad[place] = static_cast<char>(bad[place] ^ 0x20);
    write(file, bad);
    std::vector<std::string> notes;
    const CellDistance again = cached_cell_distance(shape(), options, cache, &notes);
    BOOST_TEST(to_bytes(again.data()) == to_bytes(built.data()));
    BOOST_TEST(content(file) == good);
    // A version that is not ours is no damage; all else is told.
    const bool version = place >= 8 && place < 12;
    BOOST_TEST(notes.size() == (version ? 0U : 1U));
    for (const std::string& note : notes) BOOST_TEST(note.find(file.string()) == 0U);
  }
  for (const std::size_t size : {std::size_t{0}, std::size_t{20}, good.size() / 2, good.size() - 1}) {
    write(file, good.substr(0, size));
    std::vector<std::string> notes;
    const CellDistance again = cached_cell_distance(shape(), options, cache, &notes);
    BOOST_TEST(to_bytes(again.data()) == to_bytes(built.data()));
    BOOST_TEST(notes.size() == 1U);
    BOOST_TEST(content(file) == good);
  }
}

BOOST_AUTO_TEST_CASE(a_sound_file_of_another_layout_or_mesh_is_built_anew_and_told) {
  const Folder folder;
  const DiskCache cache = cell_cache(folder.path);
  const CellDistance built(shape(), options);
  const std::string key = cell_key(shape(), options), bytes = to_bytes(built.data());
  // A build of another mesh would answer with faces that this one may not have.
  const std::string other = to_bytes(build_cells(test::icosphere(0.05, 3), options));
  for (const std::string& foreign : {std::string(), other, std::string("cells"), bytes.substr(0, bytes.size() - 4),
                                     bytes + "more", std::string(1000, '\xff')}) {
    BOOST_TEST(cache.store(key, foreign) == "");
    std::vector<std::string> notes;
    const CellDistance again = cached_cell_distance(shape(), options, cache, &notes);
    BOOST_TEST(to_bytes(again.data()) == bytes);
    BOOST_REQUIRE(notes.size() == 1U);
    BOOST_TEST(notes[0] ==
               cache.file(key).string() + ": the cached file holds no cells of this mesh; computed again and replaced");
  }
}

BOOST_AUTO_TEST_CASE(an_index_or_count_out_of_range_under_a_right_checksum_is_built_anew_and_told) {
  const Folder folder;
  const DiskCache cache = cell_cache(folder.path);
  const CellData good = build_cells(shape(), options);
  const std::string key = cell_key(shape(), options), bytes = to_bytes(good);
  const auto listed = static_cast<std::size_t>(std::distance(
      good.cells.begin(),
      std::find_if(good.cells.begin(), good.cells.end(), [](const Cell& c) { return (c.list & 15) != 0; })));
  const auto held = static_cast<std::size_t>(
      std::distance(good.block.begin(), std::find_if(good.block.begin(), good.block.end(), [&](const CellBlock& b) {
                      return b.cells == static_cast<std::int32_t>(listed / 512);
                    })));
  BOOST_REQUIRE(listed < good.cells.size());
  BOOST_REQUIRE(held < good.block.size());
  const std::size_t batch = good.cells[listed].list >> 4;
  const auto last_node = static_cast<std::int32_t>(good.tree.nodes.size() - 1);
  BOOST_REQUIRE(last_node > 0);
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::function<void(CellData&)>> changes{
      [](CellData& d) { d.tree.records[3].face = 0x7fffffff; },
      [](CellData& d) { d.tree.records[3].face = -2; },
      [](CellData& d) { d.tree.records[3].face = d.surface.size(); },
      [](CellData& d) { d.tree.records.front().face = -1; },
      [](CellData& d) { d.tree.records.back().face = 0; },
      [](CellData& d) { d.tree.records.clear(); },
      [](CellData& d) { d.tree.nodes.clear(); },
      [&](CellData& d) { d.tree.nodes[0].child[0] = last_node + 1; },
      [](CellData& d) { d.tree.nodes[0].child[0] = 0x7fffffff; },
      [](CellData& d) { d.tree.nodes[0].child[0] = std::numeric_limits<std::int32_t>::min(); },
      [](CellData& d) { d.tree.nodes[0].child[0] = ~static_cast<std::int32_t>(d.tree.records.size() - 8); },
      [&](CellData& d) { d.tree.nodes[static_cast<std::size_t>(last_node)].child[0] = last_node; },  // a circle
      [&](CellData& d) { d.tree.nodes[static_cast<std::size_t>(last_node)].child[0] = 1; },
      [](CellData& d) { d.tree.nodes[0].child[1] = d.tree.nodes[0].child[0]; },  // a node with two parents
      [](CellData& d) { d.surface.corners.pop_back(); },
      [](CellData& d) { d.surface.normals.pop_back(); },
      [](CellData& d) { d.surface.corners.clear(), d.surface.normals.clear(); },
      [](CellData& d) { d.blocks[1] += 1; },
      [](CellData& d) {
        d.blocks = {-1, -1, static_cast<std::int32_t>(d.block.size())};
      },
      [](CellData& d) {
        d.blocks = {0, 0, 0}, d.block.clear();
      },
      [](CellData& d) { d.block.pop_back(); },
      [&](CellData& d) { d.block[held].cells = 0x7fffffff; },
      [&](CellData& d) { d.block[held].cells = -2; },
      [&](CellData& d) { d.block[held].palette = 0xffffffff; },
      [](CellData& d) { d.cells.pop_back(); },
      [&](CellData& d) { d.cells[listed].list = 0xffffffff; },
      [&](CellData& d) { d.cells[listed].list = static_cast<std::uint32_t>(d.batches.size() << 4 | 1); },
      [&](CellData& d) { d.palette[d.palette.size() / 2] = static_cast<std::uint32_t>(d.tree.records.size()); },
      [&](CellData& d) { d.palette.resize(1); },
      [&](CellData& d) { d.batches[batch].fill(0xffff); },
      [&](CellData& d) { d.batches[batch].fill(0); },  // nothing but the face that fills up
      [](CellData& d) { d.batch_bound.pop_back(); },
      [](CellData& d) { d.edge = 0; },
      [](CellData& d) { d.edge = -1; },
      [](CellData& d) { d.edge = nan; },
      [](CellData& d) { d.low.y = nan; },
      [](CellData& d) { d.box_high.z = std::numeric_limits<double>::infinity(); },
      [](CellData& d) { d.tree.origin.x = nan; },
  };
  for (std::size_t i = 0; i < changes.size(); ++i) {
    CellData bad = good;
    changes[i](bad);
    BOOST_TEST(cache.store(key, to_bytes(bad)) == "");
    std::vector<std::string> notes;
    const CellDistance again = cached_cell_distance(shape(), options, cache, &notes);
    BOOST_TEST(to_bytes(again.data()) == bytes, "change " << i << " was believed");
    BOOST_TEST(notes.size() == 1U, "change " << i);
    BOOST_TEST(cells_from_bytes(cache.load(key).bytes.value().view()).has_value());
  }
}

BOOST_AUTO_TEST_CASE(whatever_the_numbers_of_an_entry_are_its_queries_end) {
  const std::string bytes = to_bytes(build_cells(shape(), options));
  std::uint64_t state = 1;
  const auto any = [&state](std::size_t below) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return static_cast<std::size_t>(state >> 33U) % below;
  };
  int believed = 0;
  for (int i = 0; i < 300; ++i) {
    std::string bad = bytes;
    for (std::size_t k = 0; k <= any(4); ++k) bad[any(bad.size())] = static_cast<char>(any(256));
    const std::optional<CellData> data = cells_from_bytes(bad);
    if (!data) continue;
    ++believed;
    const CellDistance distance(*data);
    for (int j = 0; j < 40; ++j) {
      const Nearest nearest =
          distance.nearest({0.06 * std::sin(1.7 * j), 0.06 * std::cos(2.3 * j), 0.06 * std::sin(j)});
      BOOST_REQUIRE(nearest.face >= 0);
      BOOST_REQUIRE(nearest.face < data->surface.size());
    }
  }
  BOOST_TEST(believed > 100);
}

BOOST_AUTO_TEST_CASE(a_folder_that_cannot_be_written_costs_the_building_and_a_note) {
  const Folder folder;
  fs::create_directories(folder.path);
  write(folder.path / "file", "in the way");
  std::vector<std::string> notes;
  const CellDistance built = cached_cell_distance(shape(), options, cell_cache(folder.path / "file"), &notes);
  BOOST_REQUIRE(notes.size() == 1U);
  BOOST_TEST(notes[0].find("the cache cannot be written") != std::string::npos);
  BOOST_TEST(same_answers(built, CellDistance(shape(), options)));
}

BOOST_AUTO_TEST_SUITE_END()
