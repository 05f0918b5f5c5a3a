// The functions of <cmath> that round, by SLEEF instead of the C library, so that a run gives the same bytes on every
// x86-64 processor.
//
// The C library has some of them twice, with and without fused multiply-add, and takes one by the processor it finds.
// Their last digits differ, and they differ between versions of the library too. Here they forward to functions of
// SLEEF (N. Shibata, F. Petrogalli, "SLEEF: A Portable Vectorized Library of C Standard Mathematical Functions", IEEE
// Trans. Parallel Distrib. Syst. 31(6), 2020) that are compiled once, without fused multiply-add. Errors are below 1
// ulp, of erfc below 2, of pow next to overflow below 1.2; of lgamma near its zeros below 1e-15. Where SLEEF falls
// short, next to overflow and below the normal numbers, the functions here do what is missing.
//
// Every program and library of ours is linked with this file as an object. An object comes before shared libraries, so
// all calls that were compiled into it, those of Eigen, Boost and the standard library among them, end here. The names
// are hidden: libraries of others in the same process (Python's, a BLAS) go on with the functions of the C library.
//
// Functions that are exact (floor, fma, fmod, frexp, ldexp, sqrt ...) are the same everywhere and stay with the C
// library. So do those of long double, which nothing that steps uses. None of these sets errno.
//
// It includes no <cmath>, which declares the same names in its own way, and is compiled with -fno-builtin: otherwise
// the compiler takes the body of `sincos` for a call of `sincos`.
#include <sleef.h>

__extension__ typedef __complex__ double Complex;

#define TACTOR_MATH extern "C" __attribute__((visibility("hidden")))

namespace {

constexpr double infinity = __builtin_inf();
constexpr double largest = 0x1.fffffffffffffp+1023;
/// Below it the first term of the series is the function to the last digit: tan(x) = x (1 + x^2 / 3), and so on.
constexpr double tiny = 0x1p-28;
/// SLEEF's asinh and acosh square their argument. From here on sqrt(x^2 + 1) is x to the last digit.
constexpr double squares_overflow = 0x1p+510;
/// Beyond it SLEEF gives infinity for sinh and cosh, which are finite to 710.47, and soon after for exp, which is to
/// 709.7827128.
constexpr double large_exponent = 709;

bool is_finite(double x) {
  return __builtin_fabs(x) <= largest;
}

/// ln(2 x) for large x, as 2 ln(sqrt(2 x)), because 2 x may overflow.
double log_of_twice(double x) {
  return 2 * Sleef_cinz_logd1_u10purec(2 * __builtin_sqrt(x / 2));
}

/// exp(x) / 2 for x of 709 and more: 2^(n - 1) exp(x - n ln 2), with ln 2 in two parts, so that the difference with the
/// upper one is exact. n is chosen so that expm1 is smaller than 1 + expm1, and its error less than the last digit.
double half_exp(double x) {
  if (x > 711) return infinity;
  const double n = x < 710 ? 1023 : 1025;
  const double upper = x - n * 0x1.62e42fefap-1;
  const double lower = n * 0x1.cf79abc9e3b3ap-40;
  const double above_one = Sleef_cinz_expm1d1_u10purec(upper);
  const double sum = 1 + above_one;
  const double rounded_off = above_one - (sum - 1);
  return (sum + (rounded_off - sum * lower)) * 0x1p+1022 * (x < 710 ? 1 : 4);
}

/// x^y where SLEEF gives infinity, which it does from 1 - 2e-6 times the largest number on: x^(y - d) (1 + expm1(d ln
/// x)) with d = 2^-28 y.
double pow_near_overflow(double x, double y, double overflowed) {
  const double size = __builtin_fabs(x);
  const double most = y * (1 - 0x1p-28);
  const double power = Sleef_cinz_powd1_u10purec(size, most);
  const double rest = Sleef_cinz_expm1d1_u10purec((y - most) * Sleef_cinz_logd1_u10purec(size));
  return __builtin_copysign(power + power * rest, overflowed);
}

Complex make_complex(double real, double imaginary) {
  Complex z;
  __real__ z = real;
  __imag__ z = imaginary;
  return z;
}

}  // namespace

