// The functions that framework/math puts in place of the C library's are right to the last digit, by GNU MPFR.
#include <mpfr.h>

#include <algorithm>
#include <array>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <sstream>
#include <string>

BOOST_AUTO_TEST_SUITE(portable_math_test)

namespace {

/// Points to try, the same on every machine.
class Points {
 public:
  explicit Points(std::uint64_t seed) : bits_(seed) {}
  double uniform(double from, double to) { return from + (to - from) * static_cast<double>(bits_() >> 11) * 0x1p-53; }
  int whole(int from, int to) { return from + static_cast<int>(bits_() % static_cast<std::uint64_t>(to - from + 1)); }
  double sign() { return (bits_() & 1) != 0 ? 1 : -1; }
  /// 2^from to 2^(to + 1), each exponent as likely as the others.
  double exponents(int from, int to) { return std::ldexp(uniform(1, 2), whole(from, to)); }

 private:
  std::mt19937_64 bits_;
};

/// A number of 140 bits.
class Exact {
 public:
  Exact() { mpfr_init2(value, 140); }
  Exact(const Exact&) = delete;
  Exact& operator=(const Exact&) = delete;
  ~Exact() { mpfr_clear(value); }
  mpfr_t value;
};

/// |ours - exact| in units of the last place of the exact value, which is not smaller than 2^smallest. Zero where both
/// are infinite or not numbers; infinite where one is.
double ulps(double ours, const Exact& exact, int digits = 53, int smallest = -1074) {
  const double nearest = mpfr_get_d(exact.value, MPFR_RNDN);
  if (std::isnan(nearest) || std::isnan(ours)) return std::isnan(nearest) == std::isnan(ours) ? 0 : INFINITY;
  if (nearest == ours) return nearest == 0 || std::isinf(nearest) ? 0 : 0.5;
  if (std::isinf(nearest) || std::isinf(ours)) return INFINITY;
  Exact difference;
  mpfr_sub_d(difference.value, exact.value, ours, MPFR_RNDN);
  const int place = nearest == 0 ? smallest : std::max(std::ilogb(nearest) - (digits - 1), smallest);
  mpfr_mul_2si(difference.value, difference.value, -place, MPFR_RNDN);
  return std::abs(mpfr_get_d(difference.value, MPFR_RNDN));
}

/// The largest error of a function over some points.
struct Worst {
  double error = 0;
  std::string where = "every point is the nearest number";

  void count(double found, double ours, double x, double y = NAN) {
    if (found <= error) return;
    error = found;
    std::ostringstream text;
    text.precision(17);
    text << x;
    if (!std::isnan(y)) text << ", " << y;
    text << " gives " << ours;
    where = text.str();
  }
};

void judge(const std::string& name, const Worst& worst, double bound) {
  BOOST_TEST_MESSAGE(name << ": at most " << worst.error << " ulp; " << worst.where);
  BOOST_TEST(worst.error <= bound, name << ": " << worst.error << " ulp: " << worst.where);
}

using Function = double (*)(double);
using MpfrFunction = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t);
using Function2 = double (*)(double, double);
using MpfrFunction2 = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_srcptr, mpfr_rnd_t);

constexpr int many = 20'000;

void compare(const std::string& name, Function ours, MpfrFunction exactly, const std::function<double(Points&)>& draw,
             double bound = 1) {
  Points points(1);
  Worst worst;
  Exact x;
  Exact exact;
  for (int i = 0; i < many; ++i) {
    const double at = draw(points);
    mpfr_set_d(x.value, at, MPFR_RNDN);
    exactly(exact.value, x.value, MPFR_RNDN);
    worst.count(ulps(ours(at), exact), ours(at), at);
  }
  judge(name, worst, bound);
}

void compare(const std::string& name, Function2 ours, MpfrFunction2 exactly,
             const std::function<std::array<double, 2>(Points&)>& draw, double bound = 1) {
  Points points(1);
  Worst worst;
  Exact x;
  Exact y;
  Exact exact;
  for (int i = 0; i < many; ++i) {
    const auto [at_x, at_y] = draw(points);
    mpfr_set_d(x.value, at_x, MPFR_RNDN);
    mpfr_set_d(y.value, at_y, MPFR_RNDN);
    exactly(exact.value, x.value, y.value, MPFR_RNDN);
    worst.count(ulps(ours(at_x, at_y), exact), ours(at_x, at_y), at_x, at_y);
  }
  judge(name, worst, bound);
}

std::function<double(Points&)> uniform(double from, double to) {
  return [=](Points& p) { return p.uniform(from, to); };
}

double any_number(Points& p) {
  return p.sign() * p.exponents(-1074, 1023);
}

double positive_number(Points& p) {
  return p.exponents(-1074, 1023);
}

