// Pictures of scenes: what is drawn where, against the geometry of the bodies.
#include "app/report/scene_picture.hpp"

#include <zlib.h>

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "app/base64.hpp"

BOOST_AUTO_TEST_SUITE(scene_picture_test)

using namespace tactor;

namespace {

struct Picture {
  std::size_t width = 0, height = 0;
  std::string rows;

  /// 0 red, 1 green, 2 blue, 3 opacity.
  [[nodiscard]] int at(std::size_t x, std::size_t y, std::size_t channel) const {
    return static_cast<unsigned char>(rows[y * (4 * width + 1) + 1 + 4 * x + channel]);
  }
  /// Of how many pixels the picture is, in parts of all.
  [[nodiscard]] double covered() const {
    double sum = 0;
    for (std::size_t y = 0; y < height; ++y) {
      for (std::size_t x = 0; x < width; ++x) sum += at(x, y, 3) / 255.0;
    }
    return sum / static_cast<double>(width * height);
  }
};

std::uint32_t number(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8U | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

/// Reads a PNG file of rows without filters, and checks its checksums.
Picture read_png(const std::string& png) {
  BOOST_REQUIRE(png.substr(0, 8) == "\x89PNG\r\n\x1a\n");
  Picture picture;
  for (std::size_t at = 8; at < png.size();) {
    const std::size_t size = number(png, at);
    const std::string kind = png.substr(at + 4, 4), data = png.substr(at + 8, size);
    BOOST_TEST(number(png, at + 8 + size) == crc32_z(0, reinterpret_cast<const Bytef*>(png.data() + at + 4), 4 + size));
    if (kind == "IHDR") {
      picture.width = number(data, 0);
      picture.height = number(data, 4);
    } else if (kind == "IDAT") {
      picture.rows.resize(picture.height * (4 * picture.width + 1));
      uLongf length = static_cast<uLongf>(picture.rows.size());
      BOOST_REQUIRE(uncompress(reinterpret_cast<Bytef*>(picture.rows.data()), &length,
                               reinterpret_cast<const Bytef*>(data.data()), static_cast<uLong>(size)) == Z_OK);
      BOOST_TEST(length == picture.rows.size());
    }
    at += size + 12;
  }
  for (std::size_t y = 0; y < picture.height; ++y) BOOST_TEST(picture.rows[y * (4 * picture.width + 1)] == '\0');
  return picture;
}

Body body_of(Shape shape, const Vec3& p_W, Motion motion = Motion::fixed) {
  Body body;
  body.name = "body";
  body.shape = std::move(shape);
  body.X_WB.p = p_W;
  body.motion = motion;
  return body;
}

/// Looked at along -x, z up: right in the picture is +y.
Scene scene_of(std::vector<Body> bodies) {
  Scene scene;
  scene.camera = {{1, 0, 0}, {0, 0, 1}};
  scene.bodies = std::move(bodies);
  return scene;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_ball_is_a_disc_that_fills_the_picture_but_for_its_margin) {
  const Picture picture = read_png(scene_png(scene_of({body_of(SphereShape{0.02}, {0.3, -0.1, 0.2})}), 200, 100));
  BOOST_TEST(picture.width == 200U);
  BOOST_TEST(picture.height == 100U);
  // Its diameter is 88 of 100 pixels.
  BOOST_TEST(picture.covered() == std::numbers::pi * 44 * 44 / 20000, boost::test_tools::tolerance(0.01));
  BOOST_TEST(picture.at(100, 50, 3) == 255);
  BOOST_TEST(picture.at(100, 3, 3) == 0);
  BOOST_TEST(picture.at(30, 50, 3) == 0);
}

BOOST_AUTO_TEST_CASE(a_box_and_a_capsule_have_their_outlines) {
  const Picture box = read_png(scene_png(scene_of({body_of(BoxShape{{0.5, 0.1, 0.2}}, {})}), 100, 100));
  BOOST_TEST(box.covered() == 0.88 * 0.44, boost::test_tools::tolerance(0.02));
  const Picture capsule = read_png(scene_png(scene_of({body_of(CapsuleShape{0.01, 0.02}, {})}), 100, 100));
  // 4 radii high: 22 pixels a radius.
  BOOST_TEST(capsule.covered() == (std::numbers::pi * 22 * 22 + 44 * 44) / 1e4, boost::test_tools::tolerance(0.02));
}

BOOST_AUTO_TEST_CASE(right_and_up_are_where_the_camera_has_them_and_the_nearer_body_hides_the_other) {
  const Body tool = body_of(SphereShape{0.01}, {0, 0.1, 0}, Motion::translation);
  const Body fixed = body_of(SphereShape{0.01}, {0, -0.1, 0});
  const Picture picture = read_png(scene_png(scene_of({fixed, tool}), 220, 40));
  // Tools are orange, others bluish grey; +y is right.
  BOOST_TEST(picture.at(200, 20, 0) > picture.at(200, 20, 2) + 50);
  BOOST_TEST(picture.at(20, 20, 2) > picture.at(20, 20, 0));

  const Picture hidden = read_png(scene_png(scene_of({body_of(SphereShape{0.01}, {-0.1, 0, 0}),
                                                      body_of(SphereShape{0.01}, {0.1, 0, 0}, Motion::translation)}),
                                            50, 50));
  BOOST_TEST(hidden.at(25, 25, 0) > hidden.at(25, 25, 2) + 50);

  // Light comes from above.
  const Picture ball = read_png(scene_png(scene_of({body_of(SphereShape{0.01}, {})}), 100, 100));
  BOOST_TEST(ball.at(50, 20, 0) > ball.at(50, 80, 0) + 20);
}

BOOST_AUTO_TEST_CASE(a_plane_lies_behind_and_a_scene_of_nothing_else_has_no_picture) {
  Scene scene = scene_of({body_of(PlaneShape{}, {}), body_of(SphereShape{0.01}, {0, 0, 0.01}, Motion::translation)});
  scene.camera = {{1, 0, 1}, {0, 0, 1}};
  const Picture picture = read_png(scene_png(scene, 60, 60));
  BOOST_TEST(picture.covered() > 0.95);
  BOOST_TEST(picture.at(30, 30, 0) > picture.at(30, 30, 2) + 50);
  BOOST_TEST(picture.at(5, 5, 2) >= picture.at(5, 5, 0));
  scene.bodies.pop_back();
  BOOST_TEST(scene_png(scene, 60, 60).empty());
  BOOST_TEST(scene_figure(scene, "nothing").empty());
  BOOST_TEST(scene_figure(scene_of({}), "nothing").empty());
}

BOOST_AUTO_TEST_CASE(an_arrow_shows_the_force_on_the_tool_over_all_bodies) {
  const Scene scene = scene_of(
      {body_of(SphereShape{0.01}, {0, 0.02, 0}), body_of(SphereShape{0.01}, {0, -0.02, 0}, Motion::translation)});
  const auto is_arrow = [](const Picture& picture, std::size_t x, std::size_t y) {
    return picture.at(x, y, 3) > 200 && picture.at(x, y, 2) > 60 && picture.at(x, y, 1) < 60;
  };
  const auto reach = [&](const Vec3& force_W) {
    const Picture picture = read_png(scene_png(scene, 300, 150, force_W));
    std::pair<std::size_t, std::size_t> ends{picture.width, 0};
    for (std::size_t y = 0; y < picture.height; ++y) {
      for (std::size_t x = 0; x < picture.width; ++x) {
        if (is_arrow(picture, x, y)) ends = {std::min(ends.first, x), std::max(ends.second, x)};
      }
    }
    return ends;
  };
  // +y is right; the tool is left, at about 80 of 300 pixels.
  const auto right = reach({0, 2, 0}), left = reach({0, -0.1, 0});
  BOOST_TEST(right.second > right.first + 30);
  BOOST_TEST(right.first < 100U);
  BOOST_TEST(right.second > 100U);
  BOOST_TEST(left.second < 100U);
  // None without a force.
  BOOST_TEST(reach({}).second == 0U);
}

BOOST_AUTO_TEST_CASE(a_figure_holds_the_picture_and_its_caption_and_a_lost_mesh_is_said) {
  const Scene scene = scene_of({body_of(SphereShape{0.01}, {})});
  const std::string html = scene_figure(scene, "A <b>ball</b>.");
  BOOST_TEST(html.find("data:image/png;base64," + base64(scene_png(scene, 480, 300)) + "\"") != std::string::npos);
  BOOST_TEST(html.find("<figcaption>A <b>ball</b>.</figcaption>") != std::string::npos);
  BOOST_TEST(
      scene_figure(scene_of({body_of(MeshShape{"/nowhere/to.off"}, {})}), "lost").find("No picture of the scene: ") !=
      std::string::npos);
}

BOOST_AUTO_TEST_CASE(bytes_become_the_text_of_the_rfc) {
  const std::vector<std::pair<std::string, std::string>> known{{"", ""},
                                                               {"f", "Zg=="},
                                                               {"fo", "Zm8="},
                                                               {"foo", "Zm9v"},
                                                               {"foob", "Zm9vYg=="},
                                                               {"fooba", "Zm9vYmE="},
                                                               {"foobar", "Zm9vYmFy"},
                                                               {std::string("\xff\xfe\x00", 3), "//4A"}};
  for (const auto& [bytes, text] : known) BOOST_TEST(base64(bytes) == text);
}

BOOST_AUTO_TEST_SUITE_END()
