#include "nodes/experiment/design.hpp"

#include <cstdint>

#include "framework/core/random.hpp"

namespace tactor {

namespace {

constexpr std::size_t whole_digits = 16;
constexpr std::size_t part_digits = 2;

/// The last `digits` hexadecimal digits of a number.
std::string hexadecimal(std::uint64_t number, std::size_t digits) {
  std::string text(digits, '0');
  for (std::size_t i = digits; i-- > 0; number >>= 4U) text[i] = "0123456789abcdef"[number & 15U];
  return text;
}

}  // namespace

std::string StudyDesign::digest() const {
  std::string all, parts;
  for (const auto& [name, text] : parts_) {
    // The lengths keep `ab`, `c` apart from `a`, `bc`.
    all += name + ":" + std::to_string(text.size()) + ":" + text + "\n";
    parts += hexadecimal(derive_seed(0, name + "=" + text), part_digits);
  }
  return hexadecimal(derive_seed(0, all), whole_digits) + parts;
}

std::string StudyDesign::differing(const std::string& other) const {
  const std::string own = digest();
  if (own == other) return {};
  if (own.size() != other.size()) return "its parts";
  std::string names;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const std::size_t at = whole_digits + part_digits * i;
    if (own.compare(at, part_digits, other, at, part_digits) == 0) continue;
    names += (names.empty() ? "" : ", ") + parts_[i].first;
  }
  // Two digits of a part may be equal by chance, once in 256 times.
  return names.empty() ? "one of its parts" : names;
}

}  // namespace tactor
