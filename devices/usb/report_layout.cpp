#include "devices/usb/report_layout.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

bool is_signed(FieldType type) {
  return type == FieldType::i8 || type == FieldType::i16 || type == FieldType::i32;
}

std::uint32_t bits_of(const ReportField& field, std::span<const std::uint8_t> report) {
  const std::size_t n = field.size();
  TACTOR_ASSERT(field.at + n <= report.size());
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t place = field.order == ByteOrder::big ? i : n - 1 - i;
    bits = (bits << 8U) | report[field.at + place];
  }
  return bits;
}

}  // namespace

std::size_t ReportField::size() const {
  switch (type) {
    case FieldType::u8:
    case FieldType::i8:
      return 1;
    case FieldType::u16:
    case FieldType::i16:
      return 2;
    default:
      return 4;
  }
}

double ReportField::span() const {
  return is_whole() ? std::ldexp(1.0, static_cast<int>(8 * size())) : 0;
}

double ReportField::least() const {
  if (!is_whole()) return -static_cast<double>(std::numeric_limits<float>::max());
  return is_signed(type) ? -span() / 2 : 0;
}

double ReportField::most() const {
  if (!is_whole()) return static_cast<double>(std::numeric_limits<float>::max());
  return (is_signed(type) ? span() / 2 : span()) - 1;
}

double ReportField::read(std::span<const std::uint8_t> report) const {
  const std::uint32_t bits = bits_of(*this, report);
  switch (type) {
    case FieldType::i8:
      return static_cast<std::int8_t>(bits);
    case FieldType::i16:
      return static_cast<std::int16_t>(bits);
    case FieldType::i32:
      return static_cast<std::int32_t>(bits);
    case FieldType::f32:
      return std::bit_cast<float>(bits);
    default:
      return bits;
  }
}

void ReportField::write(std::span<std::uint8_t> report, double value) const {
  const std::size_t n = size();
  TACTOR_ASSERT(at + n <= report.size());
  const double held = std::isfinite(value) ? std::clamp(value, least(), most()) : 0.0;
  const std::uint32_t bits = is_whole() ? static_cast<std::uint32_t>(std::llround(held))
                                        : std::bit_cast<std::uint32_t>(static_cast<float>(held));
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t place = order == ByteOrder::big ? n - 1 - i : i;
    report[at + place] = static_cast<std::uint8_t>(bits >> (8U * i));
  }
}

bool Flag::is_set(const std::vector<ReportField>& fields, std::span<const std::uint8_t> report) const {
  if (bit < 0) return fields[field].read(report) > above;
  return ((bits_of(fields[field], report) >> static_cast<unsigned>(bit)) & 1U) != 0;
}

void write_efforts(const OutputLayout& layout, std::span<const double> efforts, std::span<std::uint8_t> report) {
  TACTOR_ASSERT(report.size() == layout.size && efforts.size() >= layout.axes.size());
  std::fill(report.begin(), report.end(), std::uint8_t{0});
  for (const FixedOutput& fixed : layout.fixed) layout.fields[fixed.field].write(report, fixed.value);
  for (std::size_t i = 0; i < layout.axes.size(); ++i) {
    const AxisOutput& axis = layout.axes[i];
    const double counts = axis.scale * efforts[i];
    const double held = std::isfinite(counts) ? std::clamp(counts, -axis.limit, axis.limit) : 0.0;
    layout.fields[axis.field].write(report, held);
  }
}

double count_from(double zero, double count, double span) {
  const double difference = count - zero;
  return span > 0 ? difference - span * std::round(difference / span) : difference;
}

}  // namespace tactor
