// The bytes that a page gets of a run whose bodies deform, decoded as docs/reference/view_protocol.md says and by
// nothing of ours.
#include "app/view/show.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <vector>

#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"

BOOST_AUTO_TEST_SUITE(show_test)

using namespace tactor;
namespace fs = std::filesystem;

namespace {

using Point = std::array<float, 3>;

/// Reads little-endian numbers one after the other.
struct Bytes {
  const std::string& bytes;
  std::size_t at = 0;
  template <class T>
  T take() {
    T value;
    BOOST_REQUIRE(at + sizeof value <= bytes.size());
    std::memcpy(&value, bytes.data() + at, sizeof value);
    at += sizeof value;
    return value;
  }
};

struct Rows {
  double time = 0;            // s, of a set; of rows that of the last
  std::vector<float> values;  // of all rows
};

/// What came of one stream, in its order.
std::vector<Rows> rows_of(const Show& show, std::size_t stream) {
  const nlohmann::json hello = nlohmann::json::parse(show.hello);
  std::vector<Rows> found;
  for (const std::string& frame : show.frames) {
    Bytes in{frame};
    BOOST_REQUIRE(in.take<std::uint32_t>() == 1U);
    const auto chunks = in.take<std::uint32_t>();
    in.take<std::uint64_t>();
    for (std::uint32_t c = 0; c < chunks; ++c) {
      in.take<std::uint32_t>();
      const auto sections = in.take<std::uint32_t>();
      in.take<double>();
      for (std::uint32_t s = 0; s < sections; ++s) {
        const bool is_set = in.take<std::uint16_t>() == 1;
        const auto of = in.take<std::uint16_t>();
        const auto n = in.take<std::uint32_t>();
        Rows rows;
        for (std::uint32_t i = 0; i < (is_set ? 1 : n); ++i) rows.time = in.take<double>();
        for (std::size_t i = 0; i < n * hello["streams"][of]["columns"].size(); ++i) {
          rows.values.push_back(in.take<float>());
        }
        in.at = (in.at + 7) / 8 * 8;
        if (of == stream) found.push_back(rows);
      }
    }
    BOOST_REQUIRE(in.at == frame.size());
  }
  return found;
}

std::size_t stream_of(const Show& show, const std::string& role) {
  const nlohmann::json hello = nlohmann::json::parse(show.hello);
  for (std::size_t i = 0; i < hello["streams"].size(); ++i) {
    if (hello["streams"][i]["role"] == role) return i;
  }
  BOOST_FAIL("no stream " + role);
  return 0;
}

/// The vertices of a mesh that came, in the frame of its body.
std::vector<Point> vertices_of(const std::string& message) {
  Bytes in{message};
  BOOST_REQUIRE(in.take<std::uint32_t>() == 2U);
  in.take<std::uint32_t>();
  const auto vertices = in.take<std::uint32_t>();
  in.take<std::uint32_t>();
  std::vector<Point> points(vertices);
  for (Point& p : points) {
    for (float& x : p) x = in.take<float>();
  }
  return points;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_page_gets_all_vertices_of_all_bodies_that_deform_and_sees_the_ball_press_one_in) {
  Registry registry({TACTOR_NODE_FOLDER});
  GraphSpec graph = load_graph(fs::path(TACTOR_SOURCE_DIR) / "graphs/gel_cube/scene.yaml", registry, {});
  graph.duration = Duration{400'000'000};
  // Another block beside the first, of other tetrahedra.
  Body other = graph.scene.bodies.front();
  BOOST_REQUIRE(other.name == "gel");
  other.name = "other";
  other.X_WB.p = {0.2, 0.1, 0.05};
  other.deformable.tetrahedra = 300;
  graph.scene.bodies.push_back(other);
  Session session(make_plan(graph));
  const Show show =
      show_of(session, nullptr, {.note = [](const std::string&) {}, .progress = [](double) { return true; }});

  const nlohmann::json hello = nlohmann::json::parse(show.hello);
  std::vector<std::vector<Point>> rest;
  std::size_t all = 0;
  for (const nlohmann::json& body : hello["scene"]["bodies"]) {
    if (!body.contains("deforms")) continue;
    rest.push_back(vertices_of(show.meshes.at(body["mesh"].get<std::size_t>())));
    all += rest.back().size();
  }
  BOOST_REQUIRE(rest.size() == 2U);
  BOOST_TEST(rest[0].size() != rest[1].size());

  const std::vector<Rows> sets = rows_of(show, stream_of(show, "surface"));
  BOOST_REQUIRE(sets.size() > 5U);
  double dent = 0;
  for (const Rows& set : sets) {
    BOOST_REQUIRE(set.values.size() == 3 * all);
    for (std::size_t v = 0; v < all; ++v) {
      const bool is_first = v < rest[0].size();
      const Point& was = is_first ? rest[0][v] : rest[1][v - rest[0].size()];
      const Point is{set.values[3 * v], set.values[3 * v + 1], set.values[3 * v + 2]};
      const Vec3 moved = Vec3{is[0] - was[0], is[1] - was[1], is[2] - was[2]} - (is_first ? Vec3{} : other.X_WB.p);
      // Nothing touches the other block, and both are held at their bottom.
      const bool rests = !is_first || was[2] < -0.0199F;
      BOOST_TEST_REQUIRE(norm(moved) < (rests ? 1e-7 : 0.02));
      if (set.time < 0.05) BOOST_TEST_REQUIRE(norm(moved) < 1e-7);
      if (is_first) dent = std::min(dent, moved.z);
    }
  }
  // The ball's path ends 8 mm below where it touches; the coupling gives way by some of that.
  BOOST_TEST_MESSAGE("the deepest vertex is " << 1e3 * dent << " mm below its place, of " << sets.size() << " sets");
  BOOST_TEST(dent < -1e-3);
  BOOST_TEST(dent > -0.012);
  // Sets come in the order of their times, no two at one time.
  for (std::size_t i = 1; i < sets.size(); ++i) BOOST_TEST(sets[i].time > sets[i - 1].time);
}

BOOST_AUTO_TEST_SUITE_END()
