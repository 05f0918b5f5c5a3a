// forcefield.proxy: a spring between the handle and a proxy that stays on the surfaces of the scene's fixed bodies.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/core/refusals.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/new_messages.hpp"
#include "nodes/forcefield/god_object.hpp"

namespace tactor {

/// The force on the device, in N and W: F = k (p_proxy - p_WD) - b (v_WD . n) n, where GodObject makes the proxy and n,
/// the direction in which the planes push together; shortened to `force_max`. The damper pulls at most as much as the
/// planes push. With shading, each plane that pushes does so along its surface's interpolated normal.
///
/// The proxy goes through the samples of the handle since the last step, one after another, so that a node that steps
/// seldom (one with a cost, in physics' place) shows the force that one at the device's rate shows at that sample.
/// A sample costs a bounded number of steps of work: `most_casts` ways with `most_looks` looks at faces and boxes about
/// them; while the proxy has no place, eight nearest points of each body. Messages are stamped valid for the newest
/// sample. No torque. Throws InputError as check_static_scene does, where a mesh is no solid, and where the proxy is to
/// be the tool and that is no sphere.
class ProxyForceField final : public Node, public Refusing {
 public:
  enum class Probe { tool, point };
  struct Params {
    double stiffness = 0;  ///< N/m
    double damping = 0;    ///< N s/m
    Probe probe = Probe::tool;
    bool friction = true;
    bool shading = true;
    double crease = 0;  ///< rad
    std::int32_t most_casts = 0, most_looks = 0;
    double force_max = 0;  ///< N
    double rate = 0;       ///< Hz
  };
  ProxyForceField(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  [[nodiscard]] const Refusals& refusals() const override { return refused_; }

  Input<DeviceState> device;
  Output<ForceSegment> segment;
  Output<Wrench> force;
  Output<PhysicsState> state;

 private:
  static void declare_metrics(Declare<ProxyForceField>& d);
  void go_to(const Stamped<DeviceState>& sample);
  [[nodiscard]] Vec3 shown_force() const;

  Params params_;
  GodObject proxy_;
  Quat R_WT_;
  NewMessages<DeviceState> samples_;
  Stamped<DeviceState> newest_;
  Vec3 last_p_;  // m, of the proxy at the sample before
  Vec3 v_;       // m/s, of the proxy
  bool any_ = false;
  std::int64_t moves_ = 0, lost_ = 0, unfinished_ = 0, starved_ = 0, casts_ = 0;
  int contacts_most_ = 0, casts_most_ = 0, looks_most_ = 0;
  Refusals refused_{"samples"};
};

}  // namespace tactor
