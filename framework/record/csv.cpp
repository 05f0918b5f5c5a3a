#include "framework/record/csv.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <fstream>
#include <map>
#include <ostream>
#include <string>
#include <string_view>

#include "framework/core/check.hpp"
#include "framework/core/input_file.hpp"
#include "framework/core/read_budget.hpp"
#include "framework/core/shared_array.hpp"
#include "framework/record/csv_columns.hpp"

namespace tactor {

namespace {

constexpr std::array<std::string_view, 3> stamp_columns{"valid_s", "produced_s", "sequence"};
constexpr std::int64_t second_ns = 1'000'000'000;

template <class T>
void append_number(std::string& row, T value) {
  std::array<char, 32> digits{};
  const auto result = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  row.append(digits.data(), result.ptr);
}

/// Whole nanoseconds as seconds, with all nine decimals.
void append_seconds(std::string& row, std::int64_t ns) {
  if (ns < 0) row += '-';
  append_number(row, std::abs(ns / second_ns));
  const std::string fraction = std::to_string(std::abs(ns % second_ns));
  row.append(".").append(9 - fraction.size(), '0').append(fraction);
}

/// Calls `work` with a value of the C++ type of a kind that is no record.
template <class Work>
auto with_kind(FieldKind kind, const Work& work) {
  switch (kind) {
    case FieldKind::i8:
      return work(std::int8_t{});
    case FieldKind::u8:
      return work(std::uint8_t{});
    case FieldKind::i16:
      return work(std::int16_t{});
    case FieldKind::u16:
      return work(std::uint16_t{});
    case FieldKind::i32:
      return work(std::int32_t{});
    case FieldKind::u32:
      return work(std::uint32_t{});
    case FieldKind::i64:
      return work(std::int64_t{});
    case FieldKind::u64:
      return work(std::uint64_t{});
    case FieldKind::f32:
      return work(float{});
    default:
      return work(double{});
  }
}

void append_value(std::string& row, const Field& field, const std::byte* at) {
  with_kind(field.kind, [&](auto value) {
    std::memcpy(&value, at, sizeof value);
    for (const Enumerator& one : field.enumerators) {
      if (one.value != static_cast<std::int64_t>(value)) continue;
      row += one.name;
      return;
    }
    append_number(row, value);
  });
}

void append_cell(std::string& row, const CsvValue& column, const std::byte* message) {
  if (!column.in_array) {
    append_value(row, *column.field, message + column.offset);
    return;
  }
  const auto& elements = *reinterpret_cast<const SharedBytes*>(message + column.array_offset);
  for (std::size_t i = 0; i < elements.count(); ++i) {
    if (i > 0) row += ' ';
    append_value(row, *column.field, elements.elements() + i * column.array_stride + column.offset);
  }
}

/// Reads cells of one file, and names the place of what is wrong.
class CsvMessages {
 public:
  CsvMessages(const std::filesystem::path& path, std::uint64_t file_bytes, const MessageType& type)
      : path_(path), type_(type), budget_(path.string(), file_bytes), columns_(csv_values(type)) {}

