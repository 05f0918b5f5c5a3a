// At zeros, infinities, values that are no number, and at the ends of the range, framework/math does what the C library
// does.
#include <dlfcn.h>

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <complex>
#include <limits>
#include <string>
#include <vector>

BOOST_AUTO_TEST_SUITE(special_values_test)

namespace {

/// A function of the C library itself, whatever the name means in this program.
template <typename F>
F* of_the_c_library(const char* name) {
  static void* const library = dlopen("libm.so.6", RTLD_NOW | RTLD_LOCAL);
  BOOST_REQUIRE(library != nullptr);
  void* const found = dlsym(library, name);
  BOOST_REQUIRE_MESSAGE(found != nullptr, name);
  return reinterpret_cast<F*>(found);
}

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
constexpr double smallest = std::numeric_limits<double>::denorm_min();
constexpr double largest = std::numeric_limits<double>::max();

const std::vector<double>& special_values() {
  static const std::vector<double> values{0,
                                          -0.0,
                                          1,
                                          -1,
                                          0.5,
                                          -0.5,
                                          2,
                                          -2,
                                          3,
                                          -3,
                                          2.5,
                                          -2.5,
                                          1e-17,
                                          1e-8,
                                          37,
                                          -37,
                                          1e22,
                                          infinity,
                                          1e300,
                                          -1e300,
                                          largest,
                                          -largest,
                                          smallest,
                                          -smallest,
                                          1e-310,
                                          -1e-310,
                                          2.2250738585072014e-308,
                                          -infinity,
                                          no_number,
                                          709.5,
                                          710.2,
                                          -744,
                                          -745.2,
                                          1023.9,
                                          1024,
                                          -1074,
                                          -1075,
                                          170.5,
                                          171.7,
                                          308.3,
                                          -323.5,
                                          -324,
                                          4503599627370496,
                                          9007199254740991,
                                          -9007199254740991,
                                          1 - 1e-16};
  return values;
}

/// The same kind of value with the same sign; numbers within 4 ulp of each other.
bool agree(double a, double b) {
  if (std::isnan(a) || std::isnan(b)) return std::isnan(a) && std::isnan(b);
  if (std::signbit(a) != std::signbit(b)) return false;
  if (a == b) return true;
  if (std::isinf(a) || std::isinf(b)) return false;
  return std::abs(a - b) <= 1e-15 * std::abs(b) + 2 * smallest;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(special_values_of)

BOOST_AUTO_TEST_CASE(functions_of_one_number) {
  using F = double(double);
  const std::vector<std::pair<const char*, F*>> functions{
      {"sin", std::sin},      {"cos", std::cos},     {"tan", std::tan},     {"asin", std::asin},
      {"acos", std::acos},    {"atan", std::atan},   {"exp", std::exp},     {"exp2", std::exp2},
      {"exp10", ::exp10},     {"expm1", std::expm1}, {"log", std::log},     {"log2", std::log2},
      {"log10", std::log10},  {"log1p", std::log1p}, {"cbrt", std::cbrt},   {"sinh", std::sinh},
      {"cosh", std::cosh},    {"tanh", std::tanh},   {"asinh", std::asinh}, {"acosh", std::acosh},
      {"atanh", std::atanh},  {"erf", std::erf},     {"erfc", std::erfc},   {"tgamma", std::tgamma},
      {"lgamma", std::lgamma}};
  for (const auto& [name, ours] : functions) {
    F* const other = of_the_c_library<F>(name);
    BOOST_TEST((other != ours), name << " is that of the C library");
    for (const double x : special_values()) {
      BOOST_TEST(agree(ours(x), other(x)), name << "(" << x << ") is " << ours(x) << ", not " << other(x));
    }
  }
}

BOOST_AUTO_TEST_CASE(functions_of_two_numbers) {
  using F = double(double, double);
  const std::vector<std::pair<const char*, F*>> functions{{"pow", std::pow}, {"atan2", std::atan2}, {"hypot", ::hypot}};
  for (const auto& [name, ours] : functions) {
    F* const other = of_the_c_library<F>(name);
    BOOST_TEST((other != ours), name << " is that of the C library");
    for (const double x : special_values()) {
      for (const double y : special_values()) {
        BOOST_TEST(agree(ours(x, y), other(x, y)),
                   name << "(" << x << ", " << y << ") is " << ours(x, y) << ", not " << other(x, y));
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(complex_functions) {
  __extension__ using C = __complex__ double;
  auto* const exponential = of_the_c_library<C(C)>("cexp");
  auto* const root = of_the_c_library<C(C)>("csqrt");
  const auto check = [](const char* name, std::complex<double> z, std::complex<double> ours, C other) {
    const bool right = agree(ours.real(), __real__ other) && agree(ours.imag(), __imag__ other);
    BOOST_TEST(right, name << z << " is " << ours << ", not " << std::complex<double>(other));
  };
  for (const double x : special_values()) {
    for (const double y : special_values()) {
      const std::complex<double> z(x, y);
      check("csqrt", z, std::sqrt(z), root(z.__rep()));
      BOOST_TEST(agree(std::abs(z), std::hypot(x, y)));
      BOOST_TEST(agree(std::arg(z), std::atan2(y, x)));
      // C leaves the signs of these two zeros open.
      if (x == -infinity && !std::isfinite(y)) {
        BOOST_TEST((std::exp(z) == std::complex<double>(0, 0)));
        continue;
      }
      check("cexp", z, std::exp(z), exponential(z.__rep()));
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE_END()
