#include <algorithm>
#include <array>

#include "nodes/physics/mesh/mesh_formats.hpp"
#include "nodes/physics/mesh/mesh_words.hpp"

namespace tactor {

namespace {

// Statements that say nothing of the surface. Those of curved surfaces are not among them: leaving them out would leave
// a part of the body out.
constexpr std::array<std::string_view, 22> left_out{
    "vt",       "vn",       "g",   "o",          "s",         "mg",    "usemtl", "mtllib", "usemap", "maplib", "bevel",
    "c_interp", "d_interp", "lod", "shadow_obj", "trace_obj", "ctech", "stech",  "p",      "l",      "vp",     "end"};

}  // namespace

PolygonSoup read_obj(const std::string& file, std::string_view bytes) {
  ReadBudget budget(file, bytes.size());
  MeshWords words(budget, file, "an OBJ file of polygons", bytes);
  PolygonSoup soup;
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (word == "v") {
      words.take(sizeof(Vec3));
      soup.points.push_back(words.point_in_line());
      // A weight or a colour may follow.
      words.skip_line();
    } else if (word == "f") {
      std::vector<std::size_t> polygon;
      for (std::string_view corner = words.next_in_line(); !corner.empty(); corner = words.next_in_line()) {
        const auto index = words.number<long long>(corner.substr(0, corner.find('/')), "the index of a vertex");
        const auto known = static_cast<long long>(soup.points.size());
        // A negative index counts back from the last vertex.
        const long long absolute = index < 0 ? known + index : index - 1;
        if (index == 0 || absolute < 0 || absolute >= known) {
          words.fail("an index from 1 to " + std::to_string(known) + ", the vertices up to here", corner);
        }
        polygon.push_back(static_cast<std::size_t>(absolute));
      }
      if (polygon.size() < 3) words.fail("a face of 3 corners or more", std::to_string(polygon.size()));
      words.take(polygon_bytes(polygon.size()));
      soup.polygons.push_back(std::move(polygon));
    } else if (std::find(left_out.begin(), left_out.end(), word) != left_out.end()) {
      words.skip_line();
    } else {
      words.fail("a statement of polygons (v, f, ...)", word);
    }
  }
  return soup;
}

}  // namespace tactor
