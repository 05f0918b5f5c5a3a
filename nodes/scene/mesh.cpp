#include "nodes/scene/mesh.hpp"

#include <charconv>
#include <fstream>
#include <string>
#include <string_view>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

/// The words of a file without its comments, with the line each stands on.
class Words {
 public:
  explicit Words(const std::filesystem::path& path) : path_(path.string()), in_(path) {
    if (!in_) throw InputError(path_ + ": cannot be opened for reading; give the path of an ASCII OFF file");
  }

  /// The next word, or an empty one at the end of the file.
  std::string_view next() {
    for (;;) {
      const std::size_t begin = line_.find_first_not_of(" \t\r\f\v", position_);
      if (begin != std::string::npos && line_[begin] != '#') {
        const std::size_t end = line_.find_first_of(" \t\r\f\v#", begin);
        position_ = end == std::string::npos ? line_.size() : end;
        return std::string_view(line_).substr(begin, position_ - begin);
      }
      if (!std::getline(in_, line_)) {
        line_.clear();
        position_ = 0;
        return {};
      }
      ++number_;
      position_ = 0;
    }
  }

  /// Leaves the rest of the line out; faces may carry colours there.
  void skip_line() { position_ = line_.size(); }

  template <class T>
  T number(const char* expected) {
    const std::string_view word = next();
    T value{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.empty() || error != std::errc() || end != word.data() + word.size()) fail(expected, word);
    return value;
  }

  [[noreturn]] void fail(const std::string& expected, std::string_view found) const {
    throw InputError(path_ + ":" + std::to_string(number_) + ": expected " + expected + ", found " +
                     (found.empty() ? std::string("the end of the file") : "'" + std::string(found) + "'") +
                     "; export the mesh again as ASCII OFF");
  }

 private:
  std::string path_;
  std::ifstream in_;
  std::string line_;
  std::size_t position_ = 0;
  std::size_t number_ = 0;
};

}  // namespace

TriangleMesh read_off(const std::filesystem::path& path) {
  Words words(path);
  if (const std::string_view header = words.next(); header != "OFF") words.fail("the header OFF", header);
  constexpr long most = 100'000'000;
  const long vertices = words.number<long>("the number of vertices");
  if (vertices < 4 || vertices > most) words.fail("4 vertices or more", std::to_string(vertices));
  const long faces = words.number<long>("the number of faces");
  if (faces < 4 || faces > most) words.fail("4 faces or more", std::to_string(faces));
  words.number<long>("the number of edges");

  TriangleMesh mesh;
  for (long i = 0; i < vertices; ++i) {
    Vec3 v;
    for (int axis = 0; axis < 3; ++axis) v[axis] = words.number<double>("a coordinate of a vertex");
    if (!is_finite(v)) words.fail("finite coordinates", "nan or inf");
    mesh.vertices.push_back(v);
  }
  std::vector<int> corners;
  for (long i = 0; i < faces; ++i) {
    const int count = words.number<int>("the number of corners of a face");
    if (count < 3 || count > 1000) words.fail("a face of 3 corners or more", std::to_string(count));
    corners.clear();
    for (int c = 0; c < count; ++c) {
      const long index = words.number<long>("the index of a vertex");
      if (index < 0 || index >= vertices) {
        words.fail("an index from 0 to " + std::to_string(vertices - 1), std::to_string(index));
      }
      for (const int other : corners) {
        if (other == index) words.fail("a face with distinct corners", std::to_string(index) + " twice");
      }
      corners.push_back(static_cast<int>(index));
    }
    words.skip_line();
    for (std::size_t c = 2; c < corners.size(); ++c) mesh.faces.push_back({corners[0], corners[c - 1], corners[c]});
  }
  if (const std::string_view rest = words.next(); !rest.empty()) {
    words.fail("the end of the file after " + std::to_string(faces) + " faces", rest);
  }
  return mesh;
}

Vec3 doubled_area_normal(const TriangleMesh& mesh, const std::array<int, 3>& face) {
  const auto corner = [&](int i) { return mesh.vertices[static_cast<std::size_t>(face[static_cast<std::size_t>(i)])]; };
  return cross(corner(1) - corner(0), corner(2) - corner(0));
}

double surface_area(const TriangleMesh& mesh) {
  double area = 0;
  for (const auto& face : mesh.faces) area += 0.5 * norm(doubled_area_normal(mesh, face));
  return area;
}

}  // namespace tactor
