#include "app/report/scene_picture.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "app/base64.hpp"
#include "app/report/html_page.hpp"
#include "framework/core/check.hpp"
#include "nodes/physics/mesh/turned_mesh.hpp"

namespace tactor {

namespace {

struct Rgb {
  double r = 0, g = 0, b = 0;
};

constexpr Rgb fixed_body{169, 182, 196}, moving_body{134, 168, 200}, tool_body{224, 160, 48}, plane_body{223, 228, 232},
    force_arrow{106, 31, 176};
/// Samples of a pixel, each way.
constexpr int fineness = 2;
constexpr double margin = 0.06;   // of the picture, on each side
constexpr double ambient = 0.45;  // of the light

/// The axes of the camera in W. It looks along -toward.
struct CameraAxes {
  Vec3 right, up, toward;
};

CameraAxes axes_of(const Camera& camera) {
  const auto unit = [](const Vec3& v) { return (1 / norm(v)) * v; };
  const Vec3 toward = unit(camera.from_W);
  const Vec3 right = unit(cross(camera.up_W, toward));
  return {right, cross(toward, right), toward};
}

TriangleMesh square_mesh(double side) {
  const double half = 0.5 * side;
  return {{{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}}, {{0, 1, 2}, {0, 2, 3}}};
}

/// What is drawn, in W.
struct Painted {
  TriangleMesh mesh;
  Rgb color;
};

bool is_plane(const DrawnScene& drawn, std::size_t body) {
  return drawn.surfaces[body] == nullptr && std::holds_alternative<PlaneShape>(drawn.scene.bodies[body].shape);
}

/// Bodies but planes.
std::vector<Painted> painted_bodies(const DrawnScene& drawn) {
  std::vector<Painted> painted;
  for (std::size_t i = 0; i < drawn.scene.bodies.size(); ++i) {
    const Body& body = drawn.scene.bodies[i];
    if (is_plane(drawn, i)) continue;
    TriangleMesh mesh = drawn_surface(drawn, i);
    for (Vec3& vertex : mesh.vertices) vertex = transform(body.X_WB, vertex);
    const Rgb color = body.motion == Motion::fixed ? fixed_body : drawn.is_tool(i) ? tool_body : moving_body;
    painted.push_back({std::move(mesh), color});
  }
  return painted;
}

/// A picture that is being drawn: colours, and how near each sample is.
class Canvas {
 public:
  Canvas(int width, int height)
      : width_(width * fineness),
        height_(height * fineness),
        samples_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_)) {}

  /// `corners`: right and down in samples, and how near.
  void fill(const std::array<Vec3, 3>& corners, const Rgb& color) {
    const auto& [a, b, c] = corners;
    const double area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if (area == 0) return;
    const std::array<unsigned char, 3> bytes{byte(color.r), byte(color.g), byte(color.b)};
    const int left = std::max(0, static_cast<int>(std::floor(std::min({a.x, b.x, c.x}))));
    const int right = std::min(width_ - 1, static_cast<int>(std::ceil(std::max({a.x, b.x, c.x}))));
    const int top = std::max(0, static_cast<int>(std::floor(std::min({a.y, b.y, c.y}))));
    const int bottom = std::min(height_ - 1, static_cast<int>(std::ceil(std::max({a.y, b.y, c.y}))));
    for (int y = top; y <= bottom; ++y) {
      for (int x = left; x <= right; ++x) {
        const double px = x + 0.5, py = y + 0.5;
        const double of_b = ((px - a.x) * (c.y - a.y) - (c.x - a.x) * (py - a.y)) / area;
        const double of_c = ((b.x - a.x) * (py - a.y) - (px - a.x) * (b.y - a.y)) / area;
        if (of_b < 0 || of_c < 0 || of_b + of_c > 1) continue;
        const auto near = static_cast<float>(a.z + of_b * (b.z - a.z) + of_c * (c.z - a.z));
        Sample& sample = samples_[index(x, y)];
        if (near > sample.near) sample = {near, bytes};
      }
    }
  }

