#include "framework/record/csv.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <string>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

std::string column_name(const Field& field, std::size_t i) {
  constexpr std::string_view vector_axes = "xyz";
  constexpr std::string_view quaternion_axes = "wxyz";
  std::string name(field.name);
  if (field.count == 3) {
    name.append("_").append(1, vector_axes[i]);
  } else if (field.count == 4) {
    name.append("_").append(1, quaternion_axes[i]);
  } else if (field.count > 1) {
    name.append("_").append(std::to_string(i));
  }
  // A field of mixed units lists them with commas, which would split the header.
  std::string unit(field.unit);
  std::replace(unit.begin(), unit.end(), ',', ';');
  return name.append(" [").append(unit).append("]");
}

template <class T>
void append_number(std::string& row, T value) {
  std::array<char, 32> digits{};
  const auto result = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  row.append(digits.data(), result.ptr);
}

template <class T>
void append_value(std::string& row, const std::byte* at) {
  T value{};
  std::memcpy(&value, at, sizeof value);
  append_number(row, value);
}

/// Whole nanoseconds as seconds, with all nine decimals.
void append_seconds(std::string& row, std::int64_t ns) {
  constexpr std::int64_t second = 1'000'000'000;
  if (ns < 0) row += '-';
  append_number(row, std::abs(ns / second));
  const std::string fraction = std::to_string(std::abs(ns % second));
  row.append(".").append(9 - fraction.size(), '0').append(fraction);
}

}  // namespace

void export_csv(RecordingReader& reader, std::size_t stream, std::ostream& out) {
  TACTOR_DEMAND(stream < reader.streams().size());
  const RecordedStream& info = reader.streams()[stream];
  std::string row = "valid_s,produced_s,sequence";
  for (const Field& field : info.type->fields) {
    for (std::size_t i = 0; i < field.count; ++i) row.append(",").append(column_name(field, i));
  }
  out << row << '\n';
  constexpr std::uint64_t block = 256;
  std::vector<Stamp> stamps;
  std::vector<std::byte> payloads;
  for (std::uint64_t first = 0; first < info.count; first += block) {
    reader.read(stream, first, std::min(block, info.count - first), stamps, payloads);
    for (std::size_t k = 0; k < stamps.size(); ++k) {
      row.clear();
      append_seconds(row, stamps[k].valid.ns);
      row += ',';
      append_seconds(row, stamps[k].produced.ns);
      row += ',';
      append_number(row, stamps[k].sequence);
      for (const Field& field : info.type->fields) {
        const std::byte* at = payloads.data() + k * info.type->size + field.offset;
        for (std::size_t i = 0; i < field.count; ++i) {
          row += ',';
          switch (field.kind) {
            case FieldKind::f64:
              append_value<double>(row, at + 8 * i);
              break;
            case FieldKind::i64:
              append_value<std::int64_t>(row, at + 8 * i);
              break;
            case FieldKind::i32:
              append_value<std::int32_t>(row, at + 4 * i);
              break;
          }
        }
      }
      out << row << '\n';
    }
  }
  if (!out.flush()) throw RunError("cannot write the CSV export of " + info.name + ": the output does not take it");
}

}  // namespace tactor
