// The velocity filters of devices alone: what they make of given positions, and what a sample costs.
//
// velocity_bench estimate FILTER INTERVAL_S STEP_M NOISE_M SEED: reads positions (float64 x y z, m) of an even rate
// from stdin; writes for each the position that an encoder shows and the velocity of a PoseFilter with the default
// departure (6 float64, m and m/s).
// velocity_bench time: prints JSON, the CPU time of a sample by filter.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "devices/simulated/encoder.hpp"
#include "framework/core/spatial.hpp"
#include "framework/core/time.hpp"

using namespace tactor;

namespace {

constexpr std::pair<const char*, VelocityFilter> filters[] = {
    {"several", VelocityFilter::several}, {"mixed", VelocityFilter::mixed}, {"one", VelocityFilter::one}};

VelocityFilter filter_of(const std::string& name) {
  for (const auto& [text, filter] : filters) {
    if (name == text) return filter;
  }
  std::cerr << "expected several, mixed or one, found " << name << '\n';
  std::exit(2);
}

/// Moves a handle along positions, m, and calls `told` with what its encoder shows of each.
template <class Told>
void show(Encoder& encoder, const std::vector<Vec3>& path, double interval, bool rotate, const Told& told) {
  for (std::size_t k = 0; k < path.size(); ++k) {
    MotionState truth;
    truth.X.p = path[k];
    if (rotate) truth.X.R = from_rotation_vector(10 * path[k]);
    told(encoder.read(truth, Time::from_seconds(static_cast<double>(k) * interval)));
  }
}

double microseconds_since(std::clock_t begin) {
  return 1e6 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

void estimate(char** arguments) {
  EncoderParameters parameters;
  parameters.velocity.velocity_filter = filter_of(arguments[0]);
  parameters.interval = std::atof(arguments[1]);
  parameters.step = std::atof(arguments[2]);
  parameters.noise = std::atof(arguments[3]);
  parameters.seed = static_cast<std::uint64_t>(std::atoll(arguments[4]));
  if (!(parameters.interval > 0)) {
    std::cerr << "expected an interval above zero, found " << arguments[1] << '\n';
    std::exit(2);
  }
  std::vector<Vec3> path;
  for (std::array<double, 3> p{}; std::fread(p.data(), sizeof(double), 3, stdin) == 3;)
    path.push_back({p[0], p[1], p[2]});
  Encoder encoder(parameters, false);
  show(encoder, path, parameters.interval, false, [](const MotionState& state) {
    const std::array<double, 6> line{state.X.p.x, state.X.p.y, state.X.p.z, state.V.v.x, state.V.v.y, state.V.v.z};
    std::fwrite(line.data(), sizeof(double), line.size(), stdout);
  });
}

/// A hand that moves slowly and trembles, 2 s at 1 kHz. The filters take turns; the best of some is told.
void time() {
  constexpr int samples = 2000, repeats = 15;
  constexpr double interval = 1e-3;  // s
  std::vector<Vec3> path;
  for (int k = 0; k < samples; ++k) {
    const double t = interval * k;
    path.push_back({5e-3 * std::sin(2 * t) + 1e-4 * std::sin(55 * t), 5e-3 * std::cos(3 * t), 2e-4 * std::sin(70 * t)});
  }
  nlohmann::ordered_json found;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (const auto& [name, filter] : filters) {
      for (const bool rotate : {false, true}) {
        EncoderParameters parameters;
        parameters.velocity.velocity_filter = filter;
        parameters.interval = interval;
        parameters.step = 1e-5;
        parameters.step_angle = 1e-4;
        const auto best = [&](const std::string& what, double us) {
          auto& least = found[name][what + (rotate ? "_rotates_us" : "_us")];
          least = least.is_null() ? us : std::min(us, least.get<double>());
        };
        std::clock_t begin = std::clock();
        Encoder encoder(parameters, rotate);
        best("make", microseconds_since(begin));
        double sum = 0;
        begin = std::clock();
        show(encoder, path, interval, rotate, [&](const MotionState& state) { sum += state.V.v.x; });
        best("sample", microseconds_since(begin) / samples);
        if (!std::isfinite(sum)) std::abort();
      }
    }
  }
  std::cout << found.dump(2) << '\n';
}

}  // namespace

int main(int count, char** arguments) {
  const std::string task = count > 1 ? arguments[1] : "";
  if (task == "estimate" && count == 7) {
    estimate(arguments + 2);
  } else if (task == "time" && count == 2) {
    time();
  } else {
    std::cerr << "velocity_bench estimate FILTER INTERVAL_S STEP_M NOISE_M SEED | time\n";
    return 2;
  }
}
