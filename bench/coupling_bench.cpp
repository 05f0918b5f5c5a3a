// The coupling of 3,000 N/m as rows of MuJoCo's constraint solver, as physics.mujoco has it, beside the same coupling
// as a force that is held over each step. A handle presses a tool into its scene and drags it along. The truth is the
// held force at steps of 10 us, which shares no code with the rows.
//
// coupling_bench: prints JSON; takes about ten seconds.
#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/realtime/latency_histogram.hpp"
#include "framework/realtime/monotonic_clock.hpp"
#include "nodes/physics/engine/mujoco_plugin.hpp"
#include "nodes/physics/mechanics/coupling_wrench.hpp"
#include "nodes/physics/mujoco/conversions.hpp"
#include "nodes/physics/mujoco/model_file.hpp"

using namespace tactor;
using nlohmann::ordered_json;

namespace {

constexpr double two_pi = 6.283185307179586;
constexpr double duration = 4;      // s, of the motion
constexpr double sampled = 4e-3;    // s, from one force that is compared to the next
constexpr double true_step = 1e-5;  // s
constexpr std::array<double, 4> steps_s{5e-4, 1e-3, 2e-3, 4e-3};
constexpr double stiffness = 3000, turning_stiffness = 1;  // N/m, N m/rad
constexpr double no_limit = 1e9;                           // N, N m

/// A scene of graphs/own_physics and how its handle goes.
struct PressedTool {
  const char* scene;
  int degrees;                             // of freedom
  std::function<Vec3(double)> position_W;  // m, at a time in s
  std::function<Vec3(double)> rotation_W;  // rad, a rotation vector
};

double wave(double hz, double t) {
  return std::sin(two_pi * hz * t);
}

/// From 0 to 1 and back.
double push(double hz, double t) {
  return 0.5 - 0.5 * std::cos(two_pi * hz * t);
}

/// m
Vec3 tremor(double t) {
  return {5e-5 * wave(8, t), 5e-5 * wave(9, t), 5e-5 * wave(10, t)};
}

/// The ball touches where z is 8 mm; the peg at x 24 mm, y 24 mm and z 20 mm.
std::vector<PressedTool> tools() {
  return {{"ball", 3,
           [](double t) {
             return Vec3{0.02 * wave(0.4, t), 0.01 * wave(0.3, t), 0.01 - 0.004 * push(0.5, t)} + tremor(t);
           },
           [](double) { return Vec3{}; }},
          {"peg", 6,
           [](double t) {
             const Vec3 open{0.02, 0.02, 0.0215};
             return open + Vec3{0.006 * push(0.4, t), 0.006 * push(0.3, t), -0.0035 * push(0.5, t)} + tremor(t);
           },
           [](double t) {
             return 0.04 * Vec3{wave(0.6, t), wave(0.45, t), wave(0.35, t)};
           }}};
}

DeviceState handle_at(const PressedTool& tool, double t) {
  const double e = 1e-5;  // s
  const auto turned = [&](double at) { return from_rotation_vector(tool.rotation_W(at)); };
  DeviceState handle;
  handle.X_WD = {tool.position_W(t), turned(t)};
  handle.V_WD.v = (tool.position_W(t + e) - tool.position_W(t - e)) / (2 * e);
  handle.V_WD.w = to_rotation_vector(turned(t + e) * inverse(turned(t - e))) / (2 * e);
  return handle;
}

std::filesystem::path model_of(const PressedTool& tool) {
  return std::filesystem::path(TACTOR_SOURCE_DIR) / "graphs/own_physics" / (std::string(tool.scene) + ".xml");
}

/// What moves a tool on the coupling.
class Coupled {
 public:
  Coupled() = default;
  virtual ~Coupled() = default;
  Coupled(const Coupled&) = delete;
  Coupled& operator=(const Coupled&) = delete;
  virtual bool step(const CouplingParameters& coupling, const DeviceState& from, const DeviceState& to, double h) = 0;
  /// Pose and velocity of the tool now.
  virtual void tell(PhysicsState& state) = 0;
  /// How often MuJoCo has put an unstable scene back to its begin.
  [[nodiscard]] virtual int resets() const = 0;
};

/// The rows of the solver, through the plugin.
class InSolver final : public Coupled {
 public:
  explicit InSolver(const PressedTool& tool)
      : engine_(load_mujoco_plugin("coupling_bench")
                    .engine({.file = model_of(tool), .tool = "tool", .keyframe = "", .bodies = {}})) {
    engine_->place_tool(handle_at(tool, 0).X_WD);
  }
  bool step(const CouplingParameters& coupling, const DeviceState&, const DeviceState& to, double h) override {
    const bool is_stepped = engine_->step(coupling, to, h, nullptr);
    failures_ += is_stepped ? 0 : 1;
    return is_stepped;
  }
  void tell(PhysicsState& state) override {
    state.X_WT = engine_->tool().X_WT;
    state.V_WT = engine_->tool().V_WT;
  }
  [[nodiscard]] int resets() const override { return failures_; }
  [[nodiscard]] const CoupledEngine& engine() const { return *engine_; }

