#include <bit>
#include <cstdint>

#include "nodes/physics/mesh/mesh_formats.hpp"
#include "nodes/physics/mesh/mesh_words.hpp"

namespace tactor {

namespace {

constexpr std::size_t header_size = 84, face_size = 50;
constexpr std::size_t face_cost = 3 * sizeof(Vec3) + polygon_bytes(3);

std::uint32_t little_endian(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8U | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

bool same_word(std::string_view word, std::string_view lower_case) {
  if (word.size() != lower_case.size()) return false;
  for (std::size_t i = 0; i < word.size(); ++i) {
    if (word[i] != lower_case[i] && word[i] + 32 != lower_case[i]) return false;
  }
  return true;
}

void add_face(PolygonSoup& soup) {
  const std::size_t n = soup.points.size();
  soup.polygons.push_back({n - 3, n - 2, n - 1});
}

PolygonSoup read_text(ReadBudget& budget, const std::string& file, std::string_view bytes) {
  MeshWords words(budget, file, "an STL file", bytes);
  const auto expect = [&](const char* keyword) {
    if (const std::string_view word = words.next(); !same_word(word, keyword)) words.fail(keyword, word);
  };
  PolygonSoup soup;
  expect("solid");
  // The name of the solid.
  words.skip_line();
  for (;;) {
    const std::string_view word = words.next();
    if (same_word(word, "facet")) {
      // The normal, which the corners tell better.
      words.skip_line();
      words.take(face_cost);
      expect("outer");
      expect("loop");
      for (int corner = 0; corner < 3; ++corner) {
        expect("vertex");
        soup.points.push_back(words.point());
      }
      expect("endloop");
      expect("endfacet");
      add_face(soup);
    } else if (same_word(word, "endsolid")) {
      words.skip_line();
      const std::string_view after = words.next();
      if (after.empty()) return soup;
      if (!same_word(after, "solid")) words.fail("solid or the end of the file", after);
      words.skip_line();
    } else {
      words.fail("facet or endsolid", word);
    }
  }
}

PolygonSoup read_binary(ReadBudget& budget, const std::string& file, std::string_view bytes) {
  if (bytes.size() < header_size) {
    throw InputError(file + ": the file has " + std::to_string(bytes.size()) + " bytes, too few for an STL file (" +
                     std::to_string(header_size) + " or more); export the mesh again");
  }
  const std::size_t faces = little_endian(bytes, header_size - 4);
  if (header_size + face_size * faces != bytes.size()) {
    throw InputError(file + ": the header of this binary STL file says " + std::to_string(faces) +
                     " faces, which take " + std::to_string(header_size + face_size * faces) +
                     " bytes, but the file has " + std::to_string(bytes.size()) +
                     "; it was cut off or is not an STL file, export the mesh again");
  }
  PolygonSoup soup;
  soup.points.reserve(3 * faces);
  soup.polygons.reserve(faces);
  for (std::size_t face = 0; face < faces; ++face) {
    budget.take(face_cost);
    // The normal comes first, which the corners tell better.
    std::size_t at = header_size + face_size * face + 12;
    for (int corner = 0; corner < 3; ++corner) {
      Vec3 p;
      for (int axis = 0; axis < 3; ++axis, at += 4) p[axis] = std::bit_cast<float>(little_endian(bytes, at));
      if (!is_usable(p)) {
        throw InputError(file + ": corner " + std::to_string(corner) + " of face " + std::to_string(face) +
                         " is not finite or beyond 1e15; export the mesh again");
      }
      soup.points.push_back(p);
    }
    add_face(soup);
  }
  return soup;
}

}  // namespace

PolygonSoup read_stl(const std::string& file, std::string_view bytes) {
  ReadBudget budget(file, bytes.size());
  // Binary files too may begin with `solid`; a text holds no zero.
  const bool is_text = bytes.find('\0') == std::string_view::npos &&
                       same_word(MeshWords(budget, file, "", bytes.substr(0, 1000)).next(), "solid");
  return is_text ? read_text(budget, file, bytes) : read_binary(budget, file, bytes);
}

}  // namespace tactor