  /// Rows of red, green, blue and opacity, each behind a byte 0: a PNG's unfiltered rows.
  [[nodiscard]] std::string rows() const {
    std::string rows;
    rows.reserve(samples_.size() * 4 / (fineness * fineness) + static_cast<std::size_t>(height_));
    for (int y = 0; y < height_; y += fineness) {
      rows += '\0';
      for (int x = 0; x < width_; x += fineness) add_pixel(rows, x, y);
    }
    return rows;
  }

 private:
  /// Small, because setting up the memory of a canvas takes longer than to draw a scene.
  struct Sample {
    float near = -std::numeric_limits<float>::infinity();
    std::array<unsigned char, 3> color{};
  };

  static unsigned char byte(double value) {
    return static_cast<unsigned char>(std::lround(std::clamp(value, 0.0, 255.0)));
  }
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  void add_pixel(std::string& rows, int x, int y) const {
    std::array<int, 3> sum{};
    int seen = 0;
    for (int dy = 0; dy < fineness; ++dy) {
      for (int dx = 0; dx < fineness; ++dx) {
        const Sample& sample = samples_[index(x + dx, y + dy)];
        if (std::isinf(sample.near)) continue;
        ++seen;
        for (std::size_t c = 0; c < 3; ++c) sum[c] += sample.color[c];
      }
    }
    for (const int value : sum) rows += static_cast<char>(byte(seen == 0 ? 0 : static_cast<double>(value) / seen));
    rows += static_cast<char>(byte(255.0 * seen / (fineness * fineness)));
  }

  int width_, height_;
  std::vector<Sample> samples_;
};

/// Where the camera's axes lie on the canvas.
struct Frame {
  CameraAxes axes;
  double scale = 1;          // samples per m
  double left = 0, top = 0;  // of the canvas, m along right and up

  [[nodiscard]] Vec3 operator()(const Vec3& p) const {
    return {(dot(p, axes.right) - left) * scale, (top - dot(p, axes.up)) * scale, dot(p, axes.toward)};
  }
};

Frame frame_of(const std::vector<Painted>& painted, const Camera& camera, int width, int height) {
  Frame frame{axes_of(camera)};
  double left = std::numeric_limits<double>::infinity(), right = -left, low = left, high = -left;
  for (const Painted& body : painted) {
    for (const Vec3& p : body.mesh.vertices) {
      left = std::min(left, dot(p, frame.axes.right));
      right = std::max(right, dot(p, frame.axes.right));
      low = std::min(low, dot(p, frame.axes.up));
      high = std::max(high, dot(p, frame.axes.up));
    }
  }
  const double across = width * fineness, down = height * fineness;
  frame.scale = (1 - 2 * margin) * std::min(across / std::max(right - left, 1e-9), down / std::max(high - low, 1e-9));
  frame.left = 0.5 * (left + right) - 0.5 * across / frame.scale;
  frame.top = 0.5 * (low + high) + 0.5 * down / frame.scale;
  return frame;
}

void paint(Canvas& canvas, const Frame& frame, const Painted& body) {
  const Vec3 light = frame.axes.toward + 0.5 * frame.axes.up - 0.4 * frame.axes.right;
  for (const auto& face : body.mesh.faces) {
    const Vec3 doubled = doubled_area_normal(body.mesh, face);
    const double area = norm(doubled);
    if (!(area > 0) || dot(doubled, frame.axes.toward) <= 0) continue;
    const double bright = ambient + (1 - ambient) * std::max(0.0, dot(doubled, light) / (area * norm(light)));
    std::array<Vec3, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = frame(body.mesh.vertices[static_cast<std::size_t>(face[k])]);
    canvas.fill(corners, {bright * body.color.r, bright * body.color.g, bright * body.color.b});
  }
}

