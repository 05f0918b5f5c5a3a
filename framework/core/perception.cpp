#include "framework/core/perception.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

constexpr const char* feyzabadi =
    "Feyzabadi et al. 2013, IEEE Trans. Haptics 6(3), abstract: weakest force felt by a moving arm";
constexpr const char* pang =
    "Pang, Tan, Durlach 1991, Manual discrimination of force using active finger motion, abstract: 7 % at 2.5 to 10 N";
constexpr const char* morioka =
    "Morioka, Griffin 2006, J. Sound Vib. 295, as quoted by the Haptics Industry Forum's HDActuatorTest";

// Told as -36 to -38 dB re 1 N s/mm up to 40 Hz, then -7 and -16 dB an octave, nothing from 160 Hz, +16 dB from 320 Hz.
constexpr const char* israr = "Israr, Choi, Tan 2006, IROS, as quoted by row HAP-27 of the ledger of Stabilisation_Pen";

constexpr std::array weber_table{
    // The difference is the threshold without a reference; as the row's own reference it is our reading.
    WeberPoint{0.04, 0.04, feyzabadi},
    WeberPoint{2.5, 0.175, pang},
    WeberPoint{10, 0.7, pang},
};

constexpr std::array vibration_table{
    VibrationPoint{8, 0.095, morioka},    VibrationPoint{10, 0.1, morioka},    VibrationPoint{12.5, 0.095, morioka},
    VibrationPoint{16, 0.108, morioka},   VibrationPoint{20, 0.15, morioka},   VibrationPoint{25, 0.16, morioka},
    VibrationPoint{31.5, 0.109, morioka}, VibrationPoint{40, 0.065, morioka},  VibrationPoint{50, 0.072, morioka},
    VibrationPoint{63, 0.049, morioka},   VibrationPoint{80, 0.028, morioka},  VibrationPoint{100, 0.023, morioka},
    VibrationPoint{125, 0.022, morioka},  VibrationPoint{160, 0.021, morioka}, VibrationPoint{200, 0.029, morioka},
    VibrationPoint{250, 0.032, morioka},  VibrationPoint{315, 0.061, morioka},
};

constexpr std::array impedance_table{
    ImpedancePoint{10, 14.1, israr}, ImpedancePoint{40, 14.1, israr}, ImpedancePoint{80, 6.3, israr},
    ImpedancePoint{160, 1.0, israr}, ImpedancePoint{320, 1.0, israr}, ImpedancePoint{500, 3.3, israr},
};

/// On the line through (x0, y0) and (x1, y1), straight in logarithms of both.
double log_log(double x, double x0, double y0, double x1, double y1) {
  return y0 * std::pow(x / x0, std::log(y1 / y0) / std::log(x1 / x0));
}

}  // namespace

std::span<const WeberPoint> weber_points() {
  return weber_table;
}

double force_jnd(double reference_N) {
  TACTOR_DEMAND(!(reference_N < 0));
  if (reference_N <= weber_table.front().reference_N) return weber_table.front().jnd_N;
  for (std::size_t i = 1; i < weber_table.size(); ++i) {
    const WeberPoint &a = weber_table[i - 1], &b = weber_table[i];
    if (reference_N <= b.reference_N) return log_log(reference_N, a.reference_N, a.jnd_N, b.reference_N, b.jnd_N);
  }
  return reference_N * weber_table.back().jnd_N / weber_table.back().reference_N;
}

std::span<const VibrationPoint> vibration_points() {
  return vibration_table;
}

double vibration_threshold(double frequency_Hz) {
  TACTOR_DEMAND(frequency_Hz > 0);
  const VibrationPoint &first = vibration_table.front(), &last = vibration_table.back();
  if (frequency_Hz <= first.frequency_Hz) {
    return first.acceleration_m_s2 * std::pow(frequency_Hz / first.frequency_Hz, 2);
  }
  for (std::size_t i = 1; i < vibration_table.size(); ++i) {
    const VibrationPoint &a = vibration_table[i - 1], &b = vibration_table[i];
    if (frequency_Hz <= b.frequency_Hz) {
      return log_log(frequency_Hz, a.frequency_Hz, a.acceleration_m_s2, b.frequency_Hz, b.acceleration_m_s2);
    }
  }
  return last.acceleration_m_s2 * std::pow(frequency_Hz / last.frequency_Hz, 2);
}

std::span<const ImpedancePoint> hand_impedance_points() {
  return impedance_table;
}

double hand_impedance(double frequency_Hz) {
  TACTOR_DEMAND(frequency_Hz > 0);
  if (frequency_Hz <= impedance_table.front().frequency_Hz) return impedance_table.front().impedance_N_s_m;
  for (std::size_t i = 1; i < impedance_table.size(); ++i) {
    const ImpedancePoint &a = impedance_table[i - 1], &b = impedance_table[i];
    if (frequency_Hz <= b.frequency_Hz) {
      return log_log(frequency_Hz, a.frequency_Hz, a.impedance_N_s_m, b.frequency_Hz, b.impedance_N_s_m);
    }
  }
  return impedance_table.back().impedance_N_s_m;
}

double apparent_mass(double frequency_Hz, double handle_mass) {
  TACTOR_DEMAND(handle_mass >= 0);
  return std::hypot(handle_mass, hand_impedance(frequency_Hz) / (2 * std::numbers::pi * frequency_Hz));
}

double vibration_force_threshold(double frequency_Hz, double handle_mass) {
  return vibration_threshold(frequency_Hz) * apparent_mass(frequency_Hz, handle_mass);
}

}  // namespace tactor
