// What the bytes of a report mean: fields with place, type and scale, and the part each plays.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tactor {

/// The numbers a field may hold, two's complement or IEEE 754.
enum class FieldType : std::uint8_t { u8, i8, u16, i16, u32, i32, f32 };
/// Which byte of a number comes first.
enum class ByteOrder : std::uint8_t { little, big };

/// A number in a report.
struct ReportField {
  std::string name;
  std::size_t at = 0;  ///< of its first byte, from 0
  FieldType type = FieldType::i16;
  ByteOrder order = ByteOrder::little;

  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] bool is_whole() const { return type != FieldType::f32; }
  /// How many values a whole number of this type has, for counters that begin anew; 0 for f32.
  [[nodiscard]] double span() const;
  /// The least and the largest value it can hold.
  [[nodiscard]] double least() const;
  [[nodiscard]] double most() const;
  /// The number there. The report must hold it.
  [[nodiscard]] double read(std::span<const std::uint8_t> report) const;
  /// Puts `value` there: rounded where whole, cut to what the type holds, 0 where it is not a number.
  void write(std::span<std::uint8_t> report, double value) const;
};

/// The coordinate of an axis out of a field: value = scale * field + offset in m or rad, or, where it was counted from
/// a zero that a calibration has found, scale * (field - zero) + offset.
struct AxisInput {
  std::size_t field = 0;  ///< its index
  double scale = 1;       ///< m or rad a count
  double offset = 0;      ///< m or rad
};

/// The effort of an axis into a field: field = scale * effort, cut to +-limit.
struct AxisOutput {
  std::size_t field = 0;
  double scale = 1;  ///< counts an N or N m
  double limit = 0;  ///< counts; the largest that the device may be sent
};

/// What makes a bit of DeviceState::buttons or a fault: a bit of a whole field that is set, or a value above a bound.
struct Flag {
  std::size_t field = 0;
  int bit = -1;         ///< below zero: `above` counts
  double above = 0;     ///< of the field
  std::string meaning;  ///< of a fault, in words
  [[nodiscard]] bool is_set(const std::vector<ReportField>& fields, std::span<const std::uint8_t> report) const;
};

/// What the device sends.
struct InputLayout {
  std::size_t size = 0;  ///< bytes of a report, exactly
  std::vector<ReportField> fields;
  std::vector<AxisInput> axes;
  std::vector<Flag> buttons;  ///< at most 32
  std::vector<Flag> faults;   ///< at most 32
};

/// A field that is sent with a fixed value.
struct FixedOutput {
  std::size_t field = 0;
  double value = 0;
};

/// What the device is sent. Bytes that no field holds are zero.
struct OutputLayout {
  std::size_t size = 0;
  std::vector<ReportField> fields;
  std::vector<AxisOutput> axes;
  std::vector<FixedOutput> fixed;
};

/// The report that gives the axes these efforts (N or N m, one an axis). `report` has the layout's size.
void write_efforts(const OutputLayout& layout, std::span<const double> efforts, std::span<std::uint8_t> report);

/// The distance from `zero` to `count` of a counter that begins anew after `span` values, the shorter way round; the
/// plain difference where span is 0.
double count_from(double zero, double count, double span);

}  // namespace tactor
