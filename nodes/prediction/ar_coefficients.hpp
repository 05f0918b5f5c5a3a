// The coefficients of an auto-regressive predictor, as the refitter sends them.
#pragma once

#include <array>
#include <cstdint>

#include "framework/core/message.hpp"

namespace tactor {

/// What an auto-regressive model leaves out of the samples before it weighs them.
enum class Detrend : std::int32_t {
  none,
  mean,
  difference,
};

/// What the coefficients of an auto-regressive model multiply.
enum class ModelStructure : std::int32_t {
  axes,
  per_axis,
  vector,  ///< of order max_vector_order at most
};

/// Coefficients of an auto-regressive predictor, one set for force and one for torque.
struct ArCoefficients {
  static constexpr int max_order = 32;
  static constexpr int max_vector_order = 8;
  static constexpr int capacity = 3 * max_order;
  std::int32_t force_order = 0;
  std::int32_t torque_order = 0;
  Detrend detrend = Detrend::none;
  std::int32_t window = 0;
  ModelStructure model_structure = ModelStructure::axes;
  double grid_period = 0;  ///< s
  std::array<double, capacity> force{};
  std::array<double, capacity> torque{};
  double force_error_variance = 0;   ///< N^2
  double torque_error_variance = 0;  ///< (N m)^2
};

template <>
const MessageType& message_type<ArCoefficients>();

}  // namespace tactor