double near_one(Points& p) {
  return 1 + p.sign() * p.exponents(-53, -2);
}

}  // namespace

BOOST_AUTO_TEST_SUITE(against_mpfr)

BOOST_AUTO_TEST_CASE(sines_cosines_and_tangents) {
  const auto near_multiples = [](Points& p) {
    return p.whole(-100'000, 100'000) * (std::numbers::pi / 2) * (1 + p.sign() * p.exponents(-54, -10));
  };
  const std::array<std::pair<const char*, std::function<double(Points&)>>, 4> ranges{{
      {"of any number", any_number},
      {"within a turn", uniform(-6.3, 6.3)},
      {"of 1e6 turns", uniform(-6.3e6, 6.3e6)},
      {"near multiples of pi / 2", near_multiples},
  }};
  for (const auto& [range, draw] : ranges) {
    compare("sin " + std::string(range), std::sin, mpfr_sin, draw);
    compare("cos " + std::string(range), std::cos, mpfr_cos, draw);
    compare("tan " + std::string(range), std::tan, mpfr_tan, draw);
  }
}

BOOST_AUTO_TEST_CASE(a_joined_sine_and_cosine_is_both) {
  Points points(2);
  for (int i = 0; i < many; ++i) {
    const double x = i % 2 == 0 ? any_number(points) : points.uniform(-7, 7);
    double sine = 0;
    double cosine = 0;
    ::sincos(x, &sine, &cosine);
    BOOST_REQUIRE(sine == std::sin(x));
    BOOST_REQUIRE(cosine == std::cos(x));
  }
}

BOOST_AUTO_TEST_CASE(inverse_functions_of_angles) {
  compare("asin of any number", std::asin, mpfr_asin, [](Points& p) { return p.sign() * p.exponents(-1074, -1); });
  compare("asin within -1 to 1", std::asin, mpfr_asin, uniform(-1, 1));
  compare("asin near 1", std::asin, mpfr_asin, near_one);
  compare("acos of any number", std::acos, mpfr_acos, [](Points& p) { return p.sign() * p.exponents(-1074, -1); });
  compare("acos within -1 to 1", std::acos, mpfr_acos, uniform(-1, 1));
  compare("acos near 1", std::acos, mpfr_acos, near_one);
  compare("atan of any number", std::atan, mpfr_atan, any_number);
  compare("atan within -8 to 8", std::atan, mpfr_atan, uniform(-8, 8));
  compare("atan near 1", std::atan, mpfr_atan, near_one);
  compare("atan2 of any numbers", std::atan2, mpfr_atan2, [](Points& p) {
    return std::array{any_number(p), any_number(p)};
  });
  compare("atan2 within 2", std::atan2, mpfr_atan2, [](Points& p) {
    return std::array{p.uniform(-2, 2), p.uniform(-2, 2)};
  });
  compare("atan2 of numbers of a size", std::atan2, mpfr_atan2, [](Points& p) {
    const double x = any_number(p);
    return std::array{p.sign() * x * p.exponents(-60, 60), x};
  });
}

BOOST_AUTO_TEST_CASE(exponential_functions) {
  const auto any_exponent = [](Points& p) { return p.sign() * p.exponents(-1074, 10); };
  compare("exp of any number", std::exp, mpfr_exp, any_exponent);
  compare("exp within -8 to 8", std::exp, mpfr_exp, uniform(-8, 8));
  compare("exp below the normal numbers", std::exp, mpfr_exp, uniform(-746, -707));
  compare("exp next to overflow", std::exp, mpfr_exp, uniform(708.5, 709.8));
  compare("exp at overflow", std::exp, mpfr_exp, uniform(709.7827128, 709.7827129));
  compare("exp2 of any number", std::exp2, mpfr_exp2, any_exponent);
  compare("exp2 within -8 to 8", std::exp2, mpfr_exp2, uniform(-8, 8));
  compare("exp2 below the normal numbers", std::exp2, mpfr_exp2, uniform(-1076, -1020));
  compare("exp2 next to overflow", std::exp2, mpfr_exp2, uniform(1023, 1024.1));
  compare("exp10 of any number", ::exp10, mpfr_exp10, any_exponent);
  compare("exp10 within -40 to 40", ::exp10, mpfr_exp10, uniform(-40, 40));
  compare("exp10 below the normal numbers", ::exp10, mpfr_exp10, uniform(-325, -306));
  compare("exp10 next to overflow", ::exp10, mpfr_exp10, uniform(308.2, 308.3));
  compare("expm1 of any number", std::expm1, mpfr_expm1, any_exponent);
  compare("expm1 within -40 to 40", std::expm1, mpfr_expm1, uniform(-40, 40));
  compare("expm1 next to overflow", std::expm1, mpfr_expm1, uniform(709.7, 709.8));
}

