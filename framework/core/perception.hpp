// What a hand notices: differences of force, and vibration of what it holds, as tables from the literature.
#pragma once

#include <span>

namespace tactor {

// docs/thresholds.md draws the curves and tells who measured what, on whom, and what of it could be read. Between two
// rows all tables are straight lines in logarithms of both axes.

/// The smallest difference of force that is noticed at a steady force.
struct WeberPoint {
  double reference_N;  ///< the steady force
  double jnd_N;        ///< just noticeable difference
  const char* source;
};
std::span<const WeberPoint> weber_points();

/// The just noticeable difference, N, at a steady force of `reference_N` >= 0. Under the first row that row's
/// difference: what is itself too weak to be felt does not hide a force. Over the last row its share of the force.
double force_jnd(double reference_N);

/// The weakest vibration of a held handle that is felt: a sinusoid, along one axis.
struct VibrationPoint {
  double frequency_Hz;
  double acceleration_m_s2;  ///< RMS
  const char* source;
};
std::span<const VibrationPoint> vibration_points();

/// The detection threshold of vibration, m/s^2 RMS, at `frequency_Hz` > 0. Outside of the table the displacement of its
/// first or last row: the acceleration then goes with the square of the frequency.
double vibration_threshold(double frequency_Hz);

/// A hand that holds a stylus: its mass behind a grasp, on an arm that leads to the ground.
struct StylusHand {
  double mass;                            ///< kg, of the hand
  double grasp_stiffness, grasp_damping;  ///< N/m and N s/m, between stylus and hand
  double arm_stiffness, arm_damping;      ///< N/m and N s/m, between hand and ground
  const char* source;
};
const StylusHand& stylus_hand();

/// |force / acceleration|, kg, at the handle of a device: a rigid handle of `handle_mass` kg held by stylus_hand(), at
/// `frequency_Hz` > 0.
double apparent_mass(double frequency_Hz, double handle_mass);

/// The weakest force of a device, N RMS, that is felt as vibration: vibration_threshold() times apparent_mass(). Motors
/// drive the handle directly.
double vibration_force_threshold(double frequency_Hz, double handle_mass);

}  // namespace tactor