// SLEEF takes as long for both as for one, and its single sine is another function. Optimised builds join the sine and
// the cosine of one angle to a call of sincos, debug builds do not: both get the same numbers.
TACTOR_MATH double sin(double x) {
  return Sleef_cinz_sincosd1_u10purec(x).x;
}
TACTOR_MATH double cos(double x) {
  return Sleef_cinz_sincosd1_u10purec(x).y;
}
TACTOR_MATH void sincos(double x, double* sine, double* cosine) {
  const auto both = Sleef_cinz_sincosd1_u10purec(x);
  *sine = both.x;
  *cosine = both.y;
}
TACTOR_MATH double tan(double x) {
  return __builtin_fabs(x) < tiny ? x : Sleef_cinz_tand1_u10purec(x);
}
TACTOR_MATH double asin(double x) {
  return Sleef_cinz_asind1_u10purec(x);
}
TACTOR_MATH double acos(double x) {
  return Sleef_cinz_acosd1_u10purec(x);
}
TACTOR_MATH double atan(double x) {
  return Sleef_cinz_atand1_u10purec(x);
}
TACTOR_MATH double atan2(double y, double x) {
  return __builtin_fabs(y) < tiny * x ? y / x : Sleef_cinz_atan2d1_u10purec(y, x);
}

TACTOR_MATH double exp(double x) {
  return x > large_exponent && x < 711 ? 2 * half_exp(x) : Sleef_cinz_expd1_u10purec(x);
}
TACTOR_MATH double exp2(double x) {
  return Sleef_cinz_exp2d1_u10purec(x);
}
TACTOR_MATH double exp10(double x) {
  return Sleef_cinz_exp10d1_u10purec(x);
}
TACTOR_MATH double expm1(double x) {
  return Sleef_cinz_expm1d1_u10purec(x);
}
TACTOR_MATH double log(double x) {
  return Sleef_cinz_logd1_u10purec(x);
}
TACTOR_MATH double log2(double x) {
  return Sleef_cinz_log2d1_u10purec(x);
}
TACTOR_MATH double log10(double x) {
  return Sleef_cinz_log10d1_u10purec(x);
}
TACTOR_MATH double log1p(double x) {
  if (__builtin_fabs(x) < tiny * tiny) return x;
  return x > 0x1p+1000 ? log(x) : Sleef_cinz_log1pd1_u10purec(x);
}
TACTOR_MATH double pow(double x, double y) {
  const double power = Sleef_cinz_powd1_u10purec(x, y);
  return is_finite(power) || !is_finite(x) || !is_finite(y) || x == 0 || power != power
             ? power
             : pow_near_overflow(x, y, power);
}
TACTOR_MATH double cbrt(double x) {
  return Sleef_cinz_cbrtd1_u10purec(x);
}
TACTOR_MATH double hypot(double x, double y) {
  if (__builtin_fabs(x) < 0x1p-900 && __builtin_fabs(y) < 0x1p-900) {
    return 0x1p-600 * Sleef_cinz_hypotd1_u05purec(0x1p+600 * x, 0x1p+600 * y);
  }
  return Sleef_cinz_hypotd1_u05purec(x, y);
}

TACTOR_MATH double sinh(double x) {
  const double size = __builtin_fabs(x);
  if (size < tiny) return x;
  return size > large_exponent ? __builtin_copysign(half_exp(size), x) : Sleef_cinz_sinhd1_u10purec(x);
}
TACTOR_MATH double cosh(double x) {
  const double size = __builtin_fabs(x);
  return size > large_exponent ? half_exp(size) : Sleef_cinz_coshd1_u10purec(x);
}
TACTOR_MATH double tanh(double x) {
  return __builtin_fabs(x) < tiny ? x : Sleef_cinz_tanhd1_u10purec(x);
}
TACTOR_MATH double asinh(double x) {
  const double size = __builtin_fabs(x);
  if (size < tiny) return x;
  return size > squares_overflow && is_finite(x) ? __builtin_copysign(log_of_twice(size), x)
                                                 : Sleef_cinz_asinhd1_u10purec(x);
}
TACTOR_MATH double acosh(double x) {
  return x > squares_overflow && is_finite(x) ? log_of_twice(x) : Sleef_cinz_acoshd1_u10purec(x);
}
TACTOR_MATH double atanh(double x) {
  return __builtin_fabs(x) < tiny ? x : Sleef_cinz_atanhd1_u10purec(x);
}

TACTOR_MATH double erf(double x) {
  constexpr double slope = 1.1283791670955126;  // 2 / sqrt(pi)
  return __builtin_fabs(x) < tiny ? slope * x : Sleef_cinz_erfd1_u10purec(x);
}
TACTOR_MATH double erfc(double x) {
  return Sleef_cinz_erfcd1_u15purec(x);
}
TACTOR_MATH double tgamma(double x) {
  return Sleef_cinz_tgammad1_u10purec(x);
}
TACTOR_MATH double lgamma(double x) {
  return Sleef_cinz_lgammad1_u10purec(x);
}

