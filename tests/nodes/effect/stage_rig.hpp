// An effect that a test drives tick by tick: a force and a handle in, a curve out.
#pragma once

#include <map>
#include <string>

#include "framework/core/segment.hpp"
#include "tests/support/force_stream.hpp"
#include "tests/support/nodes.hpp"

namespace tactor::test {

/// An effect between a force that is held and a device that evaluates the newest curve.
template <class N>
class StageRig {
 public:
  explicit StageRig(const typename N::Params& params, std::uint64_t seed = 1) : node(params, context_of(seed)) {
    node.base.configure({QueuePolicy::latest, 1});
    node.device.configure({QueuePolicy::latest, 1});
  }
  /// Physics tells from now on that the tool touches, pushed by `force` (N), or that it does not, where that is zero;
  /// what physics took for its handle had the velocity `v` (m/s) then.
  void touch(int n, const Vec3& force, const Vec3& v) {
    if (!node.contact.connected()) node.contact.configure({QueuePolicy::latest, 1});
    PhysicsState state;
    state.contact_T_W.force = force;
    state.contacts = norm(force) > 0 ? 1 : 0;
    state.V_WD.v = v;
    node.contact.push(stamp_ms(n, static_cast<std::uint64_t>(n)), &state);
  }
  /// Tick n, 1 ms each: with this force coming in and this velocity of the handle, the force at its end, in N. Without
  /// a curve the last one holds.
  Vec3 tick(int n, const Vec3& force, const Vec3& velocity) {
    const Stamp stamp = stamp_ms(n, static_cast<std::uint64_t>(n));
    DeviceState state;
    state.V_WD.v = velocity;
    node.device.push(stamp, &state);
    ForceSegment in = constant_segment(stamp.valid, {force, {}});
    in.trust_time = Duration{7'000'000};
    node.base.push(stamp, &in);
    StepContext step(stamp.valid);
    node.step(step);
    sent = node.segment.pending();
    if (sent > 0) {
      last = *static_cast<const ForceSegment*>(node.segment.pending_value(0));
      valid = node.segment.pending_valid(0);
    }
    node.segment.clear_pending();
    return evaluate(last, stamp_ms(n + 1).valid).force;
  }
  [[nodiscard]] std::map<std::string, double> metrics() const { return metrics_of(node); }

  N node;
  ForceSegment last;
  Time valid;
  std::size_t sent = 0;

 private:
  static NodeContext context_of(std::uint64_t seed) {
    NodeContext c = context(false);
    c.seed = seed;
    return c;
  }
};

}  // namespace tactor::test
