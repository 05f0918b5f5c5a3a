#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "framework/core/check.hpp"
#include "nodes/physics/mesh/mesh_words.hpp"
#include "nodes/physics/mesh/volume_formats.hpp"

namespace tactor {

namespace {

constexpr const char* msh_name = "a Gmsh file, version 4.1";

/// What a type of element is. Gmsh's manual, chapter "MSH file format".
struct ElementType {
  int number;
  std::size_t nodes;
  int dimension;
  const char* name;
};
constexpr ElementType element_types[] = {
    {1, 2, 1, "line"},
    {2, 3, 2, "triangle"},
    {3, 4, 2, "quadrangle"},
    {4, 4, 3, "tetrahedron"},
    {5, 8, 3, "hexahedron"},
    {6, 6, 3, "prism"},
    {7, 5, 3, "pyramid"},
    {8, 3, 1, "line of second order"},
    {9, 6, 2, "triangle of second order"},
    {10, 9, 2, "quadrangle of second order"},
    {11, 10, 3, "tetrahedron of second order"},
    {15, 1, 0, "point"},
    {16, 8, 2, "quadrangle of second order"},
};

/// `$NAME`, its content, `$EndNAME`.
struct MshSection {
  std::string_view name, content;
  std::size_t line = 0;  // of the content, for text
};

std::size_t lines_in(std::string_view text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

std::vector<MshSection> sections_of(ReadBudget& budget, const std::string& file, std::string_view bytes) {
  std::vector<MshSection> sections;
  std::size_t line = 1;
  for (std::size_t at = 0; at < bytes.size();) {
    budget.take(sizeof(MshSection));
    const std::size_t end = std::min(bytes.find('\n', at), bytes.size());
    std::string_view heading = bytes.substr(at, end - at);
    while (!heading.empty() && (heading.back() == '\r' || heading.back() == ' ')) heading.remove_suffix(1);
    const std::size_t content = std::min(end + 1, bytes.size());
    if (heading.empty()) {
      at = content, ++line;
      continue;
    }
    const auto fail = [&](const std::string& expected, std::string_view found) {
      throw InputError(file + ":" + std::to_string(line) + ": expected " + expected + ", found " +
                       (found.empty() ? "the end of the file" : shown_word(found)) + "; save the mesh again as " +
                       msh_name);
    };
    if (heading[0] != '$') fail("a section, $...", heading);
    const std::string ending = "$End" + std::string(heading.substr(1));
    // Text and binary data end with a line.
    std::size_t stop = content;
    if (bytes.substr(content, ending.size()) != ending) stop = bytes.find("\n" + ending, content);
    if (stop == std::string_view::npos) fail(ending.substr(0, 60), {});
    if (stop > content || bytes[content] == '\n') ++stop;
    sections.push_back({heading.substr(1), bytes.substr(content, stop - content), line + 1});
    const std::size_t next = std::min(bytes.find('\n', stop), bytes.size());
    line += lines_in(bytes.substr(at, std::min(next + 1, bytes.size()) - at));
    at = next + 1;
  }
  return sections;
}

/// Reads the values of a section one by one.
class MshValues {
 public:
  MshValues(ReadBudget& budget, const std::string& file, const MshSection& section, bool binary)
      : budget_(budget),
        file_(file),
        section_(section),
        binary_(binary),
        bytes_(section.content),
        words_(budget, file, msh_name, section.content, section.line) {}

  int integer(const char* what) {
    if (!binary_) return words_.number<int>(what);
    return taken<std::int32_t>(what);
  }
  std::uint64_t count(const char* what) {
    if (!binary_) return words_.number<std::uint64_t>(what);
    return taken<std::uint64_t>(what);
  }
  double real(const char* what) {
    if (!binary_) return words_.number<double>(what);
    return taken<double>(what);
  }
  Vec3 point() {
    Vec3 p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = real("a coordinate");
    if (!is_usable(p)) fail("a coordinate is not finite or beyond 1e15");
    return p;
  }
  /// Charges bytes for what is being read to the budget.
  void take(std::uint64_t bytes) {
    if (!budget_.holds(bytes)) fail(budget_.refusal());
  }

  void expect_end() {
    if (binary_) {
      while (!bytes_.empty() && (bytes_[0] == '\n' || bytes_[0] == '\r')) bytes_.remove_prefix(1);
      if (!bytes_.empty()) fail("it has " + std::to_string(bytes_.size()) + " bytes more than its counts say");
    } else if (const std::string_view rest = words_.next(); !rest.empty()) {
      words_.fail("$End" + std::string(section_.name), rest);
    }
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(file_ + ": section $" + std::string(section_.name) + ": " + what + "; save the mesh again as " +
                     msh_name);
  }

 private:
  template <class T>
  T taken(const char* what) {
    T value{};
    take(ReadBudget::step_cost);
    if (bytes_.size() < sizeof value) fail(std::string("it ends before ") + what);
    std::memcpy(&value, bytes_.data(), sizeof value);
    bytes_.remove_prefix(sizeof value);
    return value;
  }

  ReadBudget& budget_;
  const std::string& file_;
  const MshSection& section_;
  bool binary_;
  std::string_view bytes_;
  MeshWords words_;
};

bool is_binary(ReadBudget& budget, const std::string& file, const MshSection& section) {
  const std::size_t end = std::min(section.content.find('\n'), section.content.size());
  MeshWords words(budget, file, msh_name, section.content.substr(0, end), section.line);
  const std::string_view version = words.next();
  if (version != "4.1") {
    throw InputError(
        file + ": expected version 4.1 of Gmsh's format, found " + shown_word(version) +
        "; open the file in Gmsh and save it with File > Export, format MSH 4, or run `gmsh -0 -format msh41 " + file +
        " -o NEW.msh`");
  }
  const int type = words.number<int>("0 (text) or 1 (binary)");
  if (type != 0 && type != 1) words.fail("0 (text) or 1 (binary)", std::to_string(type));
  if (const int size = words.number<int>("8, the bytes of a number"); size != 8) {
    words.fail("8, the bytes of a number", std::to_string(size));
  }
  if (type == 0) return false;
  const std::string_view one = section.content.substr(std::min(end + 1, section.content.size()));
  if (one.substr(0, 4) == std::string_view("\0\0\0\1", 4)) {
    throw InputError(file + ": the file comes from a big-endian machine; open it in Gmsh and save it again, as text");
  }
  if (one.substr(0, 4) != std::string_view("\1\0\0\0", 4)) {
    throw InputError(file + ": section $MeshFormat: expected the number 1 in four bytes; save the mesh again as " +
                     msh_name);
  }
  return true;
}

/// Bytes that an entry of a map takes beside its content.
constexpr std::uint64_t map_entry_bytes = 96;

/// The names of physical groups of surfaces by their numbers. A name stands in quotes.
std::map<int, std::string> names_of(ReadBudget& budget, const std::string& file, const MshSection& section) {
  std::map<int, std::string> names;
  std::string_view rest = section.content;
  std::size_t line = section.line;
  bool is_first = true;
  for (; !rest.empty(); ++line) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view text = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    const std::size_t open = text.find('"');
    MeshWords words(budget, file, msh_name, text.substr(0, open), line);
    words.take(map_entry_bytes + text.size());
    if (is_first) {
      words.number<std::uint64_t>("the number of names");
      is_first = false;
      continue;
    }
    if (text.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    const int dimension = words.number<int>("the dimension of a group");
    const int number = words.number<int>("the number of a group");
    const std::size_t close = text.rfind('"');
    if (open == std::string_view::npos || close == open) words.fail("a name in quotes", text);
    if (dimension == 2) names[number] = text.substr(open + 1, close - open - 1);
  }
  return names;
}

/// The physical groups of each surface.
std::map<int, std::vector<int>> groups_of_surfaces(MshValues& values) {
  std::map<int, std::vector<int>> groups;
  std::array<std::uint64_t, 4> counts{};
  for (std::uint64_t& n : counts) n = values.count("the number of entities");
  for (std::size_t dimension = 0; dimension < 4; ++dimension) {
    for (std::uint64_t i = 0; i < counts[dimension]; ++i) {
      const int tag = values.integer("the number of an entity");
      // A point has its place, others the corners of their box.
      for (int k = 0; k < (dimension == 0 ? 3 : 6); ++k) values.real("a coordinate");
      std::vector<int> physical;
      for (std::uint64_t n = values.count("the number of groups"); n > 0; --n) {
        // Below zero where the group looks at its faces from the other side.
        const int group = values.integer("the number of a group");
        values.take(sizeof group);
        physical.push_back(group < 0 && group > std::numeric_limits<int>::min() ? -group : group);
      }
      if (dimension > 0) {
        for (std::uint64_t n = values.count("the number of boundaries"); n > 0; --n) values.integer("a boundary");
      }
      if (dimension != 2) continue;
      values.take(map_entry_bytes);
      std::sort(physical.begin(), physical.end());
      // A group that is named twice has its faces once.
      physical.erase(std::unique(physical.begin(), physical.end()), physical.end());
      groups[tag] = std::move(physical);
    }
  }
  values.expect_end();
  return groups;
}

/// The numbers that nodes have in the file. A file cannot make a search among them slow, as it could with a hash.
class NodeNumbers {
 public:
  void add(std::uint64_t number) { sorted_.push_back({number, static_cast<int>(sorted_.size())}); }
  /// To be called once, after the last `add`. A number that two nodes have; nothing where all differ.
  std::optional<std::uint64_t> sort() {
    std::sort(sorted_.begin(), sorted_.end());
    const auto twice = std::adjacent_find(sorted_.begin(), sorted_.end(),
                                          [](const auto& a, const auto& b) { return a.first == b.first; });
    return twice == sorted_.end() ? std::nullopt : std::optional(twice->first);
  }
  /// The index of a node, or nothing where none has that number.
  [[nodiscard]] std::optional<int> find(std::uint64_t number) const {
    const auto found = std::lower_bound(sorted_.begin(), sorted_.end(), std::pair(number, 0));
    return found == sorted_.end() || found->first != number ? std::nullopt : std::optional(found->second);
  }
  static constexpr std::size_t entry_bytes = sizeof(std::pair<std::uint64_t, int>);

 private:
  std::vector<std::pair<std::uint64_t, int>> sorted_;
};

NodeNumbers read_nodes(MshValues& values, VolumeSoup& soup) {
  NodeNumbers numbers;
  const std::uint64_t blocks = values.count("the number of blocks"), nodes = values.count("the number of nodes");
  values.count("the smallest number of a node");
  values.count("the largest number of a node");
  std::vector<std::uint64_t> tags;
  for (std::uint64_t block = 0; block < blocks; ++block) {
    const int dimension = values.integer("the dimension of a block");
    values.integer("the number of an entity");
    const int parametric = values.integer("0 or 1");
    if (dimension < 0 || dimension > 3)
      values.fail("expected a dimension from 0 to 3, found " + std::to_string(dimension));
    if (parametric != 0 && parametric != 1)
      values.fail("expected 0 or 1 (parametric), found " + std::to_string(parametric));
    const std::uint64_t in_block = values.count("the number of nodes of a block");
    tags.clear();
    for (std::uint64_t i = 0; i < in_block; ++i) {
      values.take(sizeof(std::uint64_t) + NodeNumbers::entry_bytes + sizeof(Vec3));
      tags.push_back(values.count("the number of a node"));
    }
    for (const std::uint64_t tag : tags) {
      numbers.add(tag);
      soup.nodes.push_back(values.point());
      for (int k = 0; parametric == 1 && k < dimension; ++k) values.real("a parameter");
    }
  }
  values.expect_end();
  if (const auto twice = numbers.sort()) values.fail("two nodes have the number " + std::to_string(*twice));
  if (soup.nodes.size() != nodes) {
    values.fail("it says " + std::to_string(nodes) + " nodes and lists " + std::to_string(soup.nodes.size()));
  }
  return numbers;
}

const ElementType& element_type(const MshValues& values, int number) {
  for (const ElementType& type : element_types) {
    if (type.number != number) continue;
    if (type.dimension < 3 || number == 4) return type;
    values.fail(std::string("it has a ") + type.name + "; a deformable body is made of tetrahedra of 4 nodes" +
                (number == 11 ? ": set Mesh.ElementOrder = 1" : ": mesh without recombination or transfinite volumes"));
  }
  values.fail("the type of elements " + std::to_string(number) + " is not known; elements of first order are read");
}

/// Where triangles of each physical group go.
class MshGroups {
 public:
  MshGroups(std::map<int, std::string> names, std::map<int, std::vector<int>> of_surface)
      : names_(std::move(names)), of_surface_(std::move(of_surface)) {}
  void add(int surface, const std::array<int, 3>& face, MshValues& values) {
    const auto groups = of_surface_.find(surface);
    if (groups == of_surface_.end()) return;
    // Few triangles in many groups are many faces. Each is copied once more at the end.
    for (const int group : groups->second) {
      std::vector<std::array<int, 3>>& faces = faces_[group];
      values.take(2 * sizeof face + (faces.empty() ? map_entry_bytes + sizeof(FaceGroup) : 0));
      faces.push_back(face);
    }
  }
  [[nodiscard]] std::vector<FaceGroup> groups() const {
    std::vector<FaceGroup> all;
    for (const auto& [number, faces] : faces_) {
      const auto name = names_.find(number);
      all.push_back({name == names_.end() ? std::to_string(number) : name->second, faces});
    }
    return all;
  }

 private:
  std::map<int, std::string> names_;
  std::map<int, std::vector<int>> of_surface_;
  std::map<int, std::vector<std::array<int, 3>>> faces_;
};

void read_elements(MshValues& values, const NodeNumbers& numbers, MshGroups& groups, VolumeSoup& soup) {
  const std::uint64_t blocks = values.count("the number of blocks"), elements = values.count("the number of elements");
  values.count("the smallest number of an element");
  values.count("the largest number of an element");
  std::uint64_t listed = 0, quadrangles = 0;
  for (std::uint64_t block = 0; block < blocks; ++block) {
    values.integer("the dimension of a block");
    const int entity = values.integer("the number of an entity");
    const ElementType& type = element_type(values, values.integer("the type of elements"));
    const std::uint64_t in_block = values.count("the number of elements of a block");
    for (std::uint64_t i = 0; i < in_block; ++i) {
      const std::uint64_t tag = values.count("the number of an element");
      std::array<int, 10> corner{};
      for (std::size_t k = 0; k < type.nodes; ++k) {
        const std::optional<int> node = numbers.find(values.count("a node of an element"));
        if (!node) values.fail("element " + std::to_string(tag) + " names a node that is not there");
        corner[k] = *node;
      }
      std::array<int, 10> ordered = corner;
      std::sort(ordered.begin(), ordered.begin() + static_cast<std::ptrdiff_t>(type.nodes));
      if (std::adjacent_find(ordered.begin(), ordered.begin() + static_cast<std::ptrdiff_t>(type.nodes)) !=
          ordered.begin() + static_cast<std::ptrdiff_t>(type.nodes)) {
        values.fail("element " + std::to_string(tag) + " names a node twice");
      }
      if (type.number == 4) {
        values.take(sizeof soup.tets[0]);
        soup.tets.push_back({corner[0], corner[1], corner[2], corner[3]});
      }
      if (type.number == 2) groups.add(entity, {corner[0], corner[1], corner[2]}, values);
      if (type.dimension == 2 && type.number != 2) ++quadrangles;
      ++listed;
    }
  }
  values.expect_end();
  if (listed != elements) {
    values.fail("it says " + std::to_string(elements) + " elements and lists " + std::to_string(listed));
  }
  if (quadrangles > 0) {
    soup.notes.push_back(std::to_string(quadrangles) + " faces that are no triangles of 3 nodes were left out");
  }
}

}  // namespace

VolumeSoup read_msh(const std::string& file, std::string_view bytes) {
  ReadBudget budget(file, bytes.size());
  const std::vector<MshSection> sections = sections_of(budget, file, bytes);
  const auto find = [&](std::string_view name) -> const MshSection* {
    const MshSection* found = nullptr;
    for (const MshSection& section : sections) {
      if (section.name != name) continue;
      if (found != nullptr) {
        throw InputError(file + ": the file has two sections $" + std::string(name) + "; save the mesh again as " +
                         msh_name);
      }
      found = &section;
    }
    return found;
  };
  const auto need = [&](std::string_view name) -> const MshSection& {
    if (const MshSection* section = find(name)) return *section;
    throw InputError(file + ": the file has no section $" + std::string(name) + "; save the mesh again as " + msh_name);
  };
  const bool binary = is_binary(budget, file, need("MeshFormat"));
  if (find("PartitionedEntities") != nullptr) {
    throw InputError(file + ": the mesh is partitioned; save it in Gmsh without partitions");
  }
  VolumeSoup soup;
  std::map<int, std::string> names;
  if (const MshSection* section = find("PhysicalNames")) names = names_of(budget, file, *section);
  std::map<int, std::vector<int>> of_surface;
  if (const MshSection* section = find("Entities")) {
    MshValues values(budget, file, *section, binary);
    of_surface = groups_of_surfaces(values);
  }
  MshGroups groups(std::move(names), std::move(of_surface));
  MshValues nodes(budget, file, need("Nodes"), binary), elements(budget, file, need("Elements"), binary);
  const NodeNumbers numbers = read_nodes(nodes, soup);
  read_elements(elements, numbers, groups, soup);
  soup.groups = groups.groups();
  return soup;
}

}  // namespace tactor