BOOST_AUTO_TEST_CASE(logarithms) {
  const std::array<std::pair<const char*, std::function<double(Points&)>>, 3> ranges{{
      {"of any number", positive_number},
      {"within 0 to 8", uniform(0, 8)},
      {"near 1", near_one},
  }};
  for (const auto& [range, draw] : ranges) {
    compare("log " + std::string(range), std::log, mpfr_log, draw);
    compare("log2 " + std::string(range), std::log2, mpfr_log2, draw);
    compare("log10 " + std::string(range), std::log10, mpfr_log10, draw);
  }
  compare("log1p of any number", std::log1p, mpfr_log1p, any_number);
  compare("log1p of any positive number", std::log1p, mpfr_log1p, positive_number);
  compare("log1p within -1 to 1", std::log1p, mpfr_log1p, uniform(-1, 1));
  compare("log1p near -1", std::log1p, mpfr_log1p, [](Points& p) { return -1 + p.exponents(-53, -1); });
}

BOOST_AUTO_TEST_CASE(powers_and_roots) {
  const auto power_of_two = [](double from, double to) {
    return [=](Points& p) {
      const double x = p.uniform(0, 1e3);
      return std::array{x, p.uniform(from, to) / std::log2(x)};
    };
  };
  compare("pow of any numbers", std::pow, mpfr_pow, [](Points& p) {
    return std::array{positive_number(p), p.sign() * p.exponents(-60, 10)};
  });
  compare("pow within 10, 20", std::pow, mpfr_pow, [](Points& p) {
    return std::array{p.uniform(0, 10), p.uniform(-20, 20)};
  });
  compare("pow of numbers near 1", std::pow, mpfr_pow, [](Points& p) {
    return std::array{near_one(p), p.sign() * p.exponents(0, 62)};
  });
  compare("pow with whole exponents", std::pow, mpfr_pow, [](Points& p) {
    return std::array<double, 2>{p.uniform(-30, 30), static_cast<double>(p.whole(-30, 30))};
  });
  compare("pow with halves", std::pow, mpfr_pow, [](Points& p) {
    return std::array{positive_number(p), p.whole(-5, 5) * 0.5};
  });
  compare("pow below the normal numbers", std::pow, mpfr_pow, power_of_two(-1076, -1020));
  compare("pow next to overflow", std::pow, mpfr_pow, power_of_two(1023, 1023.9999));
  compare("pow at overflow", std::pow, mpfr_pow, power_of_two(1023.999997, 1024.0000001), 1.2);
  compare("cbrt of any number", std::cbrt, mpfr_cbrt, any_number);
  compare("cbrt within -8 to 8", std::cbrt, mpfr_cbrt, uniform(-8, 8));
  const auto two_of_a_size = [](int from, int to) {
    return [=](Points& p) { return std::array{p.sign() * p.exponents(from, to), p.sign() * p.exponents(from, to)}; };
  };
  const Function2 hypot = [](double x, double y) { return std::hypot(x, y); };
  compare("hypot of any numbers", hypot, mpfr_hypot, [](Points& p) {
    const double x = any_number(p);
    return std::array{x, x * p.exponents(-60, 60)};
  });
  compare("hypot within 2", hypot, mpfr_hypot, two_of_a_size(-6, 0));
  compare("hypot below the normal numbers", hypot, mpfr_hypot, two_of_a_size(-1074, -1000));
  compare("hypot next to overflow", hypot, mpfr_hypot, two_of_a_size(1000, 1023));
}

BOOST_AUTO_TEST_CASE(hyperbolic_functions) {
  const std::array<std::pair<const char*, std::function<double(Points&)>>, 4> ranges{{
      {"of any number", any_number},
      {"within -2 to 2", uniform(-2, 2)},
      {"within -800 to 800", uniform(-800, 800)},
      {"next to overflow", uniform(708.5, 710.6)},
  }};
  for (const auto& [range, draw] : ranges) {
    compare("sinh " + std::string(range), std::sinh, mpfr_sinh, draw);
    compare("cosh " + std::string(range), std::cosh, mpfr_cosh, draw);
    compare("tanh " + std::string(range), std::tanh, mpfr_tanh, draw);
    compare("asinh " + std::string(range), std::asinh, mpfr_asinh, draw);
  }
  compare("acosh of any number", std::acosh, mpfr_acosh, [](Points& p) { return p.exponents(0, 1023); });
  compare("acosh within 1 to 8", std::acosh, mpfr_acosh, uniform(1, 8));
  compare("acosh near 1", std::acosh, mpfr_acosh, near_one);
  compare("atanh of any number", std::atanh, mpfr_atanh, [](Points& p) { return p.sign() * p.exponents(-1074, -1); });
  compare("atanh within -1 to 1", std::atanh, mpfr_atanh, uniform(-1, 1));
  compare("atanh near 1", std::atanh, mpfr_atanh, near_one);
}

