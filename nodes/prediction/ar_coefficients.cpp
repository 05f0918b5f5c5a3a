#include "nodes/prediction/ar_coefficients.hpp"

#include "framework/core/describe.hpp"

namespace tactor {

template <>
const MessageType& message_type<ArCoefficients>() {
  using A = ArCoefficients;
  static const MessageType type =
      Describe<A>("ArCoefficients", "",
                  "Coefficients phi_i of an auto-regressive predictor, one set for force and one for torque. Stamped "
                  "valid for the newest sample that they were fitted to.")
          .field("force_order", "1", &A::force_order,
                 "Number of past forces that the model uses. 0: nothing could be fitted, and the reader holds.")
          .field("torque_order", "1", &A::torque_order,
                 "Number of past torques that the model uses. 0: nothing could be fitted, and the reader holds.")
          .choice("detrend", &A::detrend,
                  {{"none", Detrend::none, "Nothing: x_{t+1} = sum_i phi_i x_{t-i+1}."},
                   {"mean", Detrend::mean, "The mean m of the last window: x_{t+1} = m + sum_i phi_i (x_{t-i+1} - m)."},
                   {"difference", Detrend::difference,
                    "The level, by differences d_t = x_t - x_{t-1}: x_{t+1} = x_t + sum_i phi_i d_{t-i+1}."}},
                  "Part of the samples that was left out in the fit, and that a reader leaves out alike.")
          .field("window", "1", &A::window, "Number of samples that the coefficients were fitted to.")
          .choice("model_structure", &A::model_structure,
                  {{"axes", ModelStructure::axes, "One phi_i for the three axes, in `[i - 1]`."},
                   {"per_axis", ModelStructure::per_axis, "One model an axis: phi_i of axis a in `[32 a + i - 1]`."},
                   {"vector", ModelStructure::vector,
                    "Matrices of 3x3: row r, column c of Phi_i in `[9 (i - 1) + 3 r + c]`."}},
                  "Order of the entries of `force` and `torque`.")
          .field("grid_period", "s", &A::grid_period,
                 "Even spacing of the samples that they were fitted to. 0: the samples as they came.")
          .field("force", "1", &A::force, "Coefficients of the force, in the order of `model_structure`.")
          .field("torque", "1", &A::torque, "Coefficients of the torque, in the order of `model_structure`.")
          .field("force_error_variance", "N^2", &A::force_error_variance,
                 "Variance of the error of the fit one sample ahead, of the force.")
          .field("torque_error_variance", "N^2 m^2", &A::torque_error_variance,
                 "Variance of the error of the fit one sample ahead, of the torque.")
          .type();
  return type;
}

}  // namespace tactor