 private:
  std::unique_ptr<CoupledEngine> engine_;
  int failures_ = 0;
};

/// MuJoCo alone. The coupling is an applied force, as it is at the begin of the step.
class HeldForce final : public Coupled {
 public:
  explicit HeldForce(const PressedTool& tool) {
    std::array<char, 1000> error{};
    model_.reset(mj_loadXML(model_of(tool).string().c_str(), nullptr, error.data(), static_cast<int>(error.size())));
    if (model_ == nullptr) throw InputError(error.data());
    data_.reset(mj_makeData(model_.get()));
    body_ = mj_name2id(model_.get(), mjOBJ_BODY, "tool");
    const Pose X = handle_at(tool, 0).X_WD;
    if (tool.degrees == 6) {
      const std::array<double, 7> pose{X.p.x, X.p.y, X.p.z, X.R.w, X.R.x, X.R.y, X.R.z};
      std::copy(pose.begin(), pose.end(), data_->qpos);
    } else {
      for (int i = 0; i < 3; ++i) data_->qpos[i] = X.p[i] - model_->body_pos[3 * body_ + i];
    }
  }
  bool step(const CouplingParameters& coupling, const DeviceState& from, const DeviceState&, double h) override {
    model_->opt.timestep = h;
    mj_step1(model_.get(), data_.get());
    PhysicsState state;
    read(state);
    state.X_WD = from.X_WD;
    state.V_WD = from.V_WD;
    const Wrench on_handle = coupling_wrench(coupling, state, true);
    for (int i = 0; i < 3; ++i) {
      data_->xfrc_applied[6 * body_ + i] = -on_handle.force[i];
      data_->xfrc_applied[6 * body_ + 3 + i] = -on_handle.torque[i];
    }
    mj_step2(model_.get(), data_.get());
    return true;
  }
  void tell(PhysicsState& state) override {
    mj_kinematics(model_.get(), data_.get());
    mj_comPos(model_.get(), data_.get());
    mj_comVel(model_.get(), data_.get());
    read(state);
  }
  [[nodiscard]] int resets() const override {
    return data_->warning[mjWARN_BADQPOS].number + data_->warning[mjWARN_BADQVEL].number +
           data_->warning[mjWARN_BADQACC].number;
  }

 private:
  void read(PhysicsState& state) const {
    state.X_WT = centre_pose(*data_, body_);
    std::array<double, 6> turn_and_move{};
    mj_objectVelocity(model_.get(), data_.get(), mjOBJ_BODY, body_, turn_and_move.data(), 0);
    state.V_WT = {vec3_at(turn_and_move.data() + 3), vec3_at(turn_and_move.data())};
  }

