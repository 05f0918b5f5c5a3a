// forcefield.rbf: the static force of a fixed scene, computed before the run and looked up while it runs.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/core/refusals.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/new_messages.hpp"
#include "nodes/forcefield/radial_basis.hpp"
#include "nodes/forcefield/static_force.hpp"
#include "nodes/physics/mesh/bounds.hpp"

namespace tactor {

/// When it is made, samples the static force (static_force.hpp) on a lattice over the region about the fixed bodies and
/// fits radial basis functions (radial_basis.hpp) to it; in a step it evaluates them at the device's newest position.
/// Physics is not needed while running. Centres are the lattice points in contact and those within the support of it.
/// With weight m g and a tool of mass the balance is that of a handle at p_WD + m g / k_t, plus m g on the device.
/// Outside the region the force is that of the region's nearest point. Forces in N, positions in m, both in W. A
/// segment is stamped valid as the device sample it was made from. After J. Fousek, T. Golembiovsky, J. Filipovic, I.
/// Peterlik, "Haptic Rendering Based on RBF Approximation from Dynamically Updated Data", MEMICS 2010; precomputed
/// here, with a local basis. Throws InputError as check_static_scene does, where a fixed body has no end and no region
/// is given, and where the region holds too many lattice points.
class RbfForceField final : public Node, public Refusing {
 public:
  struct Params {
    double k_t = 0;              ///< N/m
    double spacing = 0;          ///< m
    double support = 0;          ///< lattice spacings
    double ridge = 0;            ///< 1
    std::vector<double> region;  ///< m, W: low x, y, z, high x, y, z; empty: about the fixed bodies
    std::int64_t most_points = 0;
    double rate = 0;  ///< Hz
  };
  RbfForceField(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  /// Throws InputError at a coupling of another stiffness than k_t.
  void step(StepContext& context) override;
  [[nodiscard]] const Refusals& refusals() const override { return refused_; }

  Input<DeviceState> device;
  Input<CouplingParameters> coupling;
  Output<ForceSegment> segment;

 private:
  void fit(StaticForce& truth, const Lattice& lattice);
  void hold_out(StaticForce& truth, std::uint64_t seed);
  /// The force on the device at p_WD, before the coupling's limit; counts where it is outside the region.
  [[nodiscard]] Vec3 at(Vec3 p_WD, const CouplingParameters& spring);

  double k_t_;     // N/m
  Bounds region_;  // m, W
  Vec3 weight_W_;  // N, of a tool of mass
  RadialBasis field_;
  double solver_residual_ = 0;                                        // relative
  double residual_median_ = 0, residual_rms_ = 0, residual_max_ = 0;  // N, at points that were not fitted
  std::int64_t unsettled_ = 0;                                        // samples in grooves
  NewMessages<DeviceState> states_;
  Stamped<DeviceState> newest_;
  bool any_ = false;
  std::int64_t outside_ticks_ = 0;
  Refusals refused_{"samples"};
};

}  // namespace tactor
