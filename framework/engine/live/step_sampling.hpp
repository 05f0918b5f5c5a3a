// Which steps of a node are timed, so that a run of any length keeps no more than so many times.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tactor {

/// Times every `stride`-th step of a node. When `most` times are kept, two of three are given up and the stride
/// becomes three times as long: what is kept is spread evenly over the whole run, and its quantiles stay those of the
/// run. An odd factor, so that it falls in step with no pattern of two.
class StepSampling {
 public:
  static constexpr std::size_t most = 49'152;

  explicit StepSampling(std::uint64_t stride) : stride_(stride) {}

  /// Whether the step of this number, from 1, is timed.
  [[nodiscard]] bool picks(std::uint64_t step) const { return (step - 1) % stride_ == 0; }
  /// Keeps the time of the step that was picked last.
  void keep(std::vector<std::uint32_t>& times, std::uint32_t ns) {
    if (times.size() == most) {
      for (std::size_t i = 0; 3 * i < most; ++i) times[i] = times[3 * i];
      times.resize(most / 3);
      stride_ *= 3;
    }
    times.push_back(ns);
  }

 private:
  std::uint64_t stride_;
};

}  // namespace tactor