  ModelPointer model_;
  DataPointer data_;
  int body_ = 0;
};

/// The force on the handle every `sampled`, N, and how long the steps took.
struct Track {
  std::vector<Vec3> force_W;
  LatencyHistogram took;
  int resets = 0;
};

std::unique_ptr<Track> follow(const PressedTool& tool, Coupled& coupled, const CouplingParameters& coupling, double h) {
  auto track = std::make_unique<Track>();
  const auto every = static_cast<int>(std::lround(sampled / h));
  const auto count = static_cast<int>(std::lround(duration / h));
  DeviceState from = handle_at(tool, 0);
  for (int i = 1; i <= count; ++i) {
    const DeviceState to = handle_at(tool, i * h);
    const Instant begin = MonotonicClock::now();
    const bool is_stepped = coupled.step(coupling, from, to, h);
    track->took.record(MonotonicClock::now() - begin);
    if (!is_stepped) break;
    from = to;
    if (i % every != 0) continue;
    PhysicsState state;
    coupled.tell(state);
    state.X_WD = to.X_WD;
    state.V_WD = to.V_WD;
    track->force_W.push_back(coupling_wrench(coupling, state, true).force);
  }
  track->resets = coupled.resets();
  return track;
}

double rms(const std::vector<Vec3>& values) {
  double sum = 0;
  for (const Vec3& value : values) sum += dot(value, value);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// Empty where a track ended early, or began anew after a reset.
std::vector<Vec3> difference(const Track& a, const Track& truth) {
  std::vector<Vec3> apart;
  if (a.resets > 0 || a.force_W.size() != truth.force_W.size()) return apart;
  for (std::size_t i = 0; i < a.force_W.size(); ++i) apart.push_back(a.force_W[i] - truth.force_W[i]);
  return apart;
}

ordered_json row(const Track& track, const Track& truth) {
  ordered_json told{{"rms_error_N", nullptr}, {"max_error_N", nullptr}, {"resets", track.resets}};
  if (const std::vector<Vec3> apart = difference(track, truth); !apart.empty()) {
    double most = 0;
    for (const Vec3& one : apart) most = std::max(most, norm(one));
    told["rms_error_N"] = rms(apart);
    told["max_error_N"] = most;
  }
  told["step_p50_us"] = track.took.quantile(0.5).microseconds();
  told["step_p99_us"] = track.took.quantile(0.99).microseconds();
  return told;
}

/// As coupling.dynamic has it, critically damped.
CouplingParameters coupling_for(const CoupledEngine& engine) {
  const Vec3 inertia = engine.tool_principal_inertia();
  const double mean = (inertia.x + inertia.y + inertia.z) / 3;
  CouplingParameters coupling{.k_t = stiffness, .force_max = no_limit, .torque_max = no_limit};
  coupling.b_t = 2 * std::sqrt(stiffness * engine.tool_mass());
  if (engine.tool_rotates()) {
    coupling.k_r = turning_stiffness;
    coupling.b_r = 2 * std::sqrt(turning_stiffness * mean);
  }
  return coupling;
}

/// h^2 k / m + 2 h b / m, the larger one of moving and turning: a held force is stable below 4.
double bound(const CouplingParameters& coupling, const CoupledEngine& engine, double h) {
  const double moving = (h * h * coupling.k_t + 2 * h * coupling.b_t) / engine.tool_mass();
  if (!engine.tool_rotates()) return moving;
  const Vec3 inertia = engine.tool_principal_inertia();
  const double least = std::min({inertia.x, inertia.y, inertia.z});
  return std::max(moving, (h * h * coupling.k_r + 2 * h * coupling.b_r) / least);
}

ordered_json measure(const PressedTool& tool) {
  const InSolver first(tool);
  const CoupledEngine& engine = first.engine();
  const CouplingParameters coupling = coupling_for(engine);
  const auto by_rows = [&](double h) {
    InSolver coupled(tool);
    return follow(tool, coupled, coupling, h);
  };
  const auto by_held_force = [&](double h) {
    HeldForce coupled(tool);
    return follow(tool, coupled, coupling, h);
  };
  const std::unique_ptr<Track> truth = by_held_force(true_step);
  ordered_json rows = ordered_json::array();
  for (const double h : steps_s) {
    rows.push_back({{"step_s", h},
                    {"bound", bound(coupling, engine, h)},
                    {"rows", row(*by_rows(h), *truth)},
                    {"held", row(*by_held_force(h), *truth)}});
  }
  return {{"scene", tool.scene},
          {"degrees", tool.degrees},
          {"mass_kg", engine.tool_mass()},
          {"stiffness_N_per_m", stiffness},
          {"truth_step_s", true_step},
          {"truth_rms_N", rms(truth->force_W)},
          {"rows_at_truth_step", row(*by_rows(true_step), *truth)},
          {"steps", std::move(rows)}};
}

}  // namespace

int main() try {
  mju_user_warning = [](const char*) {};  // it would write them into a file of the current folder
  ordered_json cases = ordered_json::array();
  for (const PressedTool& tool : tools()) cases.push_back(measure(tool));
  fmt::print("{}\n", cases.dump(1));
  return 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "{}\n", error.what());
  return 1;
}
