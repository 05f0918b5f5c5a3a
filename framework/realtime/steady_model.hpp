// A Kalman filter of one kind of motion whose gains are computed before it runs.
#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <vector>

#include "framework/core/spatial.hpp"

namespace tactor {

/// A kind of motion, of which a filter knows no more than its spectrum. A chain of `order` integrators behind white
/// noise, as MotionModel has it; and, where `tremor` is above zero, a tremor that is added to it: white noise behind
/// two resonators in series.
struct MotionLaw {
  std::size_t order = 3;                ///< 3 or 4
  double departure = 0;                 ///< m or rad, in 10 ms, of the chain alone
  double tremor = 0;                    ///< m or rad, root of the mean square
  std::array<double, 2> frequencies{};  ///< Hz, of the resonators
  double damping = 0;                   ///< ratio of both
};

/// Estimates position and rate of one kind of motion from samples that come at nearly even intervals. Gains and
/// variances are those of the steady state at the `nominal` interval. A shorter or longer interval has the gain of one
/// such interval among nominal ones; these are tabulated. The three axes share gains. So taking a sample is a few
/// multiplications.
class SteadyModel {
 public:
  static constexpr std::size_t most_states = 7;

  /// `noise`: standard deviation of a sample, m or rad; `nominal`: s. All above zero.
  SteadyModel(const MotionLaw& law, double noise, double nominal);

  /// True where intervals are near enough to the nominal one: from 0.42 to 2.38 times.
  static bool takes(double interval, double nominal);
  /// The rows of the table between which an interval lies.
  struct Lookup {
    std::size_t row;  ///< the lower one
    double share;     ///< of the next row
    double interval;  ///< s
  };
  /// Of an interval, s, that it takes.
  static Lookup find(double interval, double nominal);

  /// Forgets all; the motion starts at `value` with `rate`.
  void start(const Vec3& value, const Vec3& rate = {});
  /// Moves the estimate on by an interval.
  void predict(const Lookup& at);
  /// Takes a sample in; returns log_likelihood() of it.
  Vec3 correct(const Lookup& at, const Vec3& sample);
  /// From here on values are counted from `value`.
  void count_from(const Vec3& value) { state_[0] += -1 * value; }

  /// True if filter and motion are slow against the samples: then it is stable at all intervals that it takes.
  [[nodiscard]] bool slow() const { return slow_; }

  [[nodiscard]] Vec3 value() const { return tremor_ ? state_[0] + state_[order_ + 2] : state_[0]; }
  [[nodiscard]] Vec3 rate() const { return tremor_ ? state_[1] + state_[order_ + 3] : state_[1]; }

  /// From samples at the nominal interval to `stiffness` times value() plus rate(), at `angular_frequency`, rad/s, up
  /// to half of the rate of samples; `stiffness` in 1/s.
  [[nodiscard]] std::complex<double> response(double angular_frequency, double stiffness) const;
  /// The spectral density of the law's motion, m^2 s or rad^2 s, at `angular_frequency` > 0, rad/s: the mean square is
  /// its integral over all frequencies, in Hz, of both signs.
  [[nodiscard]] double spectrum(double angular_frequency) const;

 private:
  struct Row {
    std::array<double, most_states> gain{};
    double by_deviation = 0;     // 1 / sqrt(S), S of the innovation
    double log_variance = 0;     // log(S / noise^2)
    std::array<double, 16> F{};  // the resonators' transition, row by row
  };

  std::size_t order_;
  std::size_t states_;
  bool tremor_;
  MotionLaw law_;
  double nominal_;
  bool slow_ = false;
  double density_ = 0;         // of the chain's white noise
  double tremor_density_ = 0;  // of the resonators'
  std::vector<Row> rows_;
  std::array<Vec3, most_states> state_;
};

}  // namespace tactor
