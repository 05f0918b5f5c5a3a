#include "framework/core/units.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

#include "framework/core/text.hpp"

namespace tactor {

namespace {

struct NamedUnit {
  std::string_view name;
  double scale;
  Dimension dimension;
  bool prefixable;
};

constexpr Dimension plain{};
constexpr Dimension newton{.m = 1, .kg = 1, .s = -2};
constexpr Dimension joule{.m = 2, .kg = 1, .s = -2};

constexpr std::array<NamedUnit, 17> unit_names{{
    {"m", 1, {.m = 1}, true},
    {"g", 1e-3, {.kg = 1}, true},
    {"s", 1, {.s = 1}, true},
    {"Hz", 1, {.s = -1}, true},
    {"N", 1, newton, true},
    {"Pa", 1, {.m = -1, .kg = 1, .s = -2}, true},
    {"J", 1, joule, true},
    {"W", 1, {.m = 2, .kg = 1, .s = -3}, true},
    {"V", 1, {.m = 2, .kg = 1, .s = -3, .A = -1}, true},
    {"A", 1, {.A = 1}, true},
    {"K", 1, {.K = 1}, true},
    {"Nm", 1, joule, true},
    {"rad", 1, plain, true},
    {"deg", std::numbers::pi / 180, plain, false},
    {"min", 60, {.s = 1}, false},
    {"h", 3600, {.s = 1}, false},
    {"%", 0.01, plain, false},
}};

struct Prefix {
  std::string_view text;
  double scale;
};

// The micro sign and the Greek letter look the same and are two code points.
constexpr std::array<Prefix, 8> prefixes{
    {{"n", 1e-9}, {"u", 1e-6}, {"\u00b5", 1e-6}, {"\u03bc", 1e-6}, {"m", 1e-3}, {"c", 1e-2}, {"k", 1e3}, {"M", 1e6}}};

constexpr std::string_view middle_dot = "\u00b7";

std::optional<Unit> find_unit(std::string_view name) {
  // Mass is named from the gram but its SI unit is the kilogram, whose scale must be exactly 1.
  if (name == "kg") return Unit{1, {.kg = 1}};
  if (name == "1") return Unit{};
  for (const NamedUnit& unit : unit_names) {
    if (unit.name == name) return Unit{unit.scale, unit.dimension};
  }
  for (const Prefix& prefix : prefixes) {
    if (!name.starts_with(prefix.text)) continue;
    for (const NamedUnit& unit : unit_names) {
      if (unit.prefixable && unit.name == name.substr(prefix.text.size())) {
        return Unit{prefix.scale * unit.scale, unit.dimension};
      }
    }
  }
  return std::nullopt;
}

bool take(std::string_view& text, std::string_view token) {
  if (!text.starts_with(token)) return false;
  text.remove_prefix(token.size());
  return true;
}

void skip_spaces(std::string_view& text) {
  while (take(text, " ") || take(text, "\t")) {
  }
}

/// The characters of a unit's name at the front of `text`, taken off it.
std::string_view take_name(std::string_view& text) {
  const std::string_view whole = text;
  if (take(text, "1") || take(text, "%")) return whole.substr(0, 1);
  while (!text.empty()) {
    const char c = text.front();
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (letter) {
      text.remove_prefix(1);
    } else if (!take(text, "\u00b5") && !take(text, "\u03bc")) {
      break;
    }
  }
  return whole.substr(0, whole.size() - text.size());
}

/// The largest power of a base unit, in a factor and in the whole unit, so that what `describe` says can be read back.
constexpr int max_power = 9;

/// The power at the front of `text`, taken off it; 1 where there is none, nothing where it is broken.
std::optional<int> take_power(std::string_view& text) {
  if (take(text, "\u00b2")) return 2;
  if (take(text, "\u00b3")) return 3;
  if (!take(text, "^")) return 1;
  int power = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), power);
  if (error != std::errc{} || power < -max_power || power > max_power) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return power;
}

bool add_power(std::int8_t& exponent, std::int8_t of_factor, int power) {
  const int sum = exponent + of_factor * power;
  if (std::abs(sum) > max_power) return false;
  exponent = static_cast<std::int8_t>(sum);
  return true;
}

