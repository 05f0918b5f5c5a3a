// The device's end of a wave line: what leaves it and what is played there, as places, with the energy of both.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "framework/core/spatial.hpp"
#include "framework/core/time.hpp"

namespace tactor {

/// A line of the wave impedance b (N s/m) between the handle and the tool. With the velocity v of the handle and the
/// force F on it, the wave that leaves is u = (b v - F) / sqrt(2 b), the one that comes back w = (b v + F) / sqrt(2 b),
/// and the line takes in the power -F . v = |u|^2 / 2 - |w|^2 / 2. Here both are scaled by sqrt(2 / b) to velocities,
///   v_out = v - F / b,  v_in = v + F / b,  power b/4 (|v_out|^2 - |v_in|^2),
/// and kept as places in W: the way of the handle is the mean of the ways of `outgoing` and `incoming`. So what has
/// left and what has been played are sums of ways, and no place drifts.
///
/// At the far end `outgoing` drags the tool by a damper b. The equations there are the same, so what comes back is
/// 2 p_WT - p_out.
///
/// Bookkeeping: the force is held from tick to tick, so the ways d_out and d_in of a tick of T s are those of the force
/// that was commanded and of the way dx that the encoder showed, and -F . dx = b/4 (|d_out|^2 - |d_in|^2) / T holds
/// exactly.
///
/// Energy that a result brings: what left by its time, less what the mean force of its period gave to the tool,
/// b (d_out - d_T) . d_T / P with the ways of that period P. In all it brings no more than had left by its time. The
/// mean alone would lose what the waves of the period differ from it.
///
/// Playing: a result says how far the incoming wave goes in its period. It is played at that rate, and on at that rate
/// for another period at most, where the next result is late. What is due and has not been played (or has been played
/// too far) is caught up with the time constant `catch_up`. All of it is played from the energy that results have
/// brought: of what is left no more in a tick than lasts until the next result is due and a quarter of a period on. So
/// a reserve comes about from which late results are bridged. With nothing left the rate is zero, which leaves the
/// damper b.
class WaveEnd {
 public:
  /// Ticks that a result may come late.
  static constexpr std::size_t ticks_kept = 4096;

  /// What physics tells of the far end at one time.
  struct Result {
    Time at;
    Vec3 tool;    ///< m, p_WT
    Vec3 handle;  ///< m, p_out there
  };

  /// Impedance b in N s/m, tick and catch_up in s, all above 0.
  WaveEnd(double impedance, double tick, double catch_up) : impedance_(impedance), tick_(tick), catch_up_(catch_up) {}

  /// The handle is at `p_WD` (m), and so is all the line, at rest.
  void start(Time at, const Vec3& p_WD);
  /// The handle has gone by `way` (m) since the last time, which is before `at`, while `force` (N, on it) was held.
  void advance(Time at, const Vec3& way, const Vec3& force);
  /// At `now` comes a result that is later than the one before. Returns the mean force of its period, on the line's far
  /// end, N.
  Vec3 arrive(const Result& result, Time now);
  /// N on the handle, to be held for a tick. Before that tick lie the ticks since the last `advance`, in which the
  /// forces `acting` (N) act, one each; the first is the one held now. In all of them the handle is taken to go on with
  /// `velocity` (m/s).
  [[nodiscard]] Vec3 force(std::span<const Vec3> acting, const Vec3& velocity);

  /// m, the wave that has left.
  [[nodiscard]] const Vec3& outgoing() const { return outgoing_; }
  /// m, the wave that has been played.
  [[nodiscard]] const Vec3& incoming() const { return incoming_; }
  /// m, where the incoming wave gets to by the newest result.
  [[nodiscard]] Vec3 arrived() const { return 2 * result_.tool - result_.handle; }
  /// The newest result, or the start.
  [[nodiscard]] const Result& result() const { return result_; }
  /// J, of all that has left, been brought by results, and been played.
  [[nodiscard]] double energy_out() const { return energy_out_; }
  [[nodiscard]] double energy_brought() const { return energy_brought_; }
  [[nodiscard]] double energy_played() const { return energy_played_; }
  /// True where the last force was cut because the energy did not last.
  [[nodiscard]] bool was_cut() const { return was_cut_; }

 private:
  struct Left {
    Time at;
    double energy = 0;  // J, energy_out_ by then
  };

  /// J of a wave that goes by `way` in `dt`.
  [[nodiscard]] double energy_of(const Vec3& way, double dt) const;
  [[nodiscard]] double energy_out_by(Time at);

  double impedance_, tick_, catch_up_;
  Time at_;  // of the newest way
  Vec3 outgoing_, incoming_;
  Result result_;
  Vec3 rate_;  // m/s, of the incoming wave by the newest result
  double period_ = 0;
  Time from_;  // when the newest result came; it is played from the tick after
  double energy_out_ = 0, energy_brought_ = 0, energy_played_ = 0;
  double energy_out_there_ = 0;  // by the time of the newest result
  bool was_cut_ = false;
  std::array<Left, ticks_kept> left_{};  // a ring: `left_count_` entries from `left_begin_` on
  std::size_t left_begin_ = 0, left_count_ = 0;
};

}  // namespace tactor