BOOST_AUTO_TEST_CASE(error_and_gamma_functions) {
  compare("erf of any number", std::erf, mpfr_erf, [](Points& p) { return p.sign() * p.exponents(-1074, 3); });
  compare("erf within -6 to 6", std::erf, mpfr_erf, uniform(-6, 6));
  compare("erfc within -6 to 6", std::erfc, mpfr_erfc, uniform(-6, 6), 1.5);
  compare("erfc within 6 to 28", std::erfc, mpfr_erfc, uniform(6, 28), 2);
  compare("tgamma within 0 to 172", std::tgamma, mpfr_gamma, uniform(0, 172));
  compare("tgamma within -30 to 0", std::tgamma, mpfr_gamma, uniform(-30, 0));
  const MpfrFunction exact_lgamma = [](mpfr_ptr result, mpfr_srcptr x, mpfr_rnd_t rounding) {
    int sign = 0;
    return mpfr_lgamma(result, &sign, x, rounding);
  };
  compare("lgamma within 0 to 172", std::lgamma, exact_lgamma, uniform(0, 172));
}

BOOST_AUTO_TEST_CASE(lgamma_of_negative_numbers_is_right_by_its_size_or_by_one) {
  Points points(3);
  Exact x;
  Exact exact;
  for (int i = 0; i < many; ++i) {
    const double at = points.uniform(-20, 0);
    int sign = 0;
    mpfr_set_d(x.value, at, MPFR_RNDN);
    mpfr_lgamma(exact.value, &sign, x.value, MPFR_RNDN);
    const double nearest = mpfr_get_d(exact.value, MPFR_RNDN);
    BOOST_REQUIRE(std::abs(std::lgamma(at) - nearest) <= 1e-15 * std::max(1.0, std::abs(nearest)));
  }
}

BOOST_AUTO_TEST_CASE(functions_of_float) {
  struct Case {
    const char* name;
    float (*ours)(float);
    MpfrFunction exactly;
    double from;
    double to;
  };
  const std::vector<Case> cases{
      {"sinf", std::sin, mpfr_sin, -1e4, 1e4},   {"cosf", std::cos, mpfr_cos, -1e4, 1e4},
      {"tanf", std::tan, mpfr_tan, -1e4, 1e4},   {"asinf", std::asin, mpfr_asin, -1, 1},
      {"acosf", std::acos, mpfr_acos, -1, 1},    {"atanf", std::atan, mpfr_atan, -8, 8},
      {"expf", std::exp, mpfr_exp, -104, 89},    {"exp2f", std::exp2, mpfr_exp2, -150, 129},
      {"expm1f", std::expm1, mpfr_expm1, -8, 8}, {"logf", std::log, mpfr_log, 0, 8},
      {"log2f", std::log2, mpfr_log2, 0, 8},     {"log10f", std::log10, mpfr_log10, 0, 8},
      {"log1pf", std::log1p, mpfr_log1p, -1, 8}, {"cbrtf", std::cbrt, mpfr_cbrt, -8, 8},
      {"sinhf", std::sinh, mpfr_sinh, -90, 90},  {"coshf", std::cosh, mpfr_cosh, -90, 90},
      {"tanhf", std::tanh, mpfr_tanh, -8, 8},    {"asinhf", std::asinh, mpfr_asinh, -8, 8},
      {"acoshf", std::acosh, mpfr_acosh, 1, 8},  {"atanhf", std::atanh, mpfr_atanh, -1, 1},
      {"erff", std::erf, mpfr_erf, -4, 4},       {"erfcf", std::erfc, mpfr_erfc, -4, 10},
      {"exp10f", ::exp10f, mpfr_exp10, -45, 39},
  };
  for (const Case& c : cases) {
    Points points(4);
    Worst worst;
    Exact x;
    Exact exact;
    for (int i = 0; i < many / 4; ++i) {
      const auto at = static_cast<float>(points.uniform(c.from, c.to));
      mpfr_set_flt(x.value, at, MPFR_RNDN);
      c.exactly(exact.value, x.value, MPFR_RNDN);
      const float nearest = mpfr_get_flt(exact.value, MPFR_RNDN);
      if (std::isinf(nearest)) mpfr_set_flt(exact.value, nearest, MPFR_RNDN);
      worst.count(ulps(c.ours(at), exact, 24, -149), c.ours(at), at);
    }
    judge(c.name, worst, 0.51);
  }
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE_END()
