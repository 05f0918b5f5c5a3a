// Unit expressions give the SI values worked out by hand, and what is no unit is refused.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "framework/core/units.hpp"

BOOST_AUTO_TEST_SUITE(units_test)

using namespace tactor;

namespace {

struct Case {
  const char* text;
  double value;
  const char* si;
};

void check_close(double value, double expected, const char* text) {
  BOOST_TEST(std::abs(value - expected) <= 4e-16 * std::abs(expected), text << ": " << value << " != " << expected);
}

}  // namespace

BOOST_AUTO_TEST_CASE(units_have_their_scale_and_dimension) {
  const std::vector<Case> cases{
      {"N/mm", 1000, "N/m"},
      {"N s/m", 1, "N s/m"},
      {"N*s/m", 1, "N s/m"},
      {"N\u00b7s/m", 1, "N s/m"},
      {"N s / mm", 1000, "N s/m"},
      {"kg m^2", 1, "kg m^2"},
      {"kg m\u00b2", 1, "kg m^2"},
      {"g cm^2", 1e-7, "kg m^2"},
      {"rad/s", 1, "1/s"},
      {"kHz", 1000, "1/s"},
      {"Hz", 1, "1/s"},
      {"deg", std::numbers::pi / 180, "1"},
      {"mrad", 1e-3, "1"},
      {"%", 0.01, "1"},
      {"1", 1, "1"},
      {"1/s", 1, "1/s"},
      {"m/s^2", 1, "m/s^2"},
      {"m s^-2", 1, "m/s^2"},
      {"m/s/s", 1, "m/s^2"},
      {"mm\u00b3", 1e-9, "m^3"},
      {"us", 1e-6, "s"},
      {"\u00b5s", 1e-6, "s"},
      {"\u03bcs", 1e-6, "s"},
      {"min", 60, "s"},
      {"h", 3600, "s"},
      {"kg", 1, "kg"},
      {"g", 1e-3, "kg"},
      {"mg", 1e-6, "kg"},
      {"Nm", 1, "N m"},
      {"mNm", 1e-3, "N m"},
      {"N m/rad", 1, "N m"},
      {"N m/deg", 180 / std::numbers::pi, "N m"},
      {"kPa", 1000, "Pa"},
      {"mA", 1e-3, "A"},
      {"V", 1, "V"},
      {"K", 1, "K"},
      {"N/m s", 1, "N s/m"},
  };
  for (const Case& c : cases) {
    const std::optional<Unit> unit = parse_unit(c.text);
    BOOST_REQUIRE_MESSAGE(unit.has_value(), c.text);
    check_close(unit->scale, c.value, c.text);
    BOOST_TEST(describe(unit->dimension) == c.si, c.text);
  }
}

BOOST_AUTO_TEST_CASE(what_is_no_unit_is_refused) {
  for (const char* text :
       {"",    " ",   "N/",  "/m", "N//m", "foo",  "kkg",   "kmin",  "mdeg",     "N^",   "N^x",   "m^99",
        "N-m", "N,m", "mm2", "2",  "11",   "N m)", "(N m)", "kN/m*", "\xff\xfe", "\xc2", "m^2^2", "m^1.5"}) {
    BOOST_TEST(!parse_unit(text).has_value(), text);
  }
}

BOOST_AUTO_TEST_CASE(quantities_become_si_values) {
  const std::vector<Case> cases{
      {"50 g", 0.05, "kg"},
      {"1kHz", 1000, "1/s"},
      {"0.8 N/mm", 800, "N/m"},
      {"1e-3 m", 1e-3, "m"},
      {"  -9.81 m/s^2 ", -9.81, "m/s^2"},
      {"+3 N", 3, "N"},
      {"5 %", 0.05, "1"},
      {"0.25", 0.25, "1"},
      {".5 s", 0.5, "s"},
      {"0", 0, "1"},
      {"10 deg/s", std::numbers::pi / 18, "1/s"},
      {"2.5E2mm", 0.25, "m"},
      {"3/s", 3, "1/s"},
      {"3 1/s", 3, "1/s"},
      {"0 N", 0, "N"},
  };
  for (const Case& c : cases) {
    const auto result = parse_quantity(c.text);
    BOOST_REQUIRE_MESSAGE(std::holds_alternative<Quantity>(result), c.text);
    const Quantity& q = std::get<Quantity>(result);
    check_close(q.value_si, c.value, c.text);
    BOOST_TEST(describe(q.dimension) == c.si, c.text);
  }
}

BOOST_AUTO_TEST_CASE(what_is_no_quantity_is_refused_with_a_reason) {
  for (const char* text :
       {"",       "  ",     "N",        "nan",  "inf",   "-inf",  "nan N",     "0x10",      "0x1p3 m", "010",
        "-007 N", "1 2",    "3 1",      "31 1", "1.2.3", "1,5 N", "5 N extra", "5 bananas", "--5",     "+-5",
        "1e400",  "1e-400", "1e308 km", "e5",   ".",     "- 5 N", "1_000",     "5 N;"}) {
    const auto result = parse_quantity(text);
    BOOST_TEST((std::holds_alternative<std::string>(result) && !std::get<std::string>(result).empty()), text);
  }
  BOOST_TEST(std::get<std::string>(parse_quantity("010 N")).find("octal") != std::string::npos);
  BOOST_TEST(std::get<std::string>(parse_quantity("5 bananas")) == "'bananas' in '5 bananas' is not a unit");
}

BOOST_AUTO_TEST_CASE(descriptions_read_back_as_the_same_dimension) {
  for (const Dimension d : {Dimension{}, Dimension{.m = 3, .kg = -1, .s = 2}, Dimension{.s = -1}, Dimension{.K = 2},
                            Dimension{.m = 2, .kg = 1, .s = -3, .A = -2}}) {
    const std::optional<Unit> unit = parse_unit(describe(d));
    BOOST_REQUIRE_MESSAGE(unit.has_value(), describe(d));
    BOOST_TEST((unit->dimension == d), describe(d));
    BOOST_TEST(unit->scale == 1.0);
  }
}

BOOST_AUTO_TEST_SUITE_END()
