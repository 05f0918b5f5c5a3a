// What the integrators of the rigid step do to energy, how exact they are, and what a step costs.
//
// energy_bench [--scenes N] prints JSON: `rebound` (speed kept at a contact), `spin` (energy of a free body), `family`
// (errors of a tool that is pressed and dragged, over N random scenes), `time` (of a step).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <vector>

#include "framework/core/handle_between.hpp"
#include "tests/nodes/physics/mechanics/one_body.hpp"

using namespace tactor;
using namespace tactor::test;
using nlohmann::json;

namespace {

constexpr Integrator integrators[] = {Integrator::implicit_euler, Integrator::midpoint};
constexpr double pi = std::numbers::pi;
constexpr double tick = 1e-3;     // s, between two samples of the handle
constexpr double duration = 0.8;  // s, of a scene of the family
constexpr int finest = 32;        // steps a tick, of the reference

const char* name_of(Integrator integrator) {
  return integrator == Integrator::midpoint ? "midpoint" : "implicit_euler";
}

SystemModel model_of(Integrator integrator, double mass, bool rotates) {
  SystemModel m = block(mass, rotates);
  m.integrator = integrator;
  return m;
}

/// The share of its speed that a mass keeps at a contact, a mean over where in a step contact begins.
double rebound(Integrator integrator, double k, double mass, double zeta, double h) {
  constexpr int phases = 8;
  constexpr double speed = 0.626;  // m/s, of a fall of 20 mm
  const double w = std::sqrt(k / mass);
  double sum = 0;
  for (int i = 0; i < phases; ++i) {
    SystemModel m = model_of(integrator, mass, false);
    m.gravity_W = {};
    OneBody t(m);
    // The damper is felt from b v / k above the surface on.
    const double away = 2 * zeta * speed / w + (1 + static_cast<double>(i) / phases) * speed * h;
    t.contacts = {floor_at({}, away, k, 2 * zeta * std::sqrt(k * mass), 0)};
    t.V().v.z = -speed;
    const double steps = 4 * away / speed / h + 3 * pi / (w * h) + 20;
    for (int j = 0; j < steps; ++j) t.advance(h);
    sum += t.V().v.z / speed;
  }
  return sum / phases;
}

json rebounds() {
  json rows = json::array();
  for (const double k : {300.0, 2000.0, 20000.0}) {
    for (const double mass : {0.005, 0.1, 0.3}) {
      // The second is that of a material's default damping, 2 N s/m, on 0.1 kg.
      for (const double zeta : {0.0, 2 / (2 * std::sqrt(2000 * 0.1))}) {
        for (const double h : {1e-4, 2e-4, 5e-4, 1e-3}) {
          json row{{"stiffness", k}, {"mass", mass}, {"zeta", zeta}, {"substep", h}};
          row["exact"] = std::exp(-pi * zeta / std::sqrt(1 - zeta * zeta));
          for (const Integrator i : integrators) row[name_of(i)] = rebound(i, k, mass, zeta, h);
          rows.push_back(row);
        }
      }
    }
  }
  return rows;
}

json spins() {
  json rows = json::array();
  for (const double speed : {1.0, 5.0, 20.0, 100.0}) {
    SystemModel m = model_of(Integrator::implicit_euler, 0.1, true);
    m.gravity_W = {};
    OneBody t(m);
    const Vec3 axis{3, 20, 1};
    t.V().w = (speed / norm(axis)) * axis;
    const double energy = t.energy();
    for (int i = 0; i < 10000; ++i) t.advance(1e-3);
    rows.push_back({{"speed", speed}, {"energy_change", t.energy() / energy - 1}});
  }
  return rows;
}

/// A tool that a handle presses onto a plane, drags and lifts, in numbers spread over the range that scenes have.
struct Scene {
  double mass = 0, k = 0, b = 0, friction = 0, k_t = 0, b_t = 0;
  bool rotates = false;
  double depth = 0, rate = 0;  // m and Hz, of the handle's motion
  std::vector<DeviceState> handle;
};

/// Samples of a handle: smooth, seen in steps of 10 um with a velocity that is uncertain by 2 mm/s.
std::vector<DeviceState> handle_of(const Scene& s, std::mt19937_64& random) {
  std::normal_distribution<double> noise(0, 0.002);
  std::vector<DeviceState> samples;
  for (int i = 0; i <= duration / tick; ++i) {
    const double w = 2 * pi * s.rate, u = 2 * pi * 1.3, t = i * tick;
    const Vec3 p{0.01 * std::sin(u * t), 0, 0.004 - s.depth / 2 * (1 - std::cos(w * t))};
    const Vec3 v{0.01 * u * std::cos(u * t), 0, -s.depth / 2 * w * std::sin(w * t)};
    DeviceState d;
    d.X_WD.p = {1e-5 * std::round(p.x / 1e-5), 0, 1e-5 * std::round(p.z / 1e-5)};
    d.V_WD.v = {v.x + noise(random), noise(random), v.z + noise(random)};
    samples.push_back(d);
  }
  return samples;
}

Scene scene_of(int number, std::mt19937_64& random) {
  const auto between = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  const auto spread = [&](double a, double b) { return std::exp(between(std::log(a), std::log(b))); };
  Scene s{.mass = spread(0.005, 0.3), .k = spread(300, 20000), .k_t = spread(100, 5000)};
  s.b = number % 3 == 0 ? 0 : 2 * between(0, 1) * std::sqrt(s.k * s.mass);
  s.friction = number % 4 == 0 ? 0 : between(0, 1);
  s.b_t = 2 * (number % 5 == 0 ? 0.1 : 1) * std::sqrt(s.k_t * s.mass);
  s.rotates = number % 2 == 1;
  s.depth = spread(0.006, 0.02);
  s.rate = between(1, 5);
  s.handle = handle_of(s, random);
  return s;
}

/// The tool's way and the force on the handle, each tick.
struct Track {
  std::vector<Vec3> p, F;
  double generated = 0;  // J, beyond what the handle put in
  int unsolved = 0;
};

Track track(const Scene& s, Integrator integrator, int steps_a_tick) {
  OneBody t(model_of(integrator, s.mass, s.rotates));
  t.coupling = {.k_t = s.k_t, .b_t = s.b_t, .k_r = 1e-4 * s.k_t, .b_r = 1e-4 * s.b_t};
  const int points = s.rotates ? 4 : 1;
  for (int i = 0; i < points; ++i) {
    const double a = 2 * pi * (i + 0.1) / points;
    Contact c = floor_at({0.01 * std::cos(a), 0.01 * std::sin(a), -0.002}, -0.002, s.k, s.b, s.friction);
    t.contacts.push_back(c);
  }
  t.X().p = s.handle[0].X_WD.p;
  t.V().v = s.handle[0].V_WD.v;
  t.advance(1e-12, s.handle[0]);
  Track result;
  double energy = t.energy();
  for (std::size_t i = 1; i < s.handle.size(); ++i) {
    for (int j = 1; j <= steps_a_tick; ++j) {
      const double share = static_cast<double>(j) / steps_a_tick;
      const StepResult r =
          t.advance(tick / steps_a_tick, handle_between(s.handle[i - 1], s.handle[i], share, s.rotates));
      result.unsolved += r.outcome == StepOutcome::converged ? 0 : 1;
      const double now = t.energy();
      result.generated += std::max(0.0, now - energy - r.work);
      energy = now;
    }
    result.p.push_back(t.X().p);
    result.F.push_back(s.k_t * (t.X().p - s.handle[i].X_WD.p) + s.b_t * (t.V().v - s.handle[i].V_WD.v));
  }
  return result;
}

double rms_difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += dot(a[i] - b[i], a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

/// Of the processor, which others do not lengthen by waiting.
double milliseconds(auto work) {
  const std::clock_t begin = std::clock();
  work();
  return 1000.0 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

json family(int count) {
  std::mt19937_64 random(11);
  json rows = json::array();
  for (int i = 0; i < count; ++i) {
    const Scene s = scene_of(i, random);
    const Track exact = track(s, Integrator::midpoint, finest);
    const Track other = track(s, Integrator::implicit_euler, finest);
    for (const int steps : {1, 2, 5, 10}) {
      for (const Integrator integrator : integrators) {
        Track found;
        const double time = milliseconds([&] { found = track(s, integrator, steps); });
        rows.push_back({{"scene", i},
                        {"integrator", name_of(integrator)},
                        {"substep", tick / steps},
                        {"contact_wh", std::sqrt(s.k / s.mass) * tick / steps},
                        {"position_error", rms_difference(found.p, exact.p)},
                        {"force_error", rms_difference(found.F, exact.F)},
                        {"references_differ", rms_difference(other.F, exact.F)},
                        {"generated", found.generated},
                        {"unsolved", found.unsolved},
                        {"ms_per_s", time / duration}});
      }
    }
  }
  return rows;
}

/// The time of a step that presses and slides, in us, the least of several turns.
json times() {
  json rows = json::array();
  for (const int points : {1, 10, 40}) {
    json row{{"contacts", points}};
    for (int turn = 0; turn < 7; ++turn) {
      for (const Integrator integrator : integrators) {
        OneBody t(model_of(integrator, 0.1, true));
        t.coupling = spring(500, 0.1);
        for (int i = 0; i < points; ++i) {
          const double a = 2 * pi * i / points;
          t.contacts.push_back(floor_at({0.01 * std::cos(a), 0.01 * std::sin(a), 0}, 0, 2000.0 / points));
        }
        constexpr int steps = 2000;
        const double ms = milliseconds([&] {
          for (int i = 0; i < steps; ++i) {
            DeviceState d;
            d.X_WD.p = {0.01 * std::sin(0.01 * i), 0, -0.004 + 0.001 * std::sin(0.023 * i)};
            t.advance(tick, d);
          }
        });
        const double us = 1000 * ms / steps;
        const char* name = name_of(integrator);
        row[name] = row.contains(name) ? std::min(us, row[name].get<double>()) : us;
      }
    }
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

int main(int argc, char** argv) {
  int scenes = 100;
  for (int i = 1; i + 1 < argc; ++i) {
    if (std::strcmp(argv[i], "--scenes") == 0) scenes = std::atoi(argv[i + 1]);
  }
  const json result{{"rebound", rebounds()}, {"spin", spins()}, {"time", times()}, {"family", family(scenes)}};
  std::printf("%s\n", result.dump(1).c_str());
}
