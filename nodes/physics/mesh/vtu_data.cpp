#include "nodes/physics/mesh/vtu_data.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "framework/core/check.hpp"
#include "nodes/physics/mesh/mesh_words.hpp"

namespace tactor {

namespace {

[[noreturn]] void fail_array(const VtuCoding& coding, const VtuArray& array, const std::string& what) {
  throw InputError(coding.file + ": data array " + shown_word(array.name) + ": " + what +
                   "; save the mesh again as VTK unstructured grid (.vtu), for instance as text");
}

/// Charges bytes for an array to the budget of the file.
void take_bytes(const VtuCoding& coding, const VtuArray& array, std::uint64_t bytes) {
  if (!coding.budget.holds(bytes)) fail_array(coding, array, coding.budget.refusal());
}

int sextet(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

/// Takes bytes from coded data, from its front.
class VtuBytes {
 public:
  VtuBytes(const VtuCoding& coding, const VtuArray& array) : coding_(coding), array_(array), rest_(array.text) {
    if (array.format != "appended") return;
    if (array.offset > coding.appended.size()) fail_array(coding, array, "its offset lies beyond the appended data");
    rest_ = coding.appended.substr(array.offset);
    is_text_ = coding.appended_as_text;
  }

  std::string take(std::uint64_t size) {
    // Three bytes are four characters.
    if (size > decoded_.size() + rest_.size()) fail_array(coding_, array_, "the data ends too early");
    take_bytes(coding_, array_, size + ReadBudget::step_cost);
    if (!is_text_) {
      std::string raw(rest_.substr(0, size));
      rest_.remove_prefix(size);
      return raw;
    }
    while (decoded_.size() < size) decode();
    std::string taken = decoded_.substr(0, size);
    decoded_.erase(0, size);
    return taken;
  }
  std::uint64_t take_size() {
    const std::string bytes = take(coding_.wide_header ? 8 : 4);
    std::uint64_t size = 0;
    std::memcpy(&size, bytes.data(), bytes.size());
    return size;
  }
  void expect_end() {
    if (array_.format == "appended") return;
    while (!rest_.empty() && is_blank(rest_[0])) rest_.remove_prefix(1);
    if (!rest_.empty() || !decoded_.empty()) fail_array(coding_, array_, "there is more data than its header says");
  }

 private:
  static bool is_blank(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }

  /// More bytes, many at a time. What is padded ends with its group of four, and other data may follow.
  void decode() {
    std::size_t groups = 0;
    for (; groups < 4096; ++groups) {
      while (!rest_.empty() && is_blank(rest_[0])) rest_.remove_prefix(1);
      if (rest_.size() < 4) break;
      const std::array<int, 4> six{sextet(rest_[0]), sextet(rest_[1]), sextet(rest_[2]), sextet(rest_[3])};
      const std::size_t bytes = rest_[2] == '=' && rest_[3] == '=' ? 1 : rest_[3] == '=' ? 2 : 3;
      if (six[0] < 0 || six[1] < 0 || (bytes > 1 && six[2] < 0) || (bytes > 2 && six[3] < 0)) {
        // Text that is needed is base64; what follows in the appended data may be anything.
        if (groups > 0) break;
        fail_array(coding_, array_, "the data is not base64");
      }
      const unsigned bits = static_cast<unsigned>(six[0]) << 18U | static_cast<unsigned>(six[1]) << 12U |
                            static_cast<unsigned>(std::max(six[2], 0)) << 6U |
                            static_cast<unsigned>(std::max(six[3], 0));
      for (std::size_t i = 0; i < bytes; ++i) decoded_ += static_cast<char>(bits >> (16 - 8 * i) & 0xffU);
      rest_.remove_prefix(4);
    }
    if (groups == 0) fail_array(coding_, array_, "the data ends too early");
  }

  const VtuCoding& coding_;
  const VtuArray& array_;
  std::string_view rest_;
  bool is_text_ = true;
  std::string decoded_;
};

/// `size` bytes out of what zlib made of them.
void inflate_block(const VtuCoding& coding, const VtuArray& array, const std::string& packed, std::uint64_t size,
                   std::string& out) {
  // zlib packs by a factor of 1032 at most.
  if (size > 1100 * packed.size() + 1100) fail_array(coding, array, "a block cannot be as long as its header says");
  take_bytes(coding, array, size);
  const std::size_t before = out.size();
  out.resize(before + size);
  uLongf length = size;
  const int result = uncompress(reinterpret_cast<Bytef*>(out.data() + before), &length,
                                reinterpret_cast<const Bytef*>(packed.data()), packed.size());
  if (result != Z_OK || length != size) fail_array(coding, array, "a block is not compressed as its header says");
}

std::string bytes_of(const VtuCoding& coding, const VtuArray& array) {
  if (!coding.little_endian) {
    fail_array(coding, array, "the bytes come from a big-endian machine; tactor does not read them");
  }
  VtuBytes bytes(coding, array);
  if (!coding.compressed) {
    const std::uint64_t size = bytes.take_size();
    std::string data = bytes.take(size);
    bytes.expect_end();
    return data;
  }
  const std::uint64_t blocks = bytes.take_size(), block_size = bytes.take_size(), last_size = bytes.take_size();
  std::vector<std::uint64_t> packed;
  // Also of blocks without content.
  if (blocks > coding.budget.bytes() / sizeof blocks) fail_array(coding, array, "the data ends too early");
  take_bytes(coding, array, blocks * sizeof blocks);
  for (std::uint64_t i = 0; i < blocks; ++i) packed.push_back(bytes.take_size());
  std::string data;
  for (std::uint64_t i = 0; i < blocks; ++i) {
    const std::uint64_t size = i + 1 == blocks && last_size > 0 ? last_size : block_size;
    inflate_block(coding, array, bytes.take(packed[i]), size, data);
  }
  bytes.expect_end();
  return data;
}

template <class Stored, class Value>
std::vector<Value> stored_as(const VtuCoding& coding, const VtuArray& array, const std::string& bytes) {
  if (bytes.size() % sizeof(Stored) != 0) {
    fail_array(coding, array, std::to_string(bytes.size()) + " bytes are no whole number of values");
  }
  take_bytes(coding, array, bytes.size() / sizeof(Stored) * sizeof(Value));
  std::vector<Value> values;
  values.reserve(bytes.size() / sizeof(Stored));
  for (std::size_t at = 0; at < bytes.size(); at += sizeof(Stored)) {
    Stored value{};
    std::memcpy(&value, bytes.data() + at, sizeof value);
    values.push_back(static_cast<Value>(value));
  }
  return values;
}

template <class Value>
std::vector<Value> values_in_text(const VtuCoding& coding, const VtuArray& array, const char* expected) {
  MeshWords words(coding.budget, coding.file, "a VTK file", array.text, array.line);
  std::vector<Value> values;
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    words.take(sizeof(Value));
    values.push_back(words.number<Value>(word, expected));
  }
  return values;
}

void check_format(const VtuCoding& coding, const VtuArray& array) {
  if (array.format != "ascii" && array.format != "binary" && array.format != "appended") {
    fail_array(coding, array, "expected the format ascii, binary or appended, found " + shown_word(array.format));
  }
}

}  // namespace

std::vector<double> real_values(const VtuCoding& coding, const VtuArray& array) {
  check_format(coding, array);
  const bool is_float = array.type == "Float32";
  if (!is_float && array.type != "Float64") {
    fail_array(coding, array, "expected the type Float32 or Float64, found " + shown_word(array.type));
  }
  if (array.format == "ascii") return values_in_text<double>(coding, array, "a number");
  const std::string bytes = bytes_of(coding, array);
  return is_float ? stored_as<float, double>(coding, array, bytes) : stored_as<double, double>(coding, array, bytes);
}

std::vector<std::int64_t> whole_values(const VtuCoding& coding, const VtuArray& array) {
  check_format(coding, array);
  using Values = std::vector<std::int64_t>;
  struct Type {
    const char* name;
    Values (*read)(const VtuCoding&, const VtuArray&, const std::string&);
  };
  static constexpr Type types[] = {
      {"Int8", stored_as<std::int8_t, std::int64_t>},   {"UInt8", stored_as<std::uint8_t, std::int64_t>},
      {"Int16", stored_as<std::int16_t, std::int64_t>}, {"UInt16", stored_as<std::uint16_t, std::int64_t>},
      {"Int32", stored_as<std::int32_t, std::int64_t>}, {"UInt32", stored_as<std::uint32_t, std::int64_t>},
      {"Int64", stored_as<std::int64_t, std::int64_t>}, {"UInt64", stored_as<std::uint64_t, std::int64_t>},
  };
  for (const Type& type : types) {
    if (array.type != type.name) continue;
    if (array.format == "ascii") return values_in_text<std::int64_t>(coding, array, "a whole number");
    return type.read(coding, array, bytes_of(coding, array));
  }
  fail_array(coding, array, "expected a type of whole numbers, found " + shown_word(array.type));
}

}  // namespace tactor
