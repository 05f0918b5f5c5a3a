#include <algorithm>
#include <charconv>
#include <map>
#include <optional>

#include "framework/core/check.hpp"
#include "nodes/physics/mesh/mesh_words.hpp"
#include "nodes/physics/mesh/volume_formats.hpp"
#include "nodes/physics/mesh/vtu_data.hpp"

namespace tactor {

namespace {

/// `<NAME KEY="VALUE" ...>`, `</NAME>` or `<NAME ... />`.
struct Tag {
  std::string_view name;
  std::map<std::string_view, std::string_view> values;
  bool closes = false, is_empty = false;
  std::size_t begin = 0, end = 0;  // in the file, with the brackets

  [[nodiscard]] std::string_view value(std::string_view key, std::string_view otherwise = {}) const {
    const auto found = values.find(key);
    return found == values.end() ? otherwise : found->second;
  }
};

/// Goes through the tags of a file. Comments and processing instructions are left out. What text stands between tags is
/// for whoever asks.
class Tags {
 public:
  Tags(ReadBudget& budget, const std::string& file, std::string_view bytes)
      : budget_(budget), file_(file), bytes_(bytes) {}

  /// The next tag, or nothing at the end of the file.
  std::optional<Tag> next() {
    for (;;) {
      const std::size_t begin = bytes_.find('<', at_);
      if (begin == std::string_view::npos) return std::nullopt;
      const std::string_view from = bytes_.substr(begin);
      const std::string_view closing = from.starts_with("<!--") ? "-->" : from.starts_with("<?") ? "?>" : ">";
      const std::size_t end = closing == ">" ? end_of_tag(begin) : bytes_.find(closing, begin);
      if (end == std::string_view::npos) fail(begin, "a tag that ends with " + std::string(closing));
      at_ = end + closing.size();
      if (closing == ">" && !from.starts_with("<!")) return parsed(begin, at_);
    }
  }
  [[nodiscard]] std::size_t line_at(std::size_t place) {
    line_ += static_cast<std::size_t>(
        std::count(bytes_.begin() + static_cast<std::ptrdiff_t>(counted_),
                   bytes_.begin() + static_cast<std::ptrdiff_t>(std::max(place, counted_)), '\n'));
    counted_ = std::max(place, counted_);
    return line_;
  }
  [[noreturn]] void fail(std::size_t place, const std::string& expected) {
    throw InputError(file_ + ":" + std::to_string(line_at(place)) + ": expected " + expected +
                     "; save the mesh again as VTK unstructured grid (.vtu)");
  }

 private:
  /// Where the tag ends: a bracket in quotes is none.
  [[nodiscard]] std::size_t end_of_tag(std::size_t begin) const {
    char quote = 0;
    for (std::size_t i = begin; i < bytes_.size(); ++i) {
      const char c = bytes_[i];
      if (quote != 0) {
        if (c == quote) quote = 0;
      } else if (c == '"' || c == '\'') {
        quote = c;
      } else if (c == '>') {
        return i;
      }
    }
    return std::string_view::npos;
  }

  Tag parsed(std::size_t begin, std::size_t end) {
    budget_.take(ReadBudget::step_cost);
    constexpr std::string_view blanks = " \t\r\n";
    Tag tag;
    tag.begin = begin, tag.end = end;
    std::string_view text = bytes_.substr(begin + 1, end - begin - 2);
    if (text.starts_with('/')) tag.closes = true, text.remove_prefix(1);
    if (text.ends_with('/')) tag.is_empty = true, text.remove_suffix(1);
    const auto skip_blanks = [&] { text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size())); };
    const std::size_t name_end = std::min(text.find_first_of(blanks), text.size());
    tag.name = text.substr(0, name_end);
    if (tag.name.empty()) fail(begin, "the name of a tag");
    text.remove_prefix(name_end);
    for (skip_blanks(); !text.empty(); skip_blanks()) {
      const std::size_t equals = text.find('=');
      if (equals == std::string_view::npos) fail(begin, "KEY=\"VALUE\" in the tag " + shown_word(tag.name));
      std::string_view key = text.substr(0, equals);
      while (!key.empty() && blanks.find(key.back()) != std::string_view::npos) key.remove_suffix(1);
      text.remove_prefix(equals + 1);
      skip_blanks();
      const std::size_t close = text.empty() ? std::string_view::npos : text.find(text[0], 1);
      if (text.empty() || (text[0] != '"' && text[0] != '\'') || close == std::string_view::npos) {
        fail(begin, "a value in quotes in the tag " + shown_word(tag.name));
      }
      tag.values[key] = text.substr(1, close - 1);
      text.remove_prefix(close + 1);
    }
    return tag;
  }

