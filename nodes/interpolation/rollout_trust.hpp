// How far a rollout is trusted, by the physics results that come.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "framework/core/messages.hpp"
#include "nodes/interpolation/error_estimate.hpp"
#include "nodes/physics/mechanics/local_model.hpp"

namespace tactor {

/// When a rollout is trusted, as interpolation.rollout declares it.
struct TrustOptions {
  Duration trust_time;
  Duration trust_time_max;
  double trust_distance = 0;  ///< m
  double disagreement = 0;    ///< m
  Duration patience;
  Duration estimate_time;
  double worse = 0;  ///< ratio of errors
};

/// Compares each result with where the rollout was and which forces could have been displayed at its stamp. From that
/// follow the age up to which a result is trusted, the force that has been nearest to physics (ErrorEstimate), and
/// whether physics keeps having the tool elsewhere.
class RolloutTrust {
 public:
  /// The forces that can be displayed. Ties go to the first. Without a forecast the hold's force fills its place.
  enum Candidate : std::size_t { rolled, held_result, forecasted, candidates };
  using Forces = ErrorEstimate<candidates>::Forces;

  explicit RolloutTrust(const TrustOptions& options);

  /// Keeps what a result that is still to come will be compared with: the tool's place in m and the candidates in N. A
  /// result between two of these times is compared with what lies between the two.
  void note(Time time, const Vec3& p_WT, const Forces& forces);
  /// Learns from a result that is used, `interval` after the one before.
  void learn(const Stamped<LocalModel>& result, Duration interval);
  /// The same with the result's force, and with what of it the rollout's law does not explain, N; empty: not known.
  void learn(Time valid, const Vec3& force, std::optional<double> law_error, Duration interval);
  /// Whether the result has its tool farther away than is trusted, or results have had it elsewhere, in about the same
  /// direction, for longer than the patience.
  bool disagrees(const Stamped<LocalModel>& result) { return disagrees(result.stamp.valid, result.value.p_WT_result); }
  /// The same with the result's place of the tool, m.
  bool disagrees(Time valid, const Vec3& p_WT_result);
  /// The tool went to where physics has it.
  void agree() { apart_now_ = false; }

  /// Age of a result up to which its model is continued: longer where physics is slow, as long as it comes.
  [[nodiscard]] Duration time() const { return time_; }
  /// The candidate to display.
  [[nodiscard]] std::size_t best() const { return estimate_.best(); }
  /// N, estimated error of a candidate.
  [[nodiscard]] double error(Candidate candidate) const { return estimate_.error(candidate); }
  [[nodiscard]] std::int64_t disagreements() const { return disagreements_; }

 private:
  struct PastState {
    Time time;
    Vec3 p_WT;
    Forces forces;
  };
  [[nodiscard]] std::optional<PastState> known_at(Time time) const;
  void note_interval(Duration interval);

  TrustOptions options_;
  std::array<Duration, 16> intervals_{};  // between the last results, by their stamps
  std::size_t interval_count_ = 0;        // noted so far
  Duration time_;
  std::array<PastState, 512> past_;  // by the times of the samples
  std::size_t noted_ = 0;
  ErrorEstimate<candidates> estimate_;
  Vec3 apart_;        // m, of physics' tool from this one, where they disagree
  Time apart_since_;  // only while they do
  bool apart_now_ = false;
  std::int64_t disagreements_ = 0;
};

}  // namespace tactor
