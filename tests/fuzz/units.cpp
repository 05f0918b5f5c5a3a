// Texts of quantities and units. A quantity that is accepted is finite, and its unit's text is read back as the same.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <variant>

#include "framework/core/units.hpp"
#include "require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactor;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  static_cast<void>(parse_unit(text));
  const auto result = parse_quantity(text);
  if (const auto* quantity = std::get_if<Quantity>(&result)) {
    fuzz::require(std::isfinite(quantity->value_si), "the value is finite");
    const auto unit = parse_unit(describe(quantity->dimension));
    fuzz::require(unit.has_value(), "the text of a dimension is a unit");
    fuzz::require(unit->dimension == quantity->dimension && unit->scale == 1, "it is the SI unit of that dimension");
  } else {
    fuzz::require(!std::get<std::string>(result).empty(), "a refusal says why");
  }
  return 0;
}
