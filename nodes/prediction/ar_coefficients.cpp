#include "nodes/prediction/ar_coefficients.hpp"

#include "framework/core/describe.hpp"

namespace tactor {

template <>
const MessageType& message_type<ArCoefficients>() {
  using A = ArCoefficients;
  static const MessageType type =
      Describe<A>("ArCoefficients")
          .field("force_order", "1", &A::force_order)
          .field("torque_order", "1", &A::torque_order)
          .choice("detrend", &A::detrend,
                  {{"none", Detrend::none}, {"mean", Detrend::mean}, {"difference", Detrend::difference}})
          .field("window", "1", &A::window)
          .choice("model_structure", &A::model_structure,
                  {{"axes", ModelStructure::axes},
                   {"per_axis", ModelStructure::per_axis},
                   {"vector", ModelStructure::vector}})
          .field("grid_period", "s", &A::grid_period)
          .field("force", "1", &A::force)
          .field("torque", "1", &A::torque)
          .field("force_error_variance", "N^2", &A::force_error_variance)
          .field("torque_error_variance", "N^2 m^2", &A::torque_error_variance)
          .type();
  return type;
}

}  // namespace tactor
