#include "nodes/forcefield/rbf.hpp"

#include <algorithm>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <cmath>

#include "framework/core/segment.hpp"
#include "nodes/forcefield/supported_scene.hpp"

namespace tactor {

namespace {

constexpr const char* rbf_type = "forcefield.rbf";
constexpr std::size_t held_out = 2000;         // points
constexpr std::size_t draws = 100 * held_out;  // points tried for them, at most
constexpr double same_stiffness = 1e-3;        // of k_t

/// The box about a body in its own frame, which the body must have.
Bounds bounds_of(const Body& body, Notes* notes) {
  if (body.mesh() != nullptr) return bounds_of(load_body_mesh(body, notes));
  Vec3 half;
  if (const auto* sphere = std::get_if<SphereShape>(&body.shape)) {
    half = {sphere->radius, sphere->radius, sphere->radius};
  } else if (const auto* capsule = std::get_if<CapsuleShape>(&body.shape)) {
    half = {capsule->radius, capsule->radius, capsule->radius + capsule->length / 2};
  } else if (const auto* box = std::get_if<BoxShape>(&body.shape)) {
    half = 0.5 * box->size;
  }
  Bounds bounds;
  bounds.add(-half);
  bounds.add(half);
  return bounds;
}

/// The box along the world's axes about the body's own, where the body stands at X_WB.
Bounds world_bounds(const Body& body, const Pose& X_WB, Notes* notes) {
  const Bounds own = bounds_of(body, notes);
  Bounds bounds;
  for (int c = 0; c < 8; ++c) {
    bounds.add(transform(X_WB, {(c & 1) != 0 ? own.high.x : own.low.x, (c & 2) != 0 ? own.high.y : own.low.y,
                                (c & 4) != 0 ? own.high.z : own.low.z}));
  }
  return bounds;
}

/// Where the handle may be while the tool touches something, and `beside` (m) more.
Bounds region_of(const RbfForceField::Params& params, const Scene& scene, double beside, Notes* notes) {
  Bounds region;
  if (!params.region.empty()) {
    const std::vector<double>& r = params.region;
    if (r.size() != 6 || !(r[0] < r[3] && r[1] < r[4] && r[2] < r[5])) {
      throw InputError(std::string(rbf_type) +
                       ": region: expected six lengths, the low x, y, z and the high x, y, z, each low one below its "
                       "high one, or none");
    }
    region.add({r[0], r[1], r[2]});
    region.add({r[3], r[4], r[5]});
    return region;
  }
  for (const Body& body : scene.bodies) {
    if (body.motion != Motion::fixed) continue;
    if (std::holds_alternative<PlaneShape>(body.shape)) {
      throw InputError(std::string(rbf_type) + ": the fixed body '" + body.name +
                       "' is a plane, which has no end; give region: [low x, y, z, high x, y, z]");
    }
    const Bounds bounds = world_bounds(body, body.X_WB, notes);
    region.add(bounds.low);
    region.add(bounds.high);
  }
  const Bounds tool = world_bounds(*scene.tool(), {{}, scene.tool()->X_WB.R}, notes);
  const Vec3 more{beside, beside, beside};
  return {region.low - tool.high - more, region.high - tool.low + more};
}

Lattice lattice_in(const Bounds& region, const RbfForceField::Params& params) {
  Lattice lattice{region.low, params.spacing};
  double points = 1;
  for (int axis = 0; axis < 3; ++axis) {
    // The last point lies at the far side or beyond.
    const double count = std::ceil(region.size()[axis] / params.spacing - 1e-9) + 1;
    points *= count;
    if (points > static_cast<double>(params.most_points)) break;
    lattice.count[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(count);
  }
  if (points > static_cast<double>(params.most_points)) {
    const Vec3 size = region.size();
    throw InputError(std::string(rbf_type) + ": a region of " + std::to_string(size.x) + " by " +
                     std::to_string(size.y) + " by " + std::to_string(size.z) + " m has more than " +
                     std::to_string(params.most_points) + " points at a spacing of " + std::to_string(params.spacing) +
                     " m; raise the spacing or most_points, or give a smaller region");
  }
  return lattice;
}

const Scene& checked(const NodeContext& context) {
  check_static_scene(rbf_type, *context.scene);
  return *context.scene;
}

/// What is refused before the field is sampled and fitted.
void check(const RbfForceField::Params& params, const NodeContext& context) {
  const double beside = params.support * params.spacing;
  lattice_in(region_of(params, checked(context), beside, context.notes), params);
  check_static_force(*context.scene, beside, context.notes);
}

}  // namespace

NodeInfo RbfForceField::declare() {
  Declare<RbfForceField> d(rbf_type,
                           "The static force of a fixed scene, fitted by radial basis functions before the run.");
  d.details(
      "Before the run, the node samples the force of the coupling's spring in balance with the scene's contacts, k_t "
      "(p_WD - p_WT) + sum k_i max(0, -phi_i) n_i = 0, F = -k_t (p_WD - p_WT), on a lattice about the fixed bodies. It "
      "fits F(p) = sum w_j phi(|p - c_j| / R) by (A + ridge I) w = F. phi is Wendland's C2 function of compact "
      "support, so a value costs about 4 (R / spacing)^3 terms, however large the scene is. At its own rate the node "
      "displays F at the device's newest position, and needs no physics. `forcefield.residual_rms_N` and `_max_N` tell "
      "how far F is from static forces at 2,000 points that it was not fitted to, in contact or near it. The field has "
      "no friction and no damping. The kink at the beginning of contact is rounded over a spacing. If the handle goes "
      "in deeper than a wall is thick, it comes out on the other side. It is a baseline for translation-only tools in "
      "fixed scenes.\nAfter Fousek, Golembiovsky, Filipovic, Peterlik, Haptic Rendering Based on RBF Approximation "
      "from Dynamically Updated Data (2010); Wendland, Piecewise polynomial, positive definite and compactly supported "
      "radial functions of minimal degree (1995).");
  d.realtime_safe()
      .input("device", &RbfForceField::device, {.doc = "the device's state at its own rate"})
      .input("coupling", &RbfForceField::coupling,
             {.doc = "the coupling's spring, which must be the one that the field was made for"})
      .output("segment", &RbfForceField::segment, "the force at the device's position, held for a tick")
      .real("k_t", &Params::k_t,
            {.doc =
                 "stiffness of the coupling; if the coupling has another one, the run ends with an error that names it",
             .unit = "N/m",
             .default_value = 500,
             .min = 0,
             .above_min = true})
      .real("spacing", &Params::spacing,
            {.doc = "distance between lattice points", .unit = "m", .default_value = 0.002, .min = 1e-5, .max = 0.1})
      .real("support", &Params::support,
            {.doc = "radius of a basis function, in spacings", .default_value = 3, .min = 1, .max = 6})
      .real("ridge", &Params::ridge,
            {.doc = "added to the diagonal, which is 1. More gives smaller weights and a less exact fit",
             .default_value = 0.01,
             .min = 0,
             .max = 1})
      .reals("region", &Params::region, 0, std::vector<double>{},
             {.doc = "low x, y, z and high x, y, z of the box in the world; empty: the region in which the tool can "
                     "touch a fixed body",
              .unit = "m"})
      .integer("most_points", &Params::most_points,
               {.doc = "most lattice points. Each takes 4 bytes; one in use takes 24 more, and 50 times the cube of "
                       "the support during the fit",
                .default_value = 500'000,
                .min = 8,
                .max = 100'000'000})
      .haptic_rate(&Params::rate, {.doc = "ticks per second"})
      .formerly("coupling", "law")
      .check(check)
      .role(Role::force_field)
      .metric("forcefield.centres", "1", "basis functions", Better::neither,
              [](const RbfForceField& self) { return self.field_.centres(); })
      .metric("forcefield.memory_bytes", "byte", "memory of the field", Better::lower,
              [](const RbfForceField& self) { return self.field_.memory_bytes(); })
      .metric("forcefield.solver_residual", "1", "residual of the fit's linear system, relative", Better::lower,
              &RbfForceField::solver_residual_)
      .metric("forcefield.residual_median_N", "N", "median error at points that were not fitted", Better::lower,
              &RbfForceField::residual_median_)
      .metric("forcefield.residual_rms_N", "N", "RMS error at points that were not fitted", Better::lower,
              &RbfForceField::residual_rms_)
      .metric("forcefield.residual_max_N", "N", "largest error at points that were not fitted", Better::lower,
              &RbfForceField::residual_max_)
      .metric("forcefield.unsettled_samples", "1", "lattice points at which no balance was found", Better::lower,
              &RbfForceField::unsettled_)
      .metric("forcefield.outside_ticks", "1", "ticks at which the device was outside the region", Better::neither,
              &RbfForceField::outside_ticks_)
      .metric("forcefield.rejected_samples", "1", "samples of the device that were not usable", Better::lower,
              [](const RbfForceField& self) { return self.refused_.refused(); });
  return d.info();
}

RbfForceField::RbfForceField(const Params& params, const NodeContext& context)
    : k_t_(params.k_t),
      region_(region_of(params, checked(context), params.support * params.spacing, context.notes)),
      weight_W_(context.scene->tool()->mass * context.scene->gravity_W),
      field_(lattice_in(region_, params), {.support = params.support * params.spacing, .ridge = params.ridge}) {
  StaticForce truth(*context.scene, k_t_, params.support * params.spacing, context.notes);
  fit(truth, lattice_in(region_, params));
  hold_out(truth, context.seed);
}

void RbfForceField::fit(StaticForce& truth, const Lattice& lattice) {
  std::vector<std::int64_t> points;
  std::vector<Vec3> forces;
  for (std::int64_t i = 0; i < lattice.points(); ++i) {
    const StaticForce::Result found = truth.at(lattice.point(i));
    if (!found.near) continue;
    points.push_back(i);
    forces.push_back(found.force);
    if (!found.settled) ++unsettled_;
  }
  solver_residual_ = field_.fit(points, forces);
}

void RbfForceField::hold_out(StaticForce& truth, std::uint64_t seed) {
  boost::random::mt19937_64 engine(seed);
  const auto between = [&](double low, double high) {
    return boost::random::uniform_real_distribution<double>(low, high)(engine);
  };
  std::vector<double> errors;
  double squares = 0;
  for (std::size_t i = 0; i < draws && errors.size() < held_out; ++i) {
    Vec3 p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = between(region_.low[axis], region_.high[axis]);
    const StaticForce::Result found = truth.at(p);
    if (!found.near) continue;
    errors.push_back(norm(field_.at(p) - found.force));
    squares += errors.back() * errors.back();
  }
  if (errors.empty()) return;
  std::sort(errors.begin(), errors.end());
  residual_median_ = errors[errors.size() / 2];
  residual_rms_ = std::sqrt(squares / static_cast<double>(errors.size()));
  residual_max_ = errors.back();
}

Vec3 RbfForceField::at(Vec3 p_WD, const CouplingParameters& spring) {
  const Vec3 weight_W = spring.massless != 0 ? Vec3{} : weight_W_;
  p_WD += weight_W / k_t_;
  Vec3 inside = p_WD;
  for (int axis = 0; axis < 3; ++axis) inside[axis] = std::clamp(p_WD[axis], region_.low[axis], region_.high[axis]);
  if (!(inside == p_WD)) ++outside_ticks_;
  return field_.at(inside) + weight_W;
}

void RbfForceField::step(StepContext& context) {
  Stamped<DeviceState> state;
  while (states_.next(device, state)) {
    const bool finite = is_finite(state.value.X_WD.p);
    refused_.count(finite ? RefusalReason::none : RefusalReason::not_finite);
    if (finite && (!any_ || state.stamp.valid > newest_.stamp.valid)) {
      newest_ = state;
      any_ = true;
    }
  }
  const Stamped<CouplingParameters>* spring = coupling.latest();
  if (!any_ || spring == nullptr) return;
  // Not a number where the coupling has none.
  if (!(std::abs(spring->value.k_t - k_t_) <= same_stiffness * k_t_)) {
    throw InputError("the field was made for a coupling with k_t = " + std::to_string(k_t_) + " N/m and this one has " +
                     std::to_string(spring->value.k_t) + " N/m; set its k_t to that");
  }
  const Vec3 force = at(newest_.value.X_WD.p, spring->value);
  segment.send(newest_.stamp.valid, constant_segment(context.now(), {limited(force, spring->value.force_max), {}}));
}

}  // namespace tactor