/// Planes, several times as large as the bodies above them: each a square below their middle.
void add_planes(const DrawnScene& drawn, std::vector<Painted>& painted) {
  Vec3 low, high;
  bool first = true;
  for (const Painted& body : painted) {
    for (const Vec3& p : body.mesh.vertices) {
      low = first ? p : Vec3{std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = first ? p : Vec3{std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
      first = false;
    }
  }
  const Vec3 middle = 0.5 * (low + high);
  for (std::size_t i = 0; i < drawn.scene.bodies.size(); ++i) {
    if (!is_plane(drawn, i)) continue;
    const Body& body = drawn.scene.bodies[i];
    Vec3 below = transform(inverse(body.X_WB), middle);
    below.z = 0;
    TriangleMesh square = square_mesh(6 * norm(high - low));
    for (Vec3& vertex : square.vertices) vertex = transform(body.X_WB, below + vertex);
    painted.push_back({std::move(square), plane_body});
  }
}

/// An arrow along `force_W` from the tool's place, a quarter as long as the bodies are large together.
Painted arrow_of(const Vec3& p_WT, const Vec3& force_W, const std::vector<Painted>& painted) {
  Vec3 low = p_WT, high = p_WT;
  for (const Painted& body : painted) {
    for (const Vec3& p : body.mesh.vertices) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
  }
  const double length = 0.25 * norm(high - low);
  TriangleMesh mesh = turned_mesh({{0, 0}, {0.025, 0}, {0.025, 0.75}, {0.07, 0.75}, {0, 1}});
  const Vec3 z = (1 / norm(force_W)) * force_W;
  const Vec3 other = std::abs(z.x) < 0.8 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 x = (1 / norm(cross(other, z))) * cross(other, z);
  const Vec3 y = cross(z, x);
  for (Vec3& p : mesh.vertices) p = p_WT + length * (p.x * x + p.y * y + p.z * z);
  return {std::move(mesh), force_arrow};
}

void add_big_endian(std::string& bytes, std::uint32_t value) {
  for (const unsigned shift : {24U, 16U, 8U, 0U})
    bytes += static_cast<char>(static_cast<unsigned char>(value >> shift & 255U));
}

void add_png_chunk(std::string& png, const std::string& kind, const std::string& data) {
  add_big_endian(png, static_cast<std::uint32_t>(data.size()));
  const std::string checked = kind + data;
  png += checked;
  add_big_endian(
      png, static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(checked.data()), checked.size())));
}

std::string png_of(int width, int height, const std::string& rows) {
  uLongf size = compressBound(static_cast<uLong>(rows.size()));
  std::string packed(size, '\0');
  TACTOR_DEMAND(compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()),
                          static_cast<uLong>(rows.size()), Z_BEST_COMPRESSION) == Z_OK);
  packed.resize(size);
  std::string png = "\x89PNG\r\n\x1a\n", header;
  add_big_endian(header, static_cast<std::uint32_t>(width));
  add_big_endian(header, static_cast<std::uint32_t>(height));
  header += {8, 6, 0, 0, 0};  // 8 bits each of red, green, blue and opacity
  add_png_chunk(png, "IHDR", header);
  add_png_chunk(png, "IDAT", packed);
  add_png_chunk(png, "IEND", "");
  return png;
}

}  // namespace

std::string scene_png(const DrawnScene& drawn, int width, int height, const std::optional<Vec3>& force_W) {
  std::vector<Painted> painted = painted_bodies(drawn);
  if (painted.empty()) return {};
  std::optional<Painted> arrow;
  const std::optional<Pose> tool = drawn.tool_pose();
  if (force_W && tool && norm(*force_W) > 0) {
    arrow = arrow_of(tool->p, *force_W, painted);
    painted.push_back(*arrow);  // inside of the frame
  }
  const Frame frame = frame_of(painted, drawn.scene.camera, width, height);
  add_planes(drawn, painted);
  Canvas canvas(width, height);
  for (const Painted& body : painted) paint(canvas, frame, body);
  if (arrow) {
    for (Vec3& p : arrow->mesh.vertices) p = p + 1e3 * frame.axes.toward;  // nearer than any body
    paint(canvas, frame, *arrow);
  }
  return png_of(width, height, canvas.rows());
}

std::string scene_figure(const DrawnScene& drawn, const std::string& caption, const std::optional<Vec3>& force_W) {
  constexpr int width = 480, height = 300;
  try {
    const std::string png = scene_png(drawn, width, height, force_W);
    if (png.empty()) return {};
    return "<figure class=\"scene\"><img alt=\"The bodies of the scene\" src=\"data:image/png;base64," + base64(png) +
           "\"><figcaption>" + caption + "</figcaption></figure>\n";
  } catch (const InputError& error) {
    return no_scene_figure(error);
  }
}

std::string no_scene_figure(const InputError& why) {
  return "<p class=\"sub\">No picture of the scene: " + escape(why.what()) + "</p>\n";
}

}  // namespace tactor