bool multiply(Unit& unit, const Unit& factor, int power) {
  // Divide by the whole power, so that 1/mm is exactly 1000 and not a rounded product of reciprocals.
  const double scale = std::pow(factor.scale, std::abs(power));
  unit.scale = power < 0 ? unit.scale / scale : unit.scale * scale;
  const Dimension& d = factor.dimension;
  return add_power(unit.dimension.m, d.m, power) && add_power(unit.dimension.kg, d.kg, power) &&
         add_power(unit.dimension.s, d.s, power) && add_power(unit.dimension.A, d.A, power) &&
         add_power(unit.dimension.K, d.K, power);
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

std::string quoted(std::string_view text) {
  return std::string(1, '\'').append(text).append(1, '\'');
}

}  // namespace

std::optional<Unit> parse_unit(std::string_view text) {
  text = trimmed(text);
  Unit unit;
  bool divides = false;
  while (true) {
    const std::optional<Unit> factor = find_unit(take_name(text));
    if (!factor) return std::nullopt;
    const std::optional<int> power = take_power(text);
    if (!power || !multiply(unit, *factor, divides ? -*power : *power)) return std::nullopt;
    if (text.empty()) return std::isfinite(unit.scale) && unit.scale > 0 ? std::optional(unit) : std::nullopt;
    const std::size_t before = text.size();
    skip_spaces(text);
    divides = take(text, "/");
    if (!divides && !take(text, "*") && !take(text, middle_dot) && text.size() == before) return std::nullopt;
    skip_spaces(text);
  }
}

std::variant<Quantity, std::string> parse_quantity(std::string_view text) {
  const std::string_view whole = trimmed(text);
  if (whole.empty()) return "a number with a unit is expected, found nothing";
  std::string_view rest = whole;
  const bool negative = take(rest, "-");
  if (!negative) take(rest, "+");
  // from_chars would take nan and inf here, and a second sign.
  const bool starts = !rest.empty() && (is_digit(rest[0]) || (rest[0] == '.' && rest.size() > 1 && is_digit(rest[1])));
  if (!starts) return quoted(whole) + " does not start with a number";
  if (rest.size() > 1 && rest[0] == '0' && is_digit(rest[1])) {
    return quoted(whole) + " is ambiguous: a leading 0 means octal in some dialects; write the number without it";
  }
  double value = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
  if (error != std::errc{}) return quoted(whole) + " is too large for a double";
  rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  if (negative) value = -value;
  const std::string_view unit_text = trimmed(rest);
  if (unit_text.empty()) return Quantity{value, plain};
  // `3/s` is three per second; `3 1` is a stray second number, not a unit.
  const std::optional<Unit> unit =
      unit_text == "1" || is_digit(rest.front())
          ? std::nullopt
          : parse_unit(unit_text.front() == '/' ? std::string(1, '1').append(unit_text) : std::string(unit_text));
  if (!unit) return quoted(unit_text) + " in " + quoted(whole) + " is not a unit";
  const double si = value * unit->scale;
  if (!std::isfinite(si)) return quoted(whole) + " is too large for a double";
  return Quantity{si, unit->dimension};
}

std::string describe(Dimension dimension) {
  // Combinations with a name of their own, in the spelling that haptics uses.
  constexpr std::array<std::string_view, 16> familiar{"1", "N",  "N/m", "N s/m", "N m",    "N m s",  "Pa",  "W",
                                                      "V", "kg", "m/s", "m/s^2", "kg m^2", "kg/m^3", "N/A", "N^2"};
  for (const std::string_view text : familiar) {
    if (parse_unit(text)->dimension == dimension) return std::string(text);
  }
  struct Base {
    std::string_view name;
    int power;
  };
  const std::array<Base, 5> bases{
      {{"kg", dimension.kg}, {"m", dimension.m}, {"s", dimension.s}, {"A", dimension.A}, {"K", dimension.K}}};
  std::string over;
  std::string under;
  for (const Base& base : bases) {
    if (base.power == 0) continue;
    const int power = std::abs(base.power);
    std::string& side = base.power > 0 ? over : under;
    if (base.power < 0) {
      side += '/';
    } else if (!side.empty()) {
      side += ' ';
    }
    side += base.name;
    if (power != 1) {
      side += '^';
      side += std::to_string(power);
    }
  }
  return (over.empty() ? "1" : over) + under;
}

}  // namespace tactor
