// The predictor that extrapolates the force along the device's motion.
#pragma once

#include "nodes/prediction/device_track.hpp"
#include "nodes/prediction/predictor.hpp"

namespace tactor {

/// prediction.linear_position: F = F_n + (F_n - F_m) s, s = (P - P_n) . (P_n - P_m) / |P_n - P_m|^2, with P the
/// device's position at the forecast's time as far as it is known, P_n and P_m those at the stamps of the newest sample
/// and of an earlier one. Torque likewise with rotation vectors. Source: Picinbono and Lombardo, "Extrapolation: a
/// solution for force feedback?", 1999; Picinbono, Lombardo, Delingette, Ayache, "Improving realism of a surgery
/// simulator", J. Vis. Comput. Animat. 13 (2002) 147-167.
class LinearPositionPredictor final : public Predictor {
 public:
  struct Params : PredictorParams {
    double min_displacement = 50e-6;
    double min_rotation = 1e-3;
    double reach = 2;
  };
  LinearPositionPredictor(const Params& params, const NodeContext& context)
      : Predictor(params, context),
        force_secant_(params.min_displacement),
        torque_secant_(params.min_rotation),
        reach_(params.reach) {}
  static NodeInfo declare();

  Input<DeviceState> device;

 private:
  // The change of one part of the wrench over a displacement that is long enough to divide by.
  class Secant {
   public:
    explicit Secant(double shortest) : shortest_(shortest) {}
    // `way`: from the former sample to this one.
    void take(const Vec3& value, const Vec3& way);
    void forget() { based_ = known_ = false; }
    [[nodiscard]] bool known() const { return known_; }
    // What a further displacement adds, as far as `reach` times the one the secant was taken over.
    [[nodiscard]] Vec3 change(const Vec3& way, double reach) const;

   private:
    double shortest_;
    bool based_ = false, known_ = false;
    Vec3 base_, since_base_;  // the value at the base, and the way from there
    Vec3 rise_, run_;
  };

  void read_inputs() override { track_.read(device); }
  void take(const Stamped<Wrench>& sample) override;
  Outcome predict(Duration horizon, std::span<Wrench> predicted) override;

  DeviceTrack track_;
  Secant force_secant_;
  Secant torque_secant_;
  double reach_;
  Stamped<Wrench> newest_;
  Pose X_WD_;  // at the newest sample
  bool placed_ = false;
};

}  // namespace tactor
