#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>

#include "nodes/physics/mesh/mesh_formats.hpp"
#include "nodes/physics/mesh/mesh_words.hpp"

namespace tactor {

namespace {

struct Type {
  const char* name;
  const char* other_name;
  unsigned size;  // bytes
  enum { whole, natural, real } kind;
};
constexpr Type ply_types[] = {
    {"char", "int8", 1, Type::whole},       {"uchar", "uint8", 1, Type::natural}, {"short", "int16", 2, Type::whole},
    {"ushort", "uint16", 2, Type::natural}, {"int", "int32", 4, Type::whole},     {"uint", "uint32", 4, Type::natural},
    {"float", "float32", 4, Type::real},    {"double", "float64", 8, Type::real},
};

struct Property {
  std::string name;
  Type type;
  std::optional<Type> length;  // of a list
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

enum class Coding { ascii, little_endian, big_endian };

struct Header {
  Coding coding = Coding::ascii;
  std::vector<Element> elements;
  std::string_view body;
  std::size_t lines = 0;
};

Type type_of(MeshWords& words) {
  const std::string_view word = words.next_in_line();
  for (const Type& type : ply_types) {
    if (word == type.name || word == type.other_name) return type;
  }
  words.fail("a type (char, uchar, short, ushort, int, uint, float, double)", word);
}

void read_header_line(const std::string_view keyword, MeshWords& words, Header& header) {
  if (keyword == "format") {
    const std::string_view coding = words.next_in_line();
    if (coding == "ascii") {
      header.coding = Coding::ascii;
    } else if (coding == "binary_little_endian") {
      header.coding = Coding::little_endian;
    } else if (coding == "binary_big_endian") {
      header.coding = Coding::big_endian;
    } else {
      words.fail("ascii, binary_little_endian or binary_big_endian", coding);
    }
    if (const std::string_view version = words.next_in_line(); version != "1.0") words.fail("version 1.0", version);
  } else if (keyword == "element") {
    Element element;
    element.name = words.next_in_line();
    element.count = words.number<std::size_t>(words.next_in_line(), "a number of elements");
    header.elements.push_back(std::move(element));
  } else if (keyword == "property") {
    if (header.elements.empty()) words.fail("element before property", keyword);
    Property property;
    MeshWords ahead = words;
    if (ahead.next_in_line() == "list") {
      words.next_in_line();
      property.length = type_of(words);
      if (property.length->kind == Type::real) words.fail("a whole number as length of a list", property.length->name);
    }
    property.type = type_of(words);
    property.name = words.next_in_line();
    if (property.name.empty()) words.fail("the name of the property", "");
    header.elements.back().properties.push_back(std::move(property));
  } else if (keyword != "comment" && keyword != "obj_info") {
    words.fail("format, element, property, comment or end_header", keyword);
  }
}

/// A line of the header may be an element or a property.
constexpr std::size_t header_line_bytes = sizeof(Element) + sizeof(Property);

Header read_header(ReadBudget& budget, const std::string& file, std::string_view bytes) {
  Header header;
  bool formatted = false;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t end = std::min(bytes.find('\n', at), bytes.size());
    MeshWords words(budget, file, "a PLY file", bytes.substr(at, end - at), ++header.lines);
    words.take(header_line_bytes);
    at = end + 1;
    const std::string_view keyword = words.next_in_line();
    if (header.lines == 1) {
      if (keyword != "ply") words.fail("the header ply", keyword);
      continue;
    }
    if (keyword == "end_header") {
      if (!formatted) words.fail("format before end_header", keyword);
      header.body = bytes.substr(std::min(at, bytes.size()));
      return header;
    }
    formatted = formatted || keyword == "format";
    read_header_line(keyword, words, header);
  }
  throw InputError(file + ":" + std::to_string(header.lines) +
                   ": expected end_header, found the end of the file; export the mesh again as a PLY file");
}

/// Reads the values of the body one by one.
class Body {
 public:
  Body(ReadBudget& budget, const std::string& file, const Header& header)
      : budget_(budget),
        file_(file),
        coding_(header.coding),
        bytes_(header.body),
        words_(budget, file, "a PLY file", header.body, header.lines + 1) {}

  /// What is being read, for messages.
  void begin(const Element& element, std::size_t index) { element_ = &element, index_ = index; }

  double value(const Type& type) {
    if (coding_ == Coding::ascii) return words_.number<double>("a number");
    take(ReadBudget::step_cost);
    if (bytes_.size() < type.size) fail("the file ends here");
    std::uint64_t bits = 0;
    for (unsigned i = 0; i < type.size; ++i) {
      const unsigned from = coding_ == Coding::big_endian ? i : type.size - 1 - i;
      bits = bits << 8U | static_cast<unsigned char>(bytes_[from]);
    }
    bytes_.remove_prefix(type.size);
    if (type.kind == Type::real) {
      return type.size == 4 ? std::bit_cast<float>(static_cast<std::uint32_t>(bits)) : std::bit_cast<double>(bits);
    }
    if (type.kind == Type::natural) return static_cast<double>(bits);
    switch (type.size) {
      case 1:
        return static_cast<std::int8_t>(bits);
      case 2:
        return static_cast<std::int16_t>(bits);
      default:
        return static_cast<std::int32_t>(bits);
    }
  }
  /// A value that counts or points: a whole number, zero or more.
  std::size_t index(const Type& type, const char* what) {
    const double v = value(type);
    if (!(v >= 0 && v <= 4294967295.0) || v != std::floor(v)) fail(std::string(what) + " is " + std::to_string(v));
    return static_cast<std::size_t>(v);
  }

