#include "framework/yaml/yaml_values.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "framework/core/check.hpp"
#include "framework/core/units.hpp"

namespace tactor {

namespace {

struct Noun {
  std::string_view unit;
  std::string_view noun;
};

constexpr std::array<Noun, 17> nouns{{{"1", "a number"},
                                      {"kg", "a mass (kg)"},
                                      {"m", "a length (m)"},
                                      {"m^2", "an area (m^2)"},
                                      {"s", "a time (s)"},
                                      {"Hz", "a rate (Hz)"},
                                      {"N", "a force (N)"},
                                      {"N m", "a torque (N m)"},
                                      {"N/m", "a stiffness (N/m)"},
                                      {"N s/m", "a damping (N s/m)"},
                                      {"N m/rad", "a rotational stiffness (N m/rad)"},
                                      {"N m s/rad", "a rotational damping (N m s/rad)"},
                                      {"kg m^2", "a moment of inertia (kg m^2)"},
                                      {"m/s", "a speed (m/s)"},
                                      {"m/s^2", "an acceleration (m/s^2)"},
                                      {"rad", "an angle (rad)"},
                                      {"rad/s", "a turning rate (rad/s)"}}};

std::string noun_of(std::string_view unit) {
  for (const Noun& noun : nouns) {
    if (noun.unit == unit) return std::string(noun.noun);
  }
  return "a value in " + std::string(unit);
}

std::string bounds_text(double min, double max, bool above_min) {
  const bool low = std::isfinite(min);
  const bool high = std::isfinite(max);
  if (low && high && !above_min) return " from " + number_text(min) + " to " + number_text(max);
  std::string text;
  if (low) text += (above_min ? " above " : " of at least ") + number_text(min);
  if (high) text += (low ? " and at most " : " of at most ") + number_text(max);
  return text;
}

// True where the text is a number alone, so that it is taken in the unit that is expected.
bool is_bare(std::string_view text) {
  const std::size_t last = text.find_last_not_of(" \t");
  return last != std::string_view::npos && text.find_first_not_of("+-.0123456789eE \t") == std::string_view::npos;
}

}  // namespace

bool is_decimal(std::string_view text) {
  if (text.starts_with('-')) text.remove_prefix(1);
  if (text.empty() || (text.size() > 1 && text[0] == '0')) return false;
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

std::string number_text(double value) {
  std::array<char, 40> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), result.ptr};
}