// Those of float are those of double, rounded once more, which leaves the error at 0.5 ulp but for a few arguments in a
// million.
#define TACTOR_OF_FLOAT(name)           \
  TACTOR_MATH float name##f(float x) {  \
    return static_cast<float>(name(x)); \
  }
#define TACTOR_OF_TWO_FLOATS(name)              \
  TACTOR_MATH float name##f(float x, float y) { \
    return static_cast<float>(name(x, y));      \
  }
TACTOR_OF_FLOAT(sin)
TACTOR_OF_FLOAT(cos)
TACTOR_OF_FLOAT(tan)
TACTOR_OF_FLOAT(asin)
TACTOR_OF_FLOAT(acos)
TACTOR_OF_FLOAT(atan)
TACTOR_OF_FLOAT(exp)
TACTOR_OF_FLOAT(exp2)
TACTOR_OF_FLOAT(exp10)
TACTOR_OF_FLOAT(expm1)
TACTOR_OF_FLOAT(log)
TACTOR_OF_FLOAT(log2)
TACTOR_OF_FLOAT(log10)
TACTOR_OF_FLOAT(log1p)
TACTOR_OF_FLOAT(cbrt)
TACTOR_OF_FLOAT(sinh)
TACTOR_OF_FLOAT(cosh)
TACTOR_OF_FLOAT(tanh)
TACTOR_OF_FLOAT(asinh)
TACTOR_OF_FLOAT(acosh)
TACTOR_OF_FLOAT(atanh)
TACTOR_OF_FLOAT(erf)
TACTOR_OF_FLOAT(erfc)
TACTOR_OF_FLOAT(tgamma)
TACTOR_OF_FLOAT(lgamma)
TACTOR_OF_TWO_FLOATS(atan2)
TACTOR_OF_TWO_FLOATS(pow)
TACTOR_OF_TWO_FLOATS(hypot)
TACTOR_MATH void sincosf(float x, float* sine, float* cosine) {
  *sine = sinf(x);
  *cosine = cosf(x);
}

// What std::complex calls. The special values are those of annex G of the C standard.
TACTOR_MATH double cabs(Complex z) {
  return hypot(__real__ z, __imag__ z);
}
TACTOR_MATH double carg(Complex z) {
  return atan2(__imag__ z, __real__ z);
}
TACTOR_MATH Complex cexp(Complex z) {
  const double x = __real__ z;
  const double y = __imag__ z;
  if (y == 0) return make_complex(exp(x), y);
  if (!is_finite(y)) {
    if (x == -infinity) return make_complex(0, 0);
    return make_complex(x == infinity ? x : y - y, y - y);
  }
  if (x <= large_exponent) {
    const double size = exp(x);
    return make_complex(size * cos(y), size * sin(y));
  }
  // In four factors, because exp(x) may overflow where its product with a small sine does not.
  const double root = exp(x / 4);
  return make_complex(root * (root * (root * (root * cos(y)))), root * (root * (root * (root * sin(y)))));
}
/// By W. Kahan, "Branch cuts for complex elementary functions", 1987: the root of the larger part, and the other by a
/// division.
TACTOR_MATH Complex csqrt(Complex z) {
  double x = __real__ z;
  double y = __imag__ z;
  if (__builtin_fabs(y) == infinity) return make_complex(infinity, y);
  if (x == 0 && y == 0) return make_complex(0, y);
  if (x == infinity) return make_complex(x, y != y ? y : __builtin_copysign(0.0, y));
  if (x == -infinity) return make_complex(y != y ? y : 0, __builtin_copysign(infinity, y));
  const bool large = __builtin_fabs(x) > 0x1p+1000 || __builtin_fabs(y) > 0x1p+1000;
  const bool small = __builtin_fabs(x) < 0x1p-900 && __builtin_fabs(y) < 0x1p-900;
  const double scale = large ? 0x1p-30 : small ? 0x1p+200 : 1;
  const double root_of_scale = large ? 0x1p+15 : small ? 0x1p-100 : 1;
  x *= scale;
  y *= scale;
  const double root = __builtin_sqrt((__builtin_fabs(x) + hypot(x, y)) / 2);
  const double other = y / (2 * root);
  if (x >= 0) return make_complex(root_of_scale * root, root_of_scale * other);
  return make_complex(root_of_scale * __builtin_fabs(other), root_of_scale * __builtin_copysign(root, y));
}