  /// Charges bytes for what is being read to the budget.
  void take(std::uint64_t bytes) {
    if (!budget_.holds(bytes)) fail(budget_.refusal());
  }

  void expect_end() {
    if (coding_ == Coding::ascii) {
      if (const std::string_view rest = words_.next(); !rest.empty()) words_.fail("the end of the file", rest);
    } else if (!bytes_.empty()) {
      throw InputError(file_ + ": the file has " + std::to_string(bytes_.size()) +
                       " bytes more than its header says; export the mesh again");
    }
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(file_ + ": " + element_->name + " " + std::to_string(index_) + " of " +
                     std::to_string(element_->count) + ": " + what + "; export the mesh again");
  }

 private:
  ReadBudget& budget_;
  const std::string& file_;
  Coding coding_;
  std::string_view bytes_;
  MeshWords words_;
  const Element* element_ = nullptr;
  std::size_t index_ = 0;
};

void read_vertices(const Element& element, Body& body, PolygonSoup& soup) {
  for (std::size_t i = 0; i < element.count; ++i) {
    body.begin(element, i);
    body.take(sizeof(Vec3));
    Vec3 p;
    for (const Property& property : element.properties) {
      const std::size_t values = property.length ? body.index(*property.length, "the length of a list") : 1;
      for (std::size_t k = 0; k < values; ++k) {
        const double v = body.value(property.type);
        if (property.name == "x") p.x = v;
        if (property.name == "y") p.y = v;
        if (property.name == "z") p.z = v;
      }
    }
    if (!is_usable(p)) body.fail("a coordinate is not finite or beyond 1e15");
    soup.points.push_back(p);
  }
}

bool holds_corners(const Property& property) {
  return property.length && (property.name == "vertex_indices" || property.name == "vertex_index");
}

void read_others(const Element& element, Body& body, PolygonSoup* soup) {
  for (std::size_t i = 0; i < element.count; ++i) {
    body.begin(element, i);
    for (const Property& property : element.properties) {
      const std::size_t values = property.length ? body.index(*property.length, "the length of a list") : 1;
      const bool corners = soup != nullptr && holds_corners(property);
      if (corners && values < 3) body.fail("expected 3 corners or more, found " + std::to_string(values));
      if (corners) {
        body.take(polygon_bytes(0));
        soup->polygons.emplace_back();
      }
      for (std::size_t k = 0; k < values; ++k) {
        if (corners) {
          body.take(sizeof(std::size_t));
          soup->polygons.back().push_back(body.index(property.type, "the index of a vertex"));
        } else {
          body.value(property.type);
        }
      }
    }
  }
}

void check_header(const std::string& file, const Header& header) {
  const auto refuse = [&](const std::string& what) {
    throw InputError(file + ": " + what + "; export the mesh again");
  };
  std::size_t vertices = 0, faces = 0;
  for (const Element& element : header.elements) {
    // Items that take no bytes could be counted for ever.
    if (element.properties.empty()) refuse("the element " + shown_word(element.name) + " has no property");
    const auto count = [&](const auto& test) {
      std::size_t n = 0;
      for (const Property& property : element.properties) n += test(property) ? 1 : 0;
      return n;
    };
    if (element.name == "vertex") {
      ++vertices;
      for (const char* axis : {"x", "y", "z"}) {
        if (count([&](const Property& p) { return p.name == axis && !p.length; }) != 1) {
          refuse(std::string("a vertex must have one property ") + axis);
        }
      }
    }
    if (element.name == "face") {
      ++faces;
      if (count(holds_corners) != 1) refuse("a face must have one list vertex_indices or vertex_index");
    }
  }
  if (vertices != 1 || faces != 1) refuse("expected one element vertex and one element face in the header");
}

}  // namespace

PolygonSoup read_ply(const std::string& file, std::string_view bytes) {
  ReadBudget budget(file, bytes.size());
  const Header header = read_header(budget, file, bytes);
  check_header(file, header);
  PolygonSoup soup;
  Body body(budget, file, header);
  for (const Element& element : header.elements) {
    if (element.name == "vertex") {
      read_vertices(element, body, soup);
    } else {
      read_others(element, body, element.name == "face" ? &soup : nullptr);
    }
  }
  body.expect_end();
  for (std::size_t face = 0; face < soup.polygons.size(); ++face) {
    for (const std::size_t index : soup.polygons[face]) {
      if (index >= soup.points.size()) {
        throw InputError(file + ": face " + std::to_string(face) + ": expected an index below " +
                         std::to_string(soup.points.size()) + ", the number of vertices, found " +
                         std::to_string(index) + "; export the mesh again");
      }
    }
  }
  return soup;
}

}  // namespace tactor
