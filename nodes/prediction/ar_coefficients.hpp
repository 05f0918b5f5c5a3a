// The coefficients of an auto-regressive predictor, as the refitter sends them.
#pragma once

#include <array>
#include <cstdint>

#include "framework/core/message.hpp"

namespace tactor {

/// What an auto-regressive model leaves out of the samples before it weighs them.
enum class Detrend : std::int32_t {
  none,        ///< nothing: x_{t+1} = sum_i phi_i x_{t-i+1}
  mean,        ///< the mean m of the last window: x_{t+1} = m + sum_i phi_i (x_{t-i+1} - m)
  difference,  ///< the level, by differences d_t = x_t - x_{t-1}: x_{t+1} = x_t + sum_i phi_i d_{t-i+1}
};

/// What the coefficients of an auto-regressive model multiply.
enum class ModelStructure : std::int32_t {
  axes,      ///< one phi_i for the three axes, from scalar products: phi_i in [i - 1]
  per_axis,  ///< one model an axis: phi_i of axis a in [a max_order + i - 1]
  vector,    ///< a 3x3 matrix a lag: row r, column c of Phi_i in [9 (i - 1) + 3 r + c], order <= max_vector_order
};

/// Coefficients phi_i of an auto-regressive predictor, one set for force and one for torque. Order 0: nothing could be
/// fitted, the reader holds the current value.
struct ArCoefficients {
  static constexpr int max_order = 32;
  static constexpr int max_vector_order = 8;
  static constexpr int capacity = 3 * max_order;
  std::int32_t force_order = 0;
  std::int32_t torque_order = 0;
  Detrend detrend = Detrend::none;  ///< how they were fitted, and so how they are to be applied
  std::int32_t window = 0;          ///< samples they were fitted to
  ModelStructure model_structure = ModelStructure::axes;
  double grid_period = 0;  ///< s, the even spacing of the samples they were fitted to; 0: the samples as they came
  std::array<double, capacity> force{};
  std::array<double, capacity> torque{};
  double force_error_variance = 0;   ///< N^2 a sample, of the fit
  double torque_error_variance = 0;  ///< (N m)^2 a sample, of the fit
};

template <>
const MessageType& message_type<ArCoefficients>();

}  // namespace tactor
