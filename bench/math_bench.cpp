// What a function of framework/math costs beside the one of the C library that it replaces.
#include <benchmark/benchmark.h>
#include <dlfcn.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

namespace {

using Function = double (*)(double);
using Function2 = double (*)(double, double);

/// The C library's own function, whatever the name means in this program.
template <typename F>
F of_the_c_library(const char* name) {
  static void* const library = dlopen("libm.so.6", RTLD_NOW | RTLD_LOCAL);
  void* const found = library != nullptr ? dlsym(library, name) : nullptr;
  if (found == nullptr) {
    std::fprintf(stderr, "math_bench: the C library has no %s\n", name);
    std::exit(1);
  }
  return reinterpret_cast<F>(found);
}

constexpr std::size_t count = 1024;

std::array<double, count> numbers(double from, double to, std::uint64_t seed) {
  std::mt19937_64 bits(seed);
  std::array<double, count> values{};
  for (double& v : values) v = from + (to - from) * static_cast<double>(bits() >> 11) * 0x1p-53;
  return values;
}

void one(benchmark::State& state, Function function, double from, double to) {
  const std::array<double, count> x = numbers(from, to, 1);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(function(x[i++ % count]));
}

void two(benchmark::State& state, Function2 function, double from, double to) {
  const std::array<double, count> x = numbers(from, to, 1);
  const std::array<double, count> y = numbers(from, to, 2);
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(function(x[i % count], y[i % count]));
    ++i;
  }
}

void side_by_side(const std::string& name, Function ours, double from, double to) {
  benchmark::RegisterBenchmark((name + "/c_library").c_str(), one, of_the_c_library<Function>(name.c_str()), from, to);
  benchmark::RegisterBenchmark((name + "/ours").c_str(), one, ours, from, to);
}

void side_by_side(const std::string& name, Function2 ours, double from, double to) {
  benchmark::RegisterBenchmark((name + "/c_library").c_str(), two, of_the_c_library<Function2>(name.c_str()), from, to);
  benchmark::RegisterBenchmark((name + "/ours").c_str(), two, ours, from, to);
}

}  // namespace

int main(int argc, char** argv) {
  side_by_side("sin", static_cast<Function>(std::sin), -7, 7);
  side_by_side("cos", static_cast<Function>(std::cos), -7, 7);
  side_by_side("tan", static_cast<Function>(std::tan), -1.5, 1.5);
  side_by_side("asin", static_cast<Function>(std::asin), -1, 1);
  side_by_side("acos", static_cast<Function>(std::acos), -1, 1);
  side_by_side("atan", static_cast<Function>(std::atan), -8, 8);
  side_by_side("atan2", static_cast<Function2>(std::atan2), -2, 2);
  side_by_side("exp", static_cast<Function>(std::exp), -20, 20);
  side_by_side("exp2", static_cast<Function>(std::exp2), -20, 20);
  side_by_side("expm1", static_cast<Function>(std::expm1), -1, 1);
  side_by_side("log", static_cast<Function>(std::log), 0, 10);
  side_by_side("log2", static_cast<Function>(std::log2), 0, 10);
  side_by_side("log10", static_cast<Function>(std::log10), 0, 10);
  side_by_side("log1p", static_cast<Function>(std::log1p), -0.9, 1);
  side_by_side("pow", static_cast<Function2>(std::pow), 0, 10);
  side_by_side("cbrt", static_cast<Function>(std::cbrt), -10, 10);
  side_by_side("hypot", static_cast<Function2>(::hypot), -2, 2);
  side_by_side("sinh", static_cast<Function>(std::sinh), -2, 2);
  side_by_side("cosh", static_cast<Function>(std::cosh), -2, 2);
  side_by_side("tanh", static_cast<Function>(std::tanh), -2, 2);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