  void read(std::istream& in, const std::function<void(const Stamp&, const void*)>& take) {
    std::string line;
    ++line_;
    if (!std::getline(in, line)) refuse("the file is empty");
    read_headings(cells_of(line));
    MessageBatch message(type_);
    while (std::getline(in, line)) {
      ++line_;
      take_bytes(line.size());
      const std::vector<std::string_view> cells = cells_of(line);
      if (cells.size() != column_of_.size()) {
        refuse("expected " + std::to_string(column_of_.size()) + " cells, found " + std::to_string(cells.size()));
      }
      message.clear();
      message.add({});
      read_row(cells, message);
      take(message.stamp(0), message.value(0));
    }
    if (in.bad()) refuse("it cannot be read to its end");
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const {
    throw InputError(path_.string() + ":" + std::to_string(line_) + ": " + why);
  }

  void take_bytes(std::uint64_t bytes) {
    if (!budget_.holds(bytes)) refuse(budget_.refusal());
  }

  static std::vector<std::string_view> cells_of(std::string_view line) {
    if (line.ends_with('\r')) line.remove_suffix(1);
    std::vector<std::string_view> cells;
    for (;;) {
      const std::size_t comma = line.find(',');
      cells.push_back(line.substr(0, comma));
      if (comma == std::string_view::npos) return cells;
      line.remove_prefix(comma + 1);
    }
  }

  void read_headings(const std::vector<std::string_view>& headings) {
    std::map<std::string_view, std::size_t> expected;
    for (std::size_t i = 0; i < stamp_columns.size(); ++i) expected[stamp_columns[i]] = i;
    for (std::size_t i = 0; i < columns_.size(); ++i) expected[columns_[i].heading] = stamp_columns.size() + i;
    for (const std::string_view heading : headings) {
      const auto found = expected.find(heading);
      if (found == expected.end()) {
        refuse("messages " + type_.name + " have no column \"" + std::string(heading) + "\", or it is there twice");
      }
      column_of_.push_back(found->second);
      expected.erase(found);
    }
    if (!expected.empty()) {
      refuse("messages " + type_.name + " need a column \"" + std::string(expected.begin()->first) + "\"");
    }
  }

  void read_row(const std::vector<std::string_view>& cells, MessageBatch& message) {
    std::byte* value = message.value(0);
    for (std::size_t c = 0; c < cells.size(); ++c) {
      const std::size_t column = column_of_[c];
      if (column == 0) {
        message.stamp(0).valid.ns = nanoseconds(cells[c]);
      } else if (column == 1) {
        message.stamp(0).produced.ns = nanoseconds(cells[c]);
      } else if (column == 2) {
        message.stamp(0).sequence = number<std::uint64_t>(cells[c], "sequence");
      } else {
        read_cell(columns_[column - stamp_columns.size()], cells[c], value);
      }
    }
  }

  void read_cell(const CsvValue& column, std::string_view cell, std::byte* message) {
    if (!column.in_array) {
      read_value(column, cell, message + column.offset);
      return;
    }
    std::vector<std::string_view> values;
    while (!cell.empty()) {
      const std::size_t space = cell.find(' ');
      values.push_back(cell.substr(0, space));
      cell.remove_prefix(space == std::string_view::npos ? cell.size() : space + 1);
    }
    auto& elements = *reinterpret_cast<SharedBytes*>(message + column.array_offset);
    // The first column of an array that has elements makes it; the others have as many.
    if (elements.count() == 0 && !values.empty()) {
      take_bytes(values.size() * column.array_stride);
      ArrayBlock* block = allocate_array(values.size(), column.array_stride);
      std::memset(block->elements(), 0, values.size() * column.array_stride);
      elements = SharedBytes(block);
    }
    if (elements.count() != values.size()) {
      refuse(column.heading + ": expected " + std::to_string(elements.count()) + " values, found " +
             std::to_string(values.size()));
    }
    // Nobody else has a copy yet.
    auto* at = const_cast<std::byte*>(elements.elements());
    for (std::size_t i = 0; i < values.size(); ++i) {
      read_value(column, values[i], at + i * column.array_stride + column.offset);
    }
  }

  void read_value(const CsvValue& column, std::string_view text, std::byte* to) {
    const Field& field = *column.field;
    const auto named = std::find_if(field.enumerators.begin(), field.enumerators.end(),
                                    [text](const Enumerator& one) { return one.name == text; });
    if (named == field.enumerators.end() && !field.enumerators.empty()) {
      refuse(column.heading + ": there is no value \"" + std::string(text) + "\"");
    }
    with_kind(field.kind, [&](auto value) {
      using T = decltype(value);
      value = field.enumerators.empty() ? number<T>(text, column.heading) : static_cast<T>(named->value);
      std::memcpy(to, &value, sizeof value);
    });
  }

  template <class T>
  [[nodiscard]] T number(std::string_view text, std::string_view heading) const {
    T value{};
    const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
    if (result.ec != std::errc{} || result.ptr != text.data() + text.size()) {
      refuse(std::string(heading) + ": expected a number, found \"" + std::string(text) + "\"");
    }
    return value;
  }

  /// `-12.000000345`, exactly.
  [[nodiscard]] std::int64_t nanoseconds(std::string_view text) const {
    const bool negative = text.starts_with('-');
    const std::string_view digits = text.substr(negative ? 1 : 0);
    const std::size_t point = digits.find('.');
    const std::string_view decimals = point == std::string_view::npos ? "" : digits.substr(point + 1);
    const auto seconds = number<std::uint32_t>(digits.substr(0, point), "a time in s");
    std::int64_t ns = 0;
    if (!decimals.empty()) {
      if (decimals.size() > 9) refuse("a time has at most nine decimals, found \"" + std::string(text) + "\"");
      ns = number<std::uint32_t>(decimals, "a time in s");
      for (std::size_t i = decimals.size(); i < 9; ++i) ns *= 10;
    }
    ns += std::int64_t{seconds} * second_ns;
    return negative ? -ns : ns;
  }

  const std::filesystem::path& path_;
  const MessageType& type_;
  ReadBudget budget_;
  std::vector<CsvValue> columns_;
  std::vector<std::size_t> column_of_;  // by cell: 0 to 2 the stamps, then the columns
  std::size_t line_ = 0;
};

}  // namespace

void export_csv(RecordingReader& reader, std::size_t stream, std::ostream& out) {
  TACTOR_DEMAND(stream < reader.streams().size());
  const RecordedStream& info = reader.streams()[stream];
  const std::vector<CsvValue> columns = csv_values(info.type);
  std::string row;
  for (const std::string_view name : stamp_columns) row.append(row.empty() ? "" : ",").append(name);
  for (const CsvValue& column : columns) row.append(",").append(column.heading);
  out << row << '\n';
  constexpr std::uint64_t block = 256;
  MessageBatch messages(info.type);
  for (std::uint64_t first = 0; first < info.count; first += block) {
    messages.clear();
    reader.read(stream, first, std::min(block, info.count - first), messages);
    for (std::size_t k = 0; k < messages.size(); ++k) {
      const Stamp& stamp = messages.stamp(k);
      row.clear();
      append_seconds(row, stamp.valid.ns);
      row += ',';
      append_seconds(row, stamp.produced.ns);
      row += ',';
      append_number(row, stamp.sequence);
      for (const CsvValue& column : columns) {
        row += ',';
        append_cell(row, column, messages.value(k));
      }
      out << row << '\n';
    }
  }
  if (!out.flush()) throw RunError("cannot write the CSV export of " + info.name + ": the output does not take it");
}

void import_csv(const std::filesystem::path& path, const MessageType& type,
                const std::function<void(const Stamp&, const void*)>& take) {
  const InputFile input = open_input(path);
  if (input.is_missing) throw InputError("there is no file " + path.string());
  if (!input.file) throw InputError(path.string() + ": " + input.error);
  std::ifstream in(path);
  CsvMessages(path, input.size, type).read(in, take);
}

}  // namespace tactor
