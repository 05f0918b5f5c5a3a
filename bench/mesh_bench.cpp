// What the loading of a mesh takes: read, repaired and checked for the first time, against from the cache.
#include <benchmark/benchmark.h>

#include <fstream>
#include <iterator>
#include <string>

#include "framework/core/temporary_folder.hpp"
#include "nodes/physics/mesh/mesh_formats.hpp"
#include "nodes/physics/mesh/solid_file.hpp"

namespace tactor {
namespace {

std::filesystem::path bunny() {
  return std::string(TACTOR_BINARY_DIR) + "/meshes/bunny.off";
}

void read_text(benchmark::State& state) {
  std::ifstream file(bunny(), std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  for (auto _ : state) benchmark::DoNotOptimize(read_off("bunny.off", bytes));
}
BENCHMARK(read_text)->Unit(benchmark::kMillisecond);

void load_first(benchmark::State& state) {
  for (auto _ : state) {
    const TemporaryFolder cache;
    benchmark::DoNotOptimize(load_solid(bunny(), cache.path()));
  }
}
BENCHMARK(load_first)->Unit(benchmark::kMillisecond);

void load_again(benchmark::State& state) {
  const TemporaryFolder cache;
  load_solid(bunny(), cache.path());
  for (auto _ : state) benchmark::DoNotOptimize(load_solid(bunny(), cache.path()));
}
BENCHMARK(load_again)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tactor
