// Reads checked values out of a tree: numbers with units, whole numbers, names, lists. Each tells what it expected.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/time.hpp"
#include "framework/yaml/yaml_tree.hpp"

namespace tactor {

/// What a number must be.
struct NumberRule {
  std::string unit = "1";  ///< SI; a bare number is in this unit
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool above_min = false;        ///< true: larger than `min`
  std::string_view reason = {};  ///< for the bounds, if they need one
};

/// All of these return nothing after having written what was expected and what was found; `path` names the value
/// (`scene.bodies.tool.mass`).
std::optional<double> read_number(const Tree& tree, const std::string& path, const NumberRule& rule,
                                  Diagnostics& diagnostics);
std::optional<std::int64_t> read_integer(const Tree& tree, const std::string& path, std::int64_t min, std::int64_t max,
                                         Diagnostics& diagnostics);
std::optional<bool> read_boolean(const Tree& tree, const std::string& path, Diagnostics& diagnostics);
std::optional<std::string> read_text(const Tree& tree, const std::string& path, Diagnostics& diagnostics);
std::optional<std::string> read_choice(const Tree& tree, const std::string& path,
                                       const std::vector<std::string>& choices, Diagnostics& diagnostics);
/// `size` 0: of any length.
std::optional<std::vector<double>> read_numbers(const Tree& tree, const std::string& path, std::size_t size,
                                                const NumberRule& rule, Diagnostics& diagnostics);
/// A time in s as whole nanoseconds, not below zero.
std::optional<Duration> read_duration(const Tree& tree, const std::string& path, bool above_zero,
                                      Diagnostics& diagnostics);
/// Times beyond this have no meaning in a run, and whole nanoseconds hold them with room to spare.
inline constexpr double longest_time_s = 1e9;

/// False, with an error, where the tree is no map.
bool expect_map(const Tree& tree, const std::string& path, std::string_view expected, Diagnostics& diagnostics);
/// An error for every key of the map that is not in `keys`; `what` names a key (`key`, `parameter of coupling.static`).
void check_keys(const Tree& map, const std::string& path, std::string_view what, const std::vector<std::string>& keys,
                Diagnostics& diagnostics);
/// True where the text is a whole number in decimal digits without a leading 0.
bool is_decimal(std::string_view text);
/// `a, b and c` as `a, b, c`.
std::string list_of(const std::vector<std::string>& names);
/// The shortest decimal text that reads back to the same double.
std::string number_text(double value);

}  // namespace tactor
