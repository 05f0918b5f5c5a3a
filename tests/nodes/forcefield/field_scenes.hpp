// What the tests of the fields of forces share: a ball that translates over fixed bodies, and steps of a node.
#pragma once

#include <map>
#include <string>

#include "tests/nodes/defaults.hpp"
#include "tests/nodes/force_stream.hpp"

namespace tactor::test {

inline Body field_body(const std::string& name, const Shape& shape, Motion motion = Motion::fixed) {
  Body body;
  body.name = name;
  body.shape = shape;
  body.motion = motion;
  return body;
}

/// A fixed floor, the plane z = 0, and a ball of 10 mm and 50 g, without gravity.
inline Scene floor_and_ball() {
  Scene scene;
  scene.gravity_W = {};
  scene.bodies = {field_body("floor", PlaneShape{}), field_body("tool", SphereShape{0.01}, Motion::translation)};
  scene.bodies[1].mass = 0.05;
  return scene;
}

inline void push_device(Input<DeviceState>& in, double ms, const Vec3& p) {
  DeviceState state;
  state.X_WD.p = p;
  in.push(stamp_ms(ms), &state);
}

/// Steps at that time; true where a segment was sent, which is put into `segment` with the time it is valid for.
inline bool step_at(Node& node, Output<ForceSegment>& out, double ms, Stamped<ForceSegment>& segment) {
  StepContext context(stamp_ms(ms).valid);
  node.step(context);
  if (out.pending() == 0) return false;
  segment = {{out.pending_valid(0), context.now(), 0}, sent(out)};
  out.clear_pending();
  return true;
}

template <class N>
std::map<std::string, double> metrics_of(const N& node) {
  const Report report = report_of(node);
  return {report.metrics().begin(), report.metrics().end()};
}

/// The InputError that `work` throws, or empty.
template <class Work>
std::string input_error(const Work& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

}  // namespace tactor::test
