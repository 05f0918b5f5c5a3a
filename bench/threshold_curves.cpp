// The curves of what a hand notices, as the metrics use them, and what judging a run by them takes. For pages and
// tests.
//
// threshold_curves: prints JSON.
#include <algorithm>
#include <cmath>
#include <ctime>
#include <iostream>
#include <nlohmann/json.hpp>
#include <random>
#include <utility>
#include <vector>

#include "framework/core/felt.hpp"
#include "framework/core/perception.hpp"
#include "framework/core/third_octaves.hpp"

using namespace tactor;
using Json = nlohmann::ordered_json;

namespace {

constexpr double rate_Hz = 1000;
constexpr int seconds = 14;

/// Best CPU time of some, ms: share and levels of 14 s of noise at 1 kHz.
double judging_ms() {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal(0, 0.1);
  std::vector<Vec3> wanted, shown;
  for (int i = 0; i < seconds * static_cast<int>(rate_Hz); ++i) {
    wanted.push_back({0, 0, 1 + std::sin(1e-3 * i)});
    shown.push_back(wanted.back() + Vec3{normal(random), normal(random), normal(random)});
  }
  double best = 1e9;
  for (int repeat = 0; repeat < 9; ++repeat) {
    const std::clock_t begin = std::clock();
    const double share = share_beyond_weber(shown, wanted);
    const auto felt = felt_vibration(shown, wanted, rate_Hz, 0.1);
    const double ms = 1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    if (share > 0 && felt) best = std::min(best, ms);
  }
  return best;
}

}  // namespace

int main() {
  Json found;
  for (const WeberPoint& p : weber_points()) found["weber"].push_back({p.reference_N, p.jnd_N, p.source});
  for (double force = 0.005; force < 21; force *= 1.05) found["weber_curve"].push_back({force, force_jnd(force)});
  for (const VibrationPoint& p : vibration_points()) {
    found["vibration"].push_back({p.frequency_Hz, p.acceleration_m_s2, p.source});
  }
  for (const ImpedancePoint& p : hand_impedance_points()) {
    found["hand"].push_back({p.frequency_Hz, p.impedance_N_s_m, p.source});
  }
  for (double frequency = 8; frequency < 501; frequency *= 1.02) {
    found["vibration_curve"].push_back({frequency, vibration_threshold(frequency)});
    for (const auto& [name, handle] : {std::pair{"0", 0.0}, {"0.045", 0.045}, {"0.1", 0.1}, {"0.2", 0.2}}) {
      found["force_curves"][name].push_back({frequency, vibration_force_threshold(frequency, handle)});
    }
  }
  for (const ThirdOctave& band : third_octaves(1e5)) {
    found["bands"].push_back({band.nominal_Hz, band.centre_Hz, vibration_force_threshold(band.centre_Hz, 0.1)});
  }
  found["cost"] = {{"seconds", seconds}, {"ms", judging_ms()}};
  std::cout << found.dump(1) << "\n";
}
