#include "nodes/physics/engine/copy_engine.hpp"

#include <algorithm>
#include <cmath>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

constexpr double copy_unit_tolerance = 1e-3;

bool are_finite(std::span<const double> numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
}

bool is_unit(const Quat& q) {
  // A comparison with NaN is false.
  return std::abs(std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z) - 1) <= copy_unit_tolerance;
}

}  // namespace

CopyEngine::CopyEngine(const NodeContext& context)
    : tool_rotates_(context.scene->tool() != nullptr && context.scene->tool()->motion == Motion::rigid) {}

void CopyEngine::take(const LightCopy& copy) {
  step_ = copy.step;
  state_.assign(copy.numbers, 0.0);
}

void CopyEngine::check_given() const {
  if (step_) return;
  throw RunError(
      "no program has given its light copy, by PhysicsLoop::rollout in C++ before the run begins; a replay "
      "and a program in Python have none, so take another method there, such as --over local");
}

void CopyEngine::check_stepped(Time time) const {
  if (*failure_ == '\0') return;
  throw RunError("the program's light copy failed in its step from " + std::to_string(time.seconds()) +
                 " s: " + failure_);
}

bool CopyEngine::restore(const EngineNumbers& numbers) {
  if (numbers.position.size() != state_.size() || !are_finite(numbers.position) || !is_finite(numbers.X_WT.p) ||
      !is_finite(numbers.V_WT.v) || !is_finite(numbers.V_WT.w) || !is_unit(numbers.X_WT.R)) {
    return false;
  }
  std::copy(numbers.position.begin(), numbers.position.end(), state_.begin());
  tool_.X_WT = numbers.X_WT;
  tool_.V_WT = numbers.V_WT;
  failure_ = "";
  return true;
}

bool CopyEngine::step(const CouplingParameters& coupling, const DeviceState& to, double h, ContactSet* /*found*/) {
  failure_ = "";
  CopyTool tool;
  try {
    tool = step_(state_, {h, to, coupling});
  } catch (const std::exception& error) {
    thrown_ = std::current_exception();
    failure_ = *error.what() == '\0' ? "it threw an exception without a text" : error.what();
    return false;
  } catch (...) {
    failure_ = "it threw something that is no std::exception";
    return false;
  }
  if (!is_finite(tool.X_WT.p) || !is_finite(tool.V_WT.v) || !is_finite(tool.V_WT.w)) {
    failure_ = "the tool's pose or velocity is not finite";
  } else if (tool_rotates_ && !is_unit(tool.X_WT.R)) {
    failure_ = "the tool's rotation is not a quaternion of length 1";
  } else if (!are_finite(state_)) {
    failure_ = "a number of its state is not finite";
  }
  if (*failure_ != '\0') return false;
  tool_.X_WT = {tool.X_WT.p, tool_rotates_ ? normalized(tool.X_WT.R) : tool_.X_WT.R};
  tool_.V_WT = {tool.V_WT.v, tool_rotates_ ? tool.V_WT.w : Vec3{}};
  return true;
}

}  // namespace tactor
