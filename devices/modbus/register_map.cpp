#include "devices/modbus/register_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace tactor::modbus {

namespace {

std::uint16_t swapped(std::uint16_t word) {
  return static_cast<std::uint16_t>((word << 8) | (word >> 8));
}

std::uint16_t field_mask(const RegisterInfo& info) {
  return static_cast<std::uint16_t>(((std::uint32_t{1} << info.bits) - 1) << info.low_bit);
}

/// Smallest and largest count.
std::pair<double, double> range(const RegisterInfo& info) {
  if (info.bits > 0) return {0, static_cast<double>((std::uint32_t{1} << info.bits) - 1)};
  switch (info.type) {
    case RegisterType::int16:
      return {std::numeric_limits<std::int16_t>::min(), std::numeric_limits<std::int16_t>::max()};
    case RegisterType::uint16:
      return {0, std::numeric_limits<std::uint16_t>::max()};
    case RegisterType::int32:
      return {std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max()};
    case RegisterType::uint32:
      return {0, std::numeric_limits<std::uint32_t>::max()};
    case RegisterType::float32:
      break;
  }
  return {-std::numeric_limits<float>::max(), std::numeric_limits<float>::max()};
}

std::uint32_t raw_of(const RegisterInfo& info, const std::uint16_t* words) {
  const auto word = [&](int i) { return info.bytes == Order::low_first ? swapped(words[i]) : words[i]; };
  if (info.width() == 1) return word(0);
  const bool low_first = info.words == Order::low_first;
  const std::uint32_t high = word(low_first ? 1 : 0), low = word(low_first ? 0 : 1);
  return (high << 16) | low;
}

void put_raw(const RegisterInfo& info, std::uint32_t raw, std::uint16_t* words) {
  const auto put = [&](int i, std::uint32_t value) {
    const auto word = static_cast<std::uint16_t>(value);
    words[i] = info.bytes == Order::low_first ? swapped(word) : word;
  };
  if (info.width() == 1) {
    put(0, raw);
    return;
  }
  const bool low_first = info.words == Order::low_first;
  put(low_first ? 1 : 0, raw >> 16);
  put(low_first ? 0 : 1, raw & 0xffffU);
}

}  // namespace

double decode(const RegisterInfo& info, const std::uint16_t* words) {
  const std::uint32_t raw = raw_of(info, words);
  if (info.bits > 0) {
    return info.scale * static_cast<double>((raw & field_mask(info)) >> info.low_bit);
  }
  switch (info.type) {
    case RegisterType::int16:
      return info.scale * static_cast<std::int16_t>(static_cast<std::uint16_t>(raw));
    case RegisterType::int32:
      return info.scale * static_cast<std::int32_t>(raw);
    case RegisterType::float32:
      return info.scale * static_cast<double>(std::bit_cast<float>(raw));
    case RegisterType::uint16:
    case RegisterType::uint32:
      break;
  }
  return info.scale * static_cast<double>(raw);
}

void encode(const RegisterInfo& info, double value, std::uint16_t* words) {
  const auto [least, most] = range(info);
  double count = value / info.scale;
  if (std::isnan(count)) count = 0;
  count = std::clamp(count, least, most);
  if (info.type == RegisterType::float32) {
    put_raw(info, std::bit_cast<std::uint32_t>(static_cast<float>(count)), words);
    return;
  }
  const auto whole = static_cast<std::uint32_t>(std::llround(count));
  if (info.bits == 0) {
    put_raw(info, whole, words);
    return;
  }
  const std::uint32_t others = raw_of(info, words) & ~std::uint32_t{field_mask(info)};
  put_raw(info, others | (whole << info.low_bit), words);
}

std::string to_string(RegisterType type) {
  switch (type) {
    case RegisterType::int16:
      return "int16";
    case RegisterType::uint16:
      return "uint16";
    case RegisterType::int32:
      return "int32";
    case RegisterType::uint32:
      return "uint32";
    case RegisterType::float32:
      break;
  }
  return "float32";
}

}  // namespace tactor::modbus
