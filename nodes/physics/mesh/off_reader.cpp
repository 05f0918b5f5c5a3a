#include <algorithm>

#include "nodes/physics/mesh/mesh_formats.hpp"
#include "nodes/physics/mesh/mesh_words.hpp"

namespace tactor {

PolygonSoup read_off(const std::string& file, std::string_view bytes) {
  ReadBudget budget(file, bytes.size());
  MeshWords words(budget, file, "an ASCII OFF file", bytes);
  const std::string_view header = words.next();
  if (header != "OFF" && header != "COFF" && header != "NOFF") words.fail("the header OFF", header);
  const auto count = [&](const char* expected) {
    const std::string_view word = words.next();
    const auto n = words.number<long long>(word, expected);
    if (n < 4) words.fail(expected, word);
    return static_cast<std::size_t>(n);
  };
  const std::size_t points = count("4 vertices or more");
  const std::size_t polygons = count("4 faces or more");
  words.number<long long>("the number of edges");

  PolygonSoup soup;
  // A vertex takes six bytes or more, a face eight, so that a count that lies takes no memory.
  soup.points.reserve(std::min(points, bytes.size() / 6));
  soup.polygons.reserve(std::min(polygons, bytes.size() / 8));
  for (std::size_t i = 0; i < points; ++i) {
    words.take(sizeof(Vec3));
    soup.points.push_back(words.point());
    if (header != "OFF") words.skip_line();
  }
  for (std::size_t i = 0; i < polygons; ++i) {
    const std::string_view word = words.next();
    const auto corners = words.number<long long>(word, "the number of corners of a face");
    if (corners < 3) words.fail("a face of 3 corners or more", word);
    std::vector<std::size_t> polygon;
    polygon.reserve(std::min(static_cast<std::size_t>(corners), bytes.size() / 2));
    for (long long c = 0; c < corners; ++c) {
      const std::string_view text = words.next();
      const auto index = words.number<long long>(text, "the index of a vertex");
      if (index < 0 || static_cast<std::size_t>(index) >= points) {
        words.fail("an index from 0 to " + std::to_string(points - 1), text);
      }
      polygon.push_back(static_cast<std::size_t>(index));
    }
    words.take(polygon_bytes(polygon.size()));
    soup.polygons.push_back(std::move(polygon));
    // Colours may stand there.
    words.skip_line();
  }
  if (const std::string_view rest = words.next(); !rest.empty()) {
    words.fail("the end of the file after " + std::to_string(polygons) + " faces", rest);
  }
  return soup;
}

}  // namespace tactor
