// Units as texts: `N/mm` or `50 g` to SI values with their dimension. Independent of the locale.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace tactor {

/// The exponents of the SI base units a quantity is made of. Angles are plain numbers.
struct Dimension {
  std::int8_t m = 0, kg = 0, s = 0, A = 0, K = 0;
  constexpr bool operator==(const Dimension&) const = default;
};

/// A unit: one of it is `scale` SI units of `dimension`.
struct Unit {
  double scale = 1;
  Dimension dimension;
};

/// A value in SI units of `dimension`.
struct Quantity {
  double value_si = 0;
  Dimension dimension;
};

/// The unit that `text` names, or nothing where it names none.
///
/// Factors stand side by side with a space, `*` or `·`, or after a `/`, read from left to right (`N s/m`, `N*s/m`; each
/// `/` divides by the one factor after it). A factor is a name with an optional whole power (`m^2`, `s^-1`, `m²`, `m³`)
/// from -9 to 9; no base unit of the whole may have a greater one. Names: m g s Hz N Pa J W V A K Nm rad, each with an
/// optional prefix n u µ m c k M; deg min h % and 1. `rad` is 1, `deg` pi/180, `%` 0.01 of the plain number.
std::optional<Unit> parse_unit(std::string_view text);

/// The value of a text such as `50 g`, `1kHz`, `0.8 N/mm` or `0.3` (a plain number), or what is wrong with it.
///
/// The number is decimal with an optional exponent. Refused are hexadecimal numbers, nan, inf, numbers beyond a double,
/// `010` (octal in some dialects, ten in others) and anything after the unit.
std::variant<Quantity, std::string> parse_quantity(std::string_view text);

/// The SI unit of a dimension as a readable text that `parse_unit` takes: `N/m`, `kg m^2`, `1/s`, `1`.
std::string describe(Dimension dimension);

}  // namespace tactor
