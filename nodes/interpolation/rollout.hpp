// interpolation.rollout: continues a local model tick by tick.
#pragma once

#include <array>

#include "framework/core/messages.hpp"
#include "framework/core/refusals.hpp"
#include "framework/node/declare.hpp"
#include "nodes/interpolation/blended_force.hpp"
#include "nodes/interpolation/error_estimate.hpp"
#include "nodes/physics/contact/patch_contacts.hpp"
#include "nodes/physics/contact/surface_contacts.hpp"
#include "nodes/physics/mechanics/handle_track.hpp"
#include "nodes/physics/mechanics/local_model.hpp"
#include "nodes/physics/mechanics/local_rollout.hpp"

namespace tactor {

/// Moves the bodies of the newest model through each sample of the handle and displays the coupling's wrench,
/// F(t) = F + F' (t - t_s) from the sample at t_s on, F' from the velocities and accelerations of handle and tool, so
/// that the tick that passes until the device displays it is not shown late. Where a model arrives the displayed
/// force stays as it is, and the difference decays with two equal poles.
///
/// The force displayed if the rollout cannot be trusted, in this order, each counted:
///   1. the Jacobian, if a step failed and the result is trusted: the last force and its change with the handle's
///      place,
///      up to `trust_distance` away, as long as it does not pull;
///   2. the forecast of `forecast` for now, if the tool last touched something;
///   3. the force of the newest model or of the last trusted tick, whichever is newer, held.
/// A model is trusted if its result is younger than `trust_time`, or than three times the longest recent interval
/// between results, up to `trust_time_max`. On anchors, its tool must also be within `trust_distance` of them. Segments
/// state that time, so the device's gate fades the force out when it has passed. All changes are blended like
/// corrections, so the last one is a hold with a low-pass.
///
/// A rollout that is trusted is still compared with physics: each result tells how far the rollout, the forecast and a
/// hold were from it at its stamp (see ErrorEstimate). Where another has been nearer because physics has another law of
/// contact, it is displayed, and counted.
class Rollout final : public Node, public Refusing {
 public:
  struct Params : SurfaceOptions, PatchOptions {
    Duration blend_time;
    Duration trust_time;
    Duration trust_time_max;
    double trust_distance = 0;  // m
    std::int32_t iterations = 0;
    double stick_velocity = 0;  // m/s
    Integrator integrator = Integrator::implicit_euler;
    double rate = 0;
    enum class Restart { always, on_disagreement };
    Restart restart = Restart::on_disagreement;
    double disagreement = 0;  // m
    Duration patience;
    Duration estimate_time;
    double worse = 0;
  };
  Rollout(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  [[nodiscard]] const Refusals& refusals() const override { return refused_; }

  Input<LocalModel> model;
  Input<DeviceState> device;
  Input<Forecast> forecast;
  Output<ForceSegment> segment;

 private:
  enum class Source : std::uint8_t { rollout, jacobian, forecast, held };
  /// Ties go to the first. Without a forecast the hold's force fills its place.
  enum Candidate : std::size_t { rolled, held_result, forecasted, candidates };
  using Estimate = ErrorEstimate<candidates>;
  struct Then {
    Time time;
    Vec3 p_WT;
    Estimate::Forces forces;  // N, of the candidates
  };

  static void declare_metrics(Declare<Rollout>& node);
  bool take_model(Time now);
  void count_refused(const LocalModel& newest, bool late);
  [[nodiscard]] bool keeps_tool() const;
  [[nodiscard]] const Then* known_at(Time time) const;
  bool disagrees(const Stamped<LocalModel>& result);
  void note_then();
  [[nodiscard]] bool knows_forecast(Time now) const;
  bool is_new_forecast();
  [[nodiscard]] bool is_near_anchor() const;
  void note_interval(Duration interval);
  void go_on();
  [[nodiscard]] bool trusted(Time now) const;
  [[nodiscard]] Source choose(Time now) const;
  [[nodiscard]] ForceState aim(Source source, Time now);
  [[nodiscard]] ForceState of_jacobian() const;

  Params params_;
  bool torque_;
  Duration tick_;
  std::unique_ptr<ContactSource> surface_;
  std::unique_ptr<SoftContactSource> soft_;  // null where nothing deforms
  LocalRollout rollout_;
  CarriedForce carried_;
  BlendedForce blended_;
  HandleTrack<256> track_;
  std::size_t advanced_ = 0;              // samples that the rollout has been through
  Stamp used_;                            // of the model
  std::array<Duration, 16> intervals_{};  // between the last results, by their stamps
  std::size_t interval_count_ = 0;        // noted so far
  Duration trust_;                        // age of a result up to which its model is gone on with
  std::array<Then, 512> path_;            // of the tool, by the times of the samples
  std::size_t noted_ = 0;
  std::uint64_t forecast_shown_ = ~std::uint64_t{0};  // its sequence number
  Estimate estimate_;
  Wrench held_result_;  // of physics' newest result
  Vec3 apart_;          // m, of physics' tool from this one, where they disagree
  Time apart_since_;    // only while they do
  bool apart_now_ = false;
  std::uint64_t rejected_ = ~std::uint64_t{0};  // the sequence number of the model refused last
  bool running_ = false;
  bool failed_ = false;    // a step has, since the model came
  bool touching_ = false;  // the tool, while the rollout was trusted
  Source source_ = Source::rollout;
  ForceState anchor_;  // what the rollout last aimed at while it was trusted
  Wrench held_;        // of the newest model, or what was displayed last while it was trusted
  Pose anchor_X_WD_;   // the handle then
  Eigen::Matrix<double, 6, 6> jacobian_ = Eigen::Matrix<double, 6, 6>::Zero();
  std::array<std::int64_t, 4> ticks_{};  // by source
  Refusals refused_{"models", "contacts"};
  std::int64_t corrections_ = 0;
  std::int64_t steps_ = 0, work_ = 0, most_work_ = 0;
  std::int64_t steps_on_anchors_ = 0, disagreements_ = 0, outdone_ticks_ = 0;
  double correction_sum_ = 0;  // N^2
};

}  // namespace tactor