  ReadBudget& budget_;
  const std::string& file_;
  std::string_view bytes_;
  std::size_t at_ = 0, line_ = 1, counted_ = 0;
};

std::uint64_t number_of(Tags& tags, const Tag& tag, std::string_view key) {
  const std::string_view text = tag.value(key);
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) {
    tags.fail(tag.begin, std::string(key) + "=\"a whole number\" in the tag " + shown_word(tag.name) + ", found " +
                             shown_word(text));
  }
  return number;
}

/// One piece of the grid as the file describes it.
struct Piece {
  std::uint64_t points = 0, cells = 0;
  std::optional<VtuArray> coordinates, connectivity, offsets, types;
};

struct VtuFile {
  VtuCoding coding;
  std::vector<Piece> pieces;
};

void read_head(Tags& tags, const Tag& tag, VtuCoding& coding) {
  if (tag.value("type") != "UnstructuredGrid") {
    tags.fail(tag.begin, "type=\"UnstructuredGrid\", found " + shown_word(tag.value("type")));
  }
  const std::string_view order = tag.value("byte_order", "LittleEndian"), header = tag.value("header_type", "UInt32"),
                         compressor = tag.value("compressor");
  if (order != "LittleEndian" && order != "BigEndian")
    tags.fail(tag.begin, "byte_order=\"LittleEndian\", found " + shown_word(order));
  if (header != "UInt32" && header != "UInt64") {
    tags.fail(tag.begin, "header_type=\"UInt32\" or \"UInt64\", found " + shown_word(header));
  }
  if (!compressor.empty() && compressor != "vtkZLibDataCompressor") {
    tags.fail(tag.begin, "data without compression or by vtkZLibDataCompressor, found " + shown_word(compressor));
  }
  coding.little_endian = order == "LittleEndian";
  coding.wide_header = header == "UInt64";
  coding.compressed = !compressor.empty();
}

/// The array that a tag begins, with its text.
VtuArray array_of(Tags& tags, const Tag& tag, std::string_view bytes) {
  VtuArray array{.name = tag.value("Name"), .type = tag.value("type"), .format = tag.value("format", "ascii")};
  if (array.format == "appended") array.offset = number_of(tags, tag, "offset");
  array.line = tags.line_at(tag.end);
  if (tag.is_empty) return array;
  const std::size_t end = std::min(bytes.find('<', tag.end), bytes.size());
  array.text = bytes.substr(tag.end, end - tag.end);
  return array;
}

VtuFile parsed_file(ReadBudget& budget, const std::string& file, std::string_view bytes) {
  Tags tags(budget, file, bytes);
  VtuFile vtu{.coding = {.budget = budget, .file = file}, .pieces = {}};
  bool has_head = false;
  std::string_view part;
  while (const std::optional<Tag> tag = tags.next()) {
    if (!has_head) {
      if (tag->name != "VTKFile" || tag->closes)
        tags.fail(tag->begin, "the tag VTKFile, found " + shown_word(tag->name));
      read_head(tags, *tag, vtu.coding);
      has_head = true;
    } else if (tag->closes) {
      if (tag->name == part) part = {};
    } else if (tag->name == "Piece") {
      budget.take(sizeof(Piece), ":" + std::to_string(tags.line_at(tag->begin)));
      vtu.pieces.push_back(
          {number_of(tags, *tag, "NumberOfPoints"), number_of(tags, *tag, "NumberOfCells"), {}, {}, {}, {}});
    } else if (tag->name == "AppendedData") {
      const std::string_view encoding = tag->value("encoding", "base64");
      if (encoding != "raw" && encoding != "base64")
        tags.fail(tag->begin, "encoding=\"raw\" or \"base64\", found " + shown_word(encoding));
      vtu.coding.appended_as_text = encoding == "base64";
      const std::size_t mark = bytes.find_first_not_of(" \t\r\n", tag->end);
      if (mark == std::string_view::npos || bytes[mark] != '_') tags.fail(tag->end, "appended data that begins with _");
      vtu.coding.appended = bytes.substr(mark + 1);
      // What follows may be any bytes, brackets among them.
      break;
    } else if (tag->name == "DataArray" && !vtu.pieces.empty()) {
      Piece& piece = vtu.pieces.back();
      const std::string_view name = tag->value("Name");
      if (part == "Points") {
        if (tag->value("NumberOfComponents") != "3") tags.fail(tag->begin, "NumberOfComponents=\"3\" of the points");
        piece.coordinates = array_of(tags, *tag, bytes);
      } else if (part == "Cells" && name == "connectivity") {
        piece.connectivity = array_of(tags, *tag, bytes);
      } else if (part == "Cells" && name == "offsets") {
        piece.offsets = array_of(tags, *tag, bytes);
      } else if (part == "Cells" && name == "types") {
        piece.types = array_of(tags, *tag, bytes);
      }
    } else if ((tag->name == "Points" || tag->name == "Cells" || tag->name == "PointData" || tag->name == "CellData" ||
                tag->name == "FieldData") &&
               !tag->is_empty) {
      part = tag->name;
    }
  }
  if (!has_head) tags.fail(bytes.size(), "the tag VTKFile, found the end of the file");
  if (vtu.pieces.empty()) tags.fail(bytes.size(), "a tag Piece, found the end of the file");
  return vtu;
}

