// A program's own light copy of its simulator, which nodes step between two results of the program.
#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "framework/core/messages.hpp"

namespace tactor {

/// A step of a light copy. Frames: W world, D handle.
struct CopyStep {
  double h = 0;                 ///< s, above zero
  DeviceState handle;           ///< at the end of the step
  CouplingParameters coupling;  ///< the spring and damper between handle and tool
};

/// The tool of a light copy after a step. T: tool.
struct CopyTool {
  Pose X_WT;   ///< m, a unit quaternion; the rotation of a tool that does not turn is not read
  Twist V_WT;  ///< m/s, rad/s
};

/// Moves `state` on by one step and returns the tool at its end. `state`: the numbers that the program told with a
/// result (PhysicsResult::copy_state), or those that a step before made of them. They are all that one step may leave
/// to the next: a new result puts them back, on another thread than the one of the step before.
///
/// It returns the tool, and no force: Tactor computes the force of the coupling from it, with the limits of the device,
/// as it does for a result. So the two cannot differ in sign, frame or damping, and the rate of the force is known too.
///
/// Each node that steps the copy has a function of its own, copied from the program's before the run begins. So what
/// the function holds by value is used by one thread at a time, and serves as memory for a step. What it holds by
/// reference or pointer is used by several threads, the program's among them.
///
/// One node steps in the loop of the device, at the device's priority. There a step must not allocate or free memory,
/// lock, wait, write or read files, or print. It takes a small part of a tick: at a rate of 1 kHz and sub-steps of
/// 0.25 ms, four of them take well below 1 ms together. An exception, a number of the tool or the state that is not
/// finite, or a rotation that is not of length 1 to 0.1 % is a fault: it ends the run, names the node, and the force
/// goes to zero.
using CopyFunction = std::function<CopyTool(std::span<double> state, const CopyStep& step)>;

/// A program's light copy.
struct LightCopy {
  std::size_t numbers = 0;  ///< of its state
  CopyFunction step;
};

/// A node that steps a program's light copy.
class StepsCopy {
 public:
  /// Gives the node a copy of `copy`. Allocates; before the run begins.
  virtual void take_copy(const LightCopy& copy) = 0;

 protected:
  ~StepsCopy() = default;
};

}  // namespace tactor