std::string list_of(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::optional<double> read_number(const Tree& tree, const std::string& path, const NumberRule& rule,
                                  Diagnostics& diagnostics) {
  const std::string expected = "expected " + noun_of(rule.unit);
  if (!tree.is_scalar()) {
    diagnostics.error(tree.place, path + ": " + expected + ", found " + describe(tree));
    return std::nullopt;
  }
  const std::variant<Quantity, std::string> parsed = parse_quantity(tree.text);
  if (const auto* problem = std::get_if<std::string>(&parsed)) {
    diagnostics.error(tree.place, path + ": " + expected + ", found " + describe(tree) + ": " + *problem);
    return std::nullopt;
  }
  const Quantity quantity = std::get<Quantity>(parsed);
  const std::optional<Unit> unit = parse_unit(rule.unit);
  TACTOR_DEMAND(unit && unit->scale == 1.0);
  if (!is_bare(tree.text) && !(quantity.dimension == unit->dimension)) {
    diagnostics.error(tree.place, path + ": " + expected + ", found " + describe(tree));
    return std::nullopt;
  }
  const double value = quantity.value_si;
  if (value < rule.min || value > rule.max || (rule.above_min && value <= rule.min)) {
    diagnostics.error(tree.place, path + ": " + expected + bounds_text(rule.min, rule.max, rule.above_min) +
                                      ", found " + describe(tree) + (rule.reason.empty() ? "" : "; ") +
                                      std::string(rule.reason));
    return std::nullopt;
  }
  if (unit->dimension == Dimension{.s = 1} && std::abs(value) > longest_time_s) {
    diagnostics.error(tree.place, path + ": " + expected + " of at most " + number_text(longest_time_s) + ", found " +
                                      describe(tree));
    return std::nullopt;
  }
  return value;
}

std::optional<std::int64_t> read_integer(const Tree& tree, const std::string& path, std::int64_t min, std::int64_t max,
                                         Diagnostics& diagnostics) {
  std::int64_t value = 0;
  bool good = tree.is_scalar() && !tree.quoted && is_decimal(tree.text);
  if (good) {
    const auto result = std::from_chars(tree.text.data(), tree.text.data() + tree.text.size(), value);
    good = result.ec == std::errc{} && value >= min && value <= max;
  }
  if (good) return value;
  std::string expected = ": expected a whole number from " + std::to_string(min) + " to " + std::to_string(max);
  if (tree.is_scalar() && tree.text.size() > 1 && tree.text[0] == '0') expected += " without a leading 0";
  diagnostics.error(tree.place, path + expected + ", found " + describe(tree));
  return std::nullopt;
}

std::optional<bool> read_boolean(const Tree& tree, const std::string& path, Diagnostics& diagnostics) {
  if (tree.is_scalar() && !tree.quoted && tree.text == "true") return true;
  if (tree.is_scalar() && !tree.quoted && tree.text == "false") return false;
  diagnostics.error(tree.place, path + ": expected true or false, found " + describe(tree));
  return std::nullopt;
}

std::optional<std::string> read_text(const Tree& tree, const std::string& path, Diagnostics& diagnostics) {
  if (tree.is_scalar()) return tree.text;
  diagnostics.error(tree.place, path + ": expected a text, found " + describe(tree));
  return std::nullopt;
}

std::optional<std::string> read_choice(const Tree& tree, const std::string& path,
                                       const std::vector<std::string>& choices, Diagnostics& diagnostics) {
  if (tree.is_scalar() && std::find(choices.begin(), choices.end(), tree.text) != choices.end()) return tree.text;
  diagnostics.error(tree.place, path + ": expected one of " + list_of(choices) + ", found " + describe(tree) +
                                    did_you_mean(tree.text, choices));
  return std::nullopt;
}

std::optional<std::vector<double>> read_numbers(const Tree& tree, const std::string& path, std::size_t size,
                                                const NumberRule& rule, Diagnostics& diagnostics) {
  if (!tree.is_sequence() || (size > 0 && tree.items.size() != size)) {
    const std::string many = size > 0 ? "a list of " + std::to_string(size) + ", each " : "a list, each ";
    const std::string found = tree.is_sequence() ? "a list of " + std::to_string(tree.items.size()) : describe(tree);
    diagnostics.error(tree.place, path + ": expected " + many + noun_of(rule.unit) + ", found " + found);
    return std::nullopt;
  }
  std::vector<double> values;
  bool good = true;
  for (std::size_t i = 0; i < tree.items.size(); ++i) {
    const auto value = read_number(tree.items[i], path + "[" + std::to_string(i) + "]", rule, diagnostics);
    good = good && value.has_value();
    values.push_back(value.value_or(0));
  }
  return good ? std::optional(std::move(values)) : std::nullopt;
}

std::optional<Duration> read_duration(const Tree& tree, const std::string& path, bool above_zero,
                                      Diagnostics& diagnostics) {
  const auto seconds = read_number(tree, path, {.unit = "s", .min = 0, .above_min = above_zero}, diagnostics);
  if (!seconds) return std::nullopt;
  const Duration duration = Duration::from_seconds(*seconds);
  if (above_zero && duration.ns == 0) {
    diagnostics.error(tree.place, path + ": expected a time of at least 1 ns, found " + describe(tree));
    return std::nullopt;
  }
  return duration;
}

bool expect_map(const Tree& tree, const std::string& path, std::string_view expected, Diagnostics& diagnostics) {
  if (tree.is_map()) return true;
  diagnostics.error(tree.place, path + ": expected " + std::string(expected) + ", found " + describe(tree));
  return false;
}

void check_keys(const Tree& map, const std::string& path, std::string_view what, const std::vector<std::string>& keys,
                Diagnostics& diagnostics) {
  for (const TreeEntry& entry : map.entries) {
    if (std::find(keys.begin(), keys.end(), entry.key) != keys.end()) continue;
    const std::string full = path.empty() ? entry.key : path + "." + entry.key;
    const std::string nearest = did_you_mean(entry.key, keys);
    diagnostics.error(entry.place, full + ": expected a " + std::string(what) + " (" + list_of(keys) +
                                       "), found an unknown one" + nearest);
  }
}

}  // namespace tactor
