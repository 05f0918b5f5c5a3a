// Times contenders in turns on one core, and compares what they find with the reference.
#pragma once

#include <chrono>
#include <nlohmann/json.hpp>

#include "bench/collision/contender.hpp"

namespace tactor::bench {

struct MeasureOptions {
  int block = 100;       ///< samples in a row by one contender, before the next takes its turn
  int cold_blocks = 20;  ///< of cold_block samples each, with the caches swept before each query; 0: not measured
  int cold_block = 10;
  bool compare = true;  ///< with the reference
  /// A contact deeper than `deep` (m) is missed where nothing is reported within `near` (m) of it.
  double deep = 1e-4, near = 2e-3;
};

/// The contenders' metrics, in the order of the entries; ratios are to the first. Builds each, tells what that took,
/// runs all of them over the steps in turns, and then once more, not timed, to compare what they find with steps'
/// `exact`.
nlohmann::ordered_json measure(const std::vector<Entry>& entries, const Pair& pair, const std::vector<Step>& steps,
                               const MeasureOptions& options);

/// Reads and writes 64 MB.
void sweep_caches();

/// The time a call takes, us.
template <class F>
double microseconds(F&& call) {
  const auto begin = std::chrono::steady_clock::now();
  call();
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count();
}

/// Bytes of the heap in use.
std::size_t heap_in_use();

/// {"median", "p99", "max"}
nlohmann::ordered_json spread_of(const std::vector<double>& values);

}  // namespace tactor::bench
