#include "app/bridge/bridge_packed.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

namespace tactor {

namespace {

static_assert(std::endian::native == std::endian::little);
static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(Quat) == 4 * sizeof(double));

template <class T>
void put(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <class T>
using Doubles = std::array<double, sizeof(T) / sizeof(double)>;

/// All numbers of a field that is left out are NaN.
template <class T>
T untold() {
  Doubles<T> numbers;
  numbers.fill(std::numeric_limits<double>::quiet_NaN());
  return std::bit_cast<T>(numbers);
}
template <class T>
bool is_untold(const T& value) {
  const auto numbers = std::bit_cast<Doubles<T>>(value);
  return std::all_of(numbers.begin(), numbers.end(), [](double number) { return std::isnan(number); });
}

/// Behind its head, every number of a message takes 8 bytes.
template <class T>
using Packed = std::conditional_t<std::same_as<T, std::int32_t>, std::int64_t, T>;

/// The kind, and which of the optional fields are given: bit i for the i-th of them.
constexpr std::size_t given_offset = 4;
constexpr std::size_t head_bytes = 8;

/// Writes a record; the elements of its lists come behind all of its fields.
class PackedWriter {
 public:
  explicit PackedWriter(std::string& bytes) : bytes_(bytes) {}
  template <IsPlain T>
  void operator()(const char*, const T& value) {
    put(bytes_, static_cast<Packed<T>>(value));
  }
  template <class T>
  void operator()(const char* name, const std::optional<T>& value) {
    if (value) given |= 1U << optionals_;
    ++optionals_;
    (*this)(name, value.value_or(T{}));
  }
  template <class Record>
  void operator()(const char*, const std::vector<Record>& list) {
    put(bytes_, static_cast<std::uint64_t>(list.size()));
    PackedWriter elements(tail);
    for (const Record& one : list) fields(elements, one);
  }
  template <class Record>
  void operator()(const char*, const Record& record) {
    fields(*this, record);
  }
  template <class T>
  void or_default(const char* name, const T& value) {
    (*this)(name, value);
  }
  template <class T>
  void if_told(const std::optional<bool>& has, const char* name, const T& value) {
    (*this)(name, has.value_or(false) ? value : untold<T>());
  }

  std::uint32_t given = 0;
  std::string tail;  // elements of lists

 private:
  std::string& bytes_;
  unsigned optionals_ = 0;
};

template <class Record>
std::string bytes_of(BridgeKind kind, const Record& record) {
  std::string bytes;
  put(bytes, static_cast<std::uint32_t>(kind));
  put(bytes, std::uint32_t{0});
  PackedWriter writer(bytes);
  fields(writer, record);
  std::memcpy(bytes.data() + given_offset, &writer.given, sizeof writer.given);
  return bytes + writer.tail;
}

/// Bytes of an element of a list.
template <class Record>
std::size_t size_of_element() {
  static const std::size_t size = [] {
    std::string bytes;
    PackedWriter writer(bytes);
    const Record record{};
    fields(writer, record);
    return bytes.size();
  }();
  return size;
}

/// The bytes that are still to be read.
class Bytes {
 public:
  explicit Bytes(std::string_view bytes) : left_(bytes) {}
  template <class T>
  void get(T& value) {
    if (left_.size() < sizeof value) throw BridgeRefusal("", "the message is too short");
    std::memcpy(&value, left_.data(), sizeof value);
    left_.remove_prefix(sizeof value);
  }
  [[nodiscard]] std::size_t left() const { return left_.size(); }

 private:
  std::string_view left_;
};

class PackedReader {
 public:
  PackedReader(Bytes& bytes, std::uint32_t given) : bytes_(bytes), given_(given) {}
  template <IsPlain T>
  void operator()(const char* name, T& value) {
    Packed<T> packed{};
    bytes_.get(packed);
    value = static_cast<T>(packed);
    if constexpr (std::same_as<T, std::int32_t>) {
      if (value != packed) throw BridgeRefusal(name, "expected a whole number in range");
    }
  }
  template <class T>
  void operator()(const char* name, std::optional<T>& value) {
    const bool is_given = (given_ >> optionals_++ & 1U) != 0;
    (*this)(name, value.emplace());
    if (!is_given) value.reset();
  }
  template <class Record>
  void operator()(const char* name, std::vector<Record>& list) {
    std::uint64_t count = 0;
    bytes_.get(count);
    const bool is_given = (given_ >> (optionals_ - 1) & 1U) != 0;
    if (!is_given && count > 0) throw BridgeRefusal(name, "expected a count of 0, because the list is not given");
    if (count > most_of(list)) {
      throw BridgeRefusal(
          name, "expected at most " + std::to_string(most_of(list)) + " in the list, found " + std::to_string(count));
    }
    expected_ += count * size_of_element<Record>();
    if (count == 0) return;
    list.resize(count);
    elements_.emplace_back([this, &list] {
      PackedReader reader(bytes_, 0);
      for (Record& one : list) fields(reader, one);
    });
  }
  template <class Record>
  void operator()(const char*, Record& record) {
    fields(*this, record);
  }
  template <class T>
  void or_default(const char* name, T& value) {
    (*this)(name, value);
  }
  template <class T>
  void if_told(std::optional<bool>& has, const char* name, T& value) {
    (*this)(name, value);
    const bool is_there = !is_untold(value);
    if (!is_there) value = {};
    has = has.value_or(true) && is_there;
  }
  /// Reads the elements of lists, which are all that is left.
  void finish() {
    if (optionals_ < 32 && given_ >> optionals_ != 0) throw BridgeRefusal("given", "there is no such optional field");
    if (bytes_.left() != expected_) {
      throw BridgeRefusal("", "expected " + std::to_string(expected_) + " bytes behind the fields, found " +
                                  std::to_string(bytes_.left()));
    }
    for (const auto& read : elements_) read();
  }

 private:
  Bytes& bytes_;
  std::uint32_t given_;
  unsigned optionals_ = 0;
  std::size_t expected_ = 0;                     // bytes of elements
  std::vector<std::function<void()>> elements_;  // reads them, list by list
};

BridgeKind kind_of(Bytes& bytes) {
  std::uint32_t kind = 0;
  bytes.get(kind);
  return static_cast<BridgeKind>(kind);
}

template <class Record>
Record record_in(Bytes& bytes) {
  std::uint32_t given = 0;
  bytes.get(given);
  Record record;
  PackedReader reader(bytes, given);
  fields(reader, record);
  reader.finish();
  return record;
}

using LayoutJson = nlohmann::ordered_json;

/// Lists the places of fields.
class LayoutWriter {
 public:
  explicit LayoutWriter(std::size_t begin) : offset_(begin) {}
  template <IsPlain T>
  void operator()(const char* name, const T&) {
    constexpr bool is_real = !std::is_integral_v<T> && !std::same_as<T, Time>;
    add(name, is_real ? "f64" : std::same_as<T, std::uint64_t> ? "u64" : "i64", sizeof(Packed<T>) / 8);
  }
  template <class T>
  void operator()(const char* name, const std::optional<T>&) {
    const std::size_t first = list_.size();
    (*this)(name, T{});
    for (std::size_t i = first; i < list_.size(); ++i) list_[i]["given"] = optionals_;
    ++optionals_;
  }
  template <class Record>
  void operator()(const char* name, const std::vector<Record>&) {
    add(name, "u64", 1);
  }
  template <class Record>
  void operator()(const char* name, const Record& record) {
    const std::string outer = std::exchange(path_, path_ + name + ".");
    fields(*this, record);
    path_ = outer;
  }
  template <class T>
  void or_default(const char* name, const T& value) {
    (*this)(name, value);
  }
  template <class T>
  void if_told(const std::optional<bool>&, const char* name, const T& value) {
    (*this)(name, value);
  }
  [[nodiscard]] LayoutJson layout() && { return {{"bytes", offset_}, {"fields", std::move(list_)}}; }

 private:
  void add(const char* name, const char* type, std::size_t count) {
    list_.push_back({{"name", path_ + name}, {"type", type}, {"count", count}, {"offset", offset_}});
    offset_ += 8 * count;
  }

  LayoutJson list_ = LayoutJson::array();
  std::string path_;
  std::size_t offset_;
  unsigned optionals_ = 0;
};

template <class Record>
LayoutJson layout_of(std::size_t begin) {
  LayoutWriter writer(begin);
  const Record record{};
  fields(writer, record);
  return std::move(writer).layout();
}

LayoutJson layout_of_message(BridgeKind kind, LayoutJson layout) {
  layout["kind"] = static_cast<std::uint32_t>(kind);
  return layout;
}

}  // namespace

std::string to_bytes(const BridgeStep& step) {
  return bytes_of(BridgeKind::step, step);
}

std::string to_bytes(const BridgeResult& result) {
  return bytes_of(BridgeKind::result, result);
}

std::string to_bytes(const BridgeError& error) {
  std::string bytes;
  put(bytes, static_cast<std::uint32_t>(BridgeKind::error));
  put(bytes, static_cast<std::uint32_t>(error.message.size()));
  put(bytes, static_cast<std::uint32_t>(error.field.size()));
  return bytes + error.message + error.field;
}

std::variant<BridgeNext, BridgeResult> read_client_bytes(std::string_view message) {
  Bytes bytes(message);
  const BridgeKind kind = kind_of(bytes);
  if (kind == BridgeKind::next) {
    if (bytes.left() > 0) throw BridgeRefusal("", "expected no bytes behind the kind 4");
    return BridgeNext{};
  }
  if (kind != BridgeKind::result) throw BridgeRefusal("kind", "expected 2 for a result, or 4 for next");
  return record_in<BridgeResult>(bytes);
}

BridgeStep read_step_bytes(std::string_view message) {
  Bytes bytes(message);
  if (kind_of(bytes) != BridgeKind::step) throw BridgeRefusal("kind", "expected 1 for a step");
  return record_in<BridgeStep>(bytes);
}

std::string packed_layouts() {
  const LayoutJson layouts{{"step", layout_of_message(BridgeKind::step, layout_of<BridgeStep>(head_bytes))},
                           {"result", layout_of_message(BridgeKind::result, layout_of<BridgeResult>(head_bytes))},
                           {"contact", layout_of<BridgeContact>(0)},
                           {"body", layout_of<BridgeBody>(0)}};
  return layouts.dump();
}

}  // namespace tactor
