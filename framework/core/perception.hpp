// What a hand notices: differences of force, and vibration of a held object, as tables from the literature.
#pragma once

#include <span>

namespace tactor {

// docs/results/thresholds.md draws the curves and names the sources, the subjects, and what was readable of them.
// Between two rows all tables are straight lines in logarithms of both axes.

/// The smallest difference of force that is noticed at a steady force.
struct WeberPoint {
  double reference_N;  ///< the steady force
  double jnd_N;        ///< just noticeable difference
  const char* source;
};
std::span<const WeberPoint> weber_points();

/// The just noticeable difference, N, at a steady force of `reference_N` >= 0. Below the first row it is that row's
/// difference, because a force too weak to be felt does not hide another one. Above the last row it is that row's share
/// of the force. NaN gives NaN.
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

/// How much a hand that holds a stylus like a pen resists its vibration.
struct ImpedancePoint {
  double frequency_Hz;
  double impedance_N_s_m;  ///< |force / velocity|
  const char* source;
};
std::span<const ImpedancePoint> hand_impedance_points();

/// |force / velocity| of such a hand, N s/m, at `frequency_Hz` > 0; outside of the table that of its first or last row.
double hand_impedance(double frequency_Hz);

/// |force / acceleration|, kg, at the handle of a device: a rigid handle of `handle_mass` kg and hand_impedance(),
/// taken as a damper, at `frequency_Hz` > 0: sqrt(handle_mass^2 + (hand_impedance / (2 pi frequency))^2).
double apparent_mass(double frequency_Hz, double handle_mass);

/// The weakest force of a device, N RMS, that is felt as vibration: vibration_threshold() times apparent_mass(). Motors
/// drive the handle directly.
double vibration_force_threshold(double frequency_Hz, double handle_mass);

}  // namespace tactor