/// vtkCellType.h
constexpr std::int64_t vtk_tetra = 10;
bool is_surface_or_less(std::int64_t type) {
  return (type >= 0 && type <= 9) || (type >= 21 && type <= 23) || (type >= 28 && type <= 31) ||
         (type >= 34 && type <= 36);
}

void read_piece(const VtuCoding& coding, const Piece& piece, VolumeSoup& soup, std::size_t& left_out) {
  const auto fail = [&](const std::string& what) {
    throw InputError(coding.file + ": " + what + "; save the mesh again as VTK unstructured grid (.vtu)");
  };
  const auto need = [&](const std::optional<VtuArray>& array, const char* name) -> const VtuArray& {
    if (!array) fail(std::string("a piece has no data array ") + name);
    return *array;
  };
  if (piece.points == 0 && piece.cells == 0) return;
  const std::vector<double> coordinates = real_values(coding, need(piece.coordinates, "of points"));
  const std::vector<std::int64_t> corners = whole_values(coding, need(piece.connectivity, "connectivity"));
  const std::vector<std::int64_t> ends = whole_values(coding, need(piece.offsets, "offsets"));
  const std::vector<std::int64_t> types = whole_values(coding, need(piece.types, "types"));
  if (coordinates.size() % 3 != 0 || coordinates.size() / 3 != piece.points) {
    fail("a piece says " + std::to_string(piece.points) + " points and has " + std::to_string(coordinates.size()) +
         " coordinates");
  }
  if (ends.size() != piece.cells || types.size() != piece.cells) {
    fail("a piece says " + std::to_string(piece.cells) + " cells and has " + std::to_string(ends.size()) +
         " offsets and " + std::to_string(types.size()) + " types");
  }
  coding.budget.take(piece.points * sizeof(Vec3) + piece.cells * sizeof soup.tets[0]);
  const auto first = static_cast<std::int64_t>(soup.nodes.size());
  for (std::size_t i = 0; i < coordinates.size(); i += 3) {
    soup.nodes.push_back({coordinates[i], coordinates[i + 1], coordinates[i + 2]});
    if (!is_usable(soup.nodes.back()))
      fail("point " + std::to_string(i / 3) + ": a coordinate is not finite or beyond 1e15");
  }
  std::int64_t begin = 0;
  for (std::size_t cell = 0; cell < types.size(); ++cell) {
    const std::string name = "cell " + std::to_string(cell);
    const std::int64_t end = ends[cell];
    if (end < begin || end > static_cast<std::int64_t>(corners.size()))
      fail(name + ": the offset " + std::to_string(end) + " is out of range");
    if (types[cell] == vtk_tetra) {
      if (end - begin != 4) fail(name + ": expected 4 corners of a tetrahedron, found " + std::to_string(end - begin));
      std::array<int, 4> tet{};
      for (std::size_t k = 0; k < 4; ++k) {
        const std::int64_t corner = corners[static_cast<std::size_t>(begin) + k];
        if (corner < 0 || corner >= static_cast<std::int64_t>(piece.points)) {
          fail(name + ": expected an index below " + std::to_string(piece.points) + ", the number of points, found " +
               std::to_string(corner));
        }
        tet[k] = static_cast<int>(first + corner);
      }
      std::array<int, 4> sorted = tet;
      std::sort(sorted.begin(), sorted.end());
      if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) fail(name + " names a point twice");
      soup.tets.push_back(tet);
    } else if (is_surface_or_less(types[cell])) {
      ++left_out;
    } else {
      fail(name + " is of the VTK type " + std::to_string(types[cell]) +
           "; a deformable body is made of tetrahedra of 4 nodes (type 10)");
    }
    begin = end;
  }
}

}  // namespace

VolumeSoup read_vtu(const std::string& file, std::string_view bytes) {
  ReadBudget budget(file, bytes.size());
  const VtuFile vtu = parsed_file(budget, file, bytes);
  VolumeSoup soup;
  std::size_t left_out = 0;
  for (const Piece& piece : vtu.pieces) read_piece(vtu.coding, piece, soup, left_out);
  if (left_out > 0) soup.notes.push_back(std::to_string(left_out) + " cells of fewer than 3 dimensions were left out");
  return soup;
}

}  // namespace tactor
