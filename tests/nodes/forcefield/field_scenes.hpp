// What the tests of the fields of forces share: a ball that translates over fixed bodies, and steps of a node.
#pragma once

#include <map>
#include <string>

#include "tests/support/force_stream.hpp"
#include "tests/support/nodes.hpp"

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

/// A field over a scene, fed with samples of the handle, and the segment that it sent last, with its time of validity.
template <class N>
struct FieldRig {
  explicit FieldRig(const typename N::Params& params, Scene s = floor_and_ball())
      : scene(std::move(s)), node(params, context_for(scene)) {
    node.device.configure({QueuePolicy::drop_oldest, 256});
  }
  void device(double ms, const Vec3& p) { push_device(node.device, ms, p); }
  /// True where a segment was sent.
  bool step(double ms) {
    StepContext context(at_ms(ms));
    node.step(context);
    if (node.segment.pending() == 0) return false;
    last = {{node.segment.pending_valid(0), context.now(), 0}, sent(node.segment)};
    node.segment.clear_pending();
    return true;
  }
  [[nodiscard]] Vec3 shown() const { return evaluate(last.value, last.stamp.produced).force; }

  Scene scene;
  N node;
  Stamped<ForceSegment> last;
};

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
