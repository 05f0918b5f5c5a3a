// Tells from a run itself which force has been nearest to that of physics.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>

#include "framework/core/spatial.hpp"
#include "framework/core/time.hpp"

namespace tactor {

/// Fading mean squares of the differences between candidate forces and the force of physics, each taken at the time
/// that a physics result is valid for, when the result comes:
///   E_i <- E_i + (1 - exp(-dt / memory)) (|F_i - F|^2 - E_i),   dt the time since the result before.
/// The first candidate is the one that is wanted. Another takes its place where the first has been worse than `worse`
/// times the best of them, and gives it back where the first is no worse than it. Differences below `noise` count as
/// `noise`. Results that are not finite change nothing.
///
/// Physics is no truth where its steps are coarse: then a first candidate with finer steps differs from it and is
/// right. But coarse steps have the same law of contact. So the first stays as long as less than half of its error is
/// told by `law`, what the law gets wrong where physics itself has the bodies. Without a `law`, physics has another
/// one, and the errors alone decide.
///
/// Allocates nothing.
template <std::size_t Candidates>
class ErrorEstimate {
 public:
  struct Options {
    Duration memory;          ///< time in which a difference fades to 1/e
    double worse = 0;         ///< ratio of errors, at least 1
    double noise = 0;         ///< N
    std::size_t results = 0;  ///< until which the first candidate stays
  };
  using Forces = std::array<Vec3, Candidates>;

  explicit ErrorEstimate(const Options& options) : options_(options) {}

  /// `physics`: the force of a result, N; `forces`: the candidates at the time that it is valid for; `law`: N, empty
  /// where nobody knows it.
  void take(Time valid, const Vec3& physics, const Forces& forces, std::optional<double> law) {
    if (taken_ > 0 && valid <= last_) return;
    const double memory = options_.memory.seconds();
    const double share = taken_ == 0 ? 1 : 1 - std::exp(-(valid - last_).seconds() / memory);
    std::array<double, Candidates> now;
    for (std::size_t i = 0; i < Candidates; ++i) now[i] = dot(forces[i] - physics, forces[i] - physics);
    if (!std::isfinite(law.value_or(0) + std::accumulate(now.begin(), now.end(), 0.0))) return;
    for (std::size_t i = 0; i < Candidates; ++i) squares_[i] += share * (now[i] - squares_[i]);
    law_known_ = law.has_value();
    if (law) law_ += share * (*law * *law - law_);
    last_ = valid;
    ++taken_;
    choose();
  }

  /// The candidate to display.
  [[nodiscard]] std::size_t best() const { return best_; }
  /// N, root mean square of a candidate's difference.
  [[nodiscard]] double error(std::size_t candidate) const { return std::sqrt(squares_[candidate]); }

 private:
  void choose() {
    if (taken_ < options_.results) return;
    const std::size_t least =
        static_cast<std::size_t>(std::min_element(squares_.begin(), squares_.end()) - squares_.begin());
    const double noise = options_.noise * options_.noise;
    const double limit = best_ == 0 ? options_.worse * options_.worse : 1;
    const bool of_law = !law_known_ || law_ > of_error * of_error * squares_[0];
    best_ = least != 0 && of_law && squares_[0] > limit * std::max(squares_[least], noise) ? least : 0;
  }

  static constexpr double of_error = 0.5;

  Options options_;
  std::array<double, Candidates> squares_{};  // N^2
  double law_ = 0;                            // N^2
  bool law_known_ = true;                     // of the last result
  std::size_t best_ = 0;
  std::size_t taken_ = 0;
  Time last_;
};

}  // namespace tactor
