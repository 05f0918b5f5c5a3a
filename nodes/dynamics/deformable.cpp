#include "nodes/dynamics/deformable.hpp"

#include <algorithm>
#include <cmath>

#include "framework/core/check.hpp"
#include "framework/core/handle_between.hpp"
#include "framework/core/value_error.hpp"
#include "nodes/dynamics/declare_dynamics.hpp"
#include "nodes/physics/contact/moved_on.hpp"
#include "nodes/physics/deformable/static_balance.hpp"
#include "nodes/physics/geometry/mesh_distance.hpp"
#include "nodes/physics/mechanics/eigen.hpp"

namespace tactor {

namespace {

/// Results that edges and their readers hold at the same time.
constexpr std::size_t most_results = 32;

/// s, of the tool's way for which a patch is chosen: two intervals between results, but from the first horizon to this.
constexpr double most_horizon = 0.2;

constexpr int most_far_nodes = 8;

SystemModel rigid_model(const DeformableDynamics::Params& params, const NodeContext& context) {
  SystemModel model = scene_model("dynamics.deformable", *context.scene, context.notes);
  model.iterations = params.iterations;
  model.stick_velocity = params.stick_velocity;
  model.integrator = params.integrator;
  return model;
}

/// Adds the parameters of the output `patch`.
void declare_patch(Declare<DeformableDynamics>& d) {
  // The template arguments let pointers to the members of the base classes convert.
  d.integer<std::int32_t>(
       "patch_nodes", &DeformableDynamics::Params::patch_nodes,
       {.doc = "most nodes around the tool in the output `patch`. The patch has twice as many nodes as are "
               "touched, but at least 16",
        .default_value = 36,
        .min = 4,
        .max = LocalPatch::capacity})
      .integer<std::int32_t>(
          "patch_far_nodes", &DeformableDynamics::Params::patch_far_nodes,
          {.doc = "most nodes of the output `patch` on the rest of the surface. They are spread out and carry the "
                  "slow motions of the whole body",
           .default_value = 8,
           .min = 0,
           .max = most_far_nodes})
      .real<double>(
          "patch_reach", &DeformableDynamics::Params::patch_reach,
          {.doc = "largest distance between the tool and the nodes around it. Nodes within a twentieth of it count "
                  "as touched",
           .unit = "m",
           .default_value = 0.04,
           .min = 0,
           .max = 1});
}

/// Says which solver `auto` is.
void note_choices(const DeformableDynamics::Params& params, int tetrahedra, Notes* notes) {
  if (notes == nullptr || params.solver != FactorKind::automatic) return;
  const FactorChoice choice = chosen_factor(tetrahedra);
  notes->push_back(std::string("dynamics.deformable: solver auto is ") +
                   (choice.kind == FactorKind::supernodal ? "supernodal" : "eigen") + ", because " + choice.why);
}

/// The name of a body that deforms and has no fixed node; empty where all are held.
std::string held_nowhere(const SoftScene& soft, const Scene& scene) {
  const std::vector<std::size_t> bodies = scene.deformable();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const std::vector<char>& fixed = soft.model.bodies()[b].fixed;
    if (std::count(fixed.begin(), fixed.end(), 1) == 0) return scene.bodies[bodies[b]].name;
  }
  return {};
}

/// The nodes after they have come to rest under their weight.
Eigen::VectorXd settled(const SoftScene& soft, const Scene& scene, FactorKind solver, Notes* notes) {
  const Balance balance =
      settle(soft.model, soft.model.rest(), scene.gravity_W, {}, {.tolerance = 1e-6, .factor = solver});
  if (balance.converged) return balance.x;
  if (notes != nullptr) {
    const std::string loose = held_nowhere(soft, scene);
    notes->push_back(
        "dynamics.deformable: warning: the deformable bodies find no balance under their weight, so they start "
        "unstrained and move at once; " +
        (loose.empty() ? std::string("make them stiffer, or set settle: false")
                       : "body '" + loose + "' is held nowhere and falls: give it `fixed`"));
  }
  return soft.model.rest();
}

}  // namespace

double DeformableDynamics::mean_of_a_step(std::int64_t count) const {
  const std::int64_t steps = step_->counts().steps;
  return steps > 0 ? static_cast<double>(count) / static_cast<double>(steps) : 0.0;
}

void DeformableDynamics::declare_metrics(Declare<DeformableDynamics>& d) {
  d.metric("deformable.iterations", "1", "Newton iterations of a step, mean", Better::lower,
           [](const DeformableDynamics& self) { return self.mean_of_a_step(self.step_->counts().iterations); })
      .metric("deformable.factors", "1", "factorisations of a step, mean, those for the patch included", Better::lower,
              [](const DeformableDynamics& self) {
                return self.mean_of_a_step(self.step_->counts().factors + self.condensation_->factors());
              })
      .metric("deformable.updates", "1",
              "updates of a factor of earlier steps by what its iterations found out, of a step, mean", Better::lower,
              [](const DeformableDynamics& self) {
                const double mean = self.mean_of_a_step(self.step_->counts().updates);
                return self.params_.reuse_factors ? std::optional(mean) : std::nullopt;
              })
      .left_out_when([](const DeformableDynamics::Params& p, const MetricUse&) {
        return std::string(p.reuse_factors ? "" : "reuse_factors is false: each step factors");
      })
      .metric("deformable.euler_steps", "1",
              "steps by implicit Euler, because the midpoint rule would have added energy or was not solved",
              Better::lower,
              [](const DeformableDynamics& self) {
                const auto steps = static_cast<double>(self.step_->counts().by_euler);
                return self.params_.integrator == Integrator::midpoint ? std::optional(steps) : std::nullopt;
              })
      .left_out_when([](const DeformableDynamics::Params& p, const MetricUse&) {
        return std::string(p.integrator == Integrator::midpoint ? "" : "integrator is implicit_euler: all are");
      })
      .metric("deformable.unsent_patches", "1", "results without a patch, because readers held all memory",
              Better::lower, &DeformableDynamics::unsent_);
}

NodeInfo DeformableDynamics::declare() {
  Declare<DeformableDynamics> d("dynamics.deformable",
                                "Elastic bodies of tetrahedra, and the rigid ones that touch them.");
  d.details(
      "The node uses finite elements with implicit steps: Newton's method with a line search and a sparse "
      "factorisation. Contact with friction is solved together with the tool as one convex problem "
      "(docs/explanation/deformable.md). A step covers all samples of the handle since the last result, in pieces of "
      "at most `substep`. `law: corotational` is linear elasticity that turns with the material; `neo_hookean` is for "
      "strains above about 20 %. Linear elements are too stiff in bending. `elements: quadratic` avoids that at "
      "several times the cost. Factors of earlier steps are reused and updated from the iterations, until slow "
      "iterations have cost as much as a new factorisation. The report counts the factorisations. Deformable bodies do "
      "not touch each other.");
  declare_moving(d, 0.01);
  d.output("surfaces", &DeformableDynamics::surfaces, "the positions of the surfaces, for display");
  declare_integrator(d);
  declare_soft_contacts(d, ContactSet::capacity, false);
  d.choice<Elasticity>("law", &Params::law,
                       {{"corotational", Elasticity::corotational}, {"neo_hookean", Elasticity::neo_hookean}},
                       Elasticity::corotational, "the elastic law")
      .choice<ElementOrder>("elements", &Params::elements,
                            {{"linear", ElementOrder::linear}, {"quadratic", ElementOrder::quadratic}},
                            ElementOrder::linear, "the order of the tetrahedra: 4 or 10 nodes each")
      .choice<FactorKind>("solver", &Params::solver,
                          {{"auto", FactorKind::automatic},
                           {"portable", FactorKind::portable},
                           {"eigen", FactorKind::eigen},
                           {"simplicial", FactorKind::simplicial},
                           {"supernodal", FactorKind::supernodal}},
                          FactorKind::automatic,
                          "the solver that factors the equations. eigen and simplicial give the same numbers on all "
                          "processors; supernodal is the fastest. auto: eigen below 1,000 tetrahedra, otherwise "
                          "supernodal; portable: eigen below 10,000, otherwise simplicial",
                          FactorKind::portable)
      .integer<std::int32_t>(
          "newton_iterations", &Params::newton_iterations,
          {.doc = "most Newton iterations of the elastic equations in a step. If they do not suffice, the step is "
                  "damped and counted",
           .default_value = 8,
           .min = 1,
           .max = 100,
           .in_reference = 30})
      .real<double>("tolerance", &Params::tolerance,
                    {.doc = "largest residual of the nodes' equations, relative to the forces on the nodes",
                     .default_value = 1e-3,
                     .min = 1e-10,
                     .max = 0.1,
                     .in_reference = 1e-4})
      .boolean(
          "reuse_factors", &Params::reuse_factors, true,
          "keep factors of earlier steps until the slow iterations with them have cost as much as a new factorisation")
      .integer("most_substeps", &Params::most_substeps,
               {.doc = "most steps in a result. If more are needed, the steps become longer than `substep`",
                .default_value = 2,
                .min = 1,
                .max = 1000})
      .real("min_step", &Params::min_step,
            {.doc = "a handle sample that is closer in time than this to the last one used waits for later samples. A "
                    "reference run steps every millisecond",
             .unit = "s",
             .default_value = 0,
             .min = 0,
             .max = 0.1,
             .in_reference = 0.001})
      .boolean("settle", &Params::settle, true, "start with the deformable bodies in balance with their weight");
  declare_patch(d);
  d.coarser("elements", {std::string("linear")})
      .coarser("solver", {std::string("eigen"), std::string("simplicial"), std::string("supernodal")})
      .coarser("newton_iterations", {std::int64_t{4}, std::int64_t{2}})
      .coarser("tolerance", {1e-2, 5e-2})
      .coarser("patch_nodes", {std::int64_t{24}, std::int64_t{16}, std::int64_t{12}, std::int64_t{8}})
      .coarser("patch_far_nodes", {std::int64_t{4}, std::int64_t{0}})
      .coarser("soft_spacing", {4e-3, 8e-3});
  declare_metrics(d);
  return d.info();
}

DeformableDynamics::DeformableDynamics(const Params& params, const NodeContext& context) : params_(params) {
  const Scene& scene = *context.scene;
  soft_ = std::make_unique<SoftScene>(soft_scene(scene, params, context.notes));
  note_choices(params, soft_->model.elements(), context.notes);
  const SystemModel model = rigid_model(params, context);
  const MakeMeshDistance distances = cell_distances({}, context.notes);
  tool_ = std::make_unique<ContactBody>(*scene.tool(), 0, false, params.patch_reach, distances, nullptr);
  soft_contacts_ = std::make_unique<SoftContacts>(scene, params, distances, context.notes);
  std::vector<Vec3> rest;
  for (int i = 0; i < soft_->model.nodes(); ++i) {
    rest.push_back(plain(soft_->model.rest().segment<3>(3 * i)));
  }
  soft_contacts_->set_surface(soft_->surface, rest);
  step_.emplace(*soft_, *soft_contacts_, *tool_, model, params, scene.gravity_W);
  if (params.settle && norm(scene.gravity_W) > 0) step_->place(settled(*soft_, scene, params.solver, context.notes));
  condensation_.emplace(*step_, most_results);
  surface_pool_.emplace(most_results, soft_->shown_nodes.size());
  for (const std::size_t i : scene.moving()) {
    bodies_.X_WB[static_cast<std::size_t>(bodies_.count++)] = scene.bodies[i].X_WB;
  }
}

DeformableDynamics::~DeformableDynamics() = default;

void DeformableDynamics::step(StepContext& context) {
  const Stamped<CouplingParameters>* message = coupling.latest();
  if (message == nullptr) return;
  const CouplingParameters& spring = message->value;
  if (spring.massless != 0) {
    throw RunError(
        "dynamics.deformable needs a tool with mass, and the coupling has a massless tool; use a coupling with a "
        "damper");
  }
  const Stamped<ContactSet>* set = contacts.connected() ? contacts.latest() : nullptr;
  Time until = context.now();
  if (set != nullptr && params_.advance_to == DynamicsParams::AdvanceTo::contacts) {
    until = std::min(until, set->stamp.valid);
  }
  if (!take_samples(until)) return;
  has_newest_ = false;
  if (begun_) {
    advance(spring, set != nullptr ? contact_planes(set->value) : ContactPlanes{});
  } else {
    begin(spring);
  }
  send();
}

/// Puts the newest usable sample up to `until` into newest_. False where it comes less than min_step after the last
/// one.
bool DeformableDynamics::take_samples(Time until) {
  while (handle_.next(device, until, newest_)) has_newest_ = true;
  return has_newest_ && (!begun_ || newest_.stamp.valid - used_.stamp.valid >= params_.min_step);
}

void DeformableDynamics::begin(const CouplingParameters& /*spring*/) {
  begun_ = true;
  used_ = newest_;
  if (!params_.start_at_device) return;
  bodies_.X_WB[0].p = used_.value.X_WD.p;
  if (step_->model().body[0].rotates) bodies_.X_WB[0].R = used_.value.X_WD.R;
}

void DeformableDynamics::advance(const CouplingParameters& spring, const ContactPlanes& planes) {
  const double interval = (newest_.stamp.valid - used_.stamp.valid).seconds();
  step_->set_patch_horizon(std::clamp(2 * interval, PatchChoice::first_horizon, most_horizon));
  // The small allowance keeps an interval of exactly n steps at n.
  const double pieces =
      std::clamp(std::ceil(interval / params_.substep - 1e-6), 1.0, static_cast<double>(params_.most_substeps));
  DeviceState from = used_.value;
  for (double k = 1; k <= pieces; ++k) {
    const DeviceState to = handle_between(used_.value, newest_.value, k / pieces, step_->model().body[0].rotates);
    last_ = step_->advance(spring, from, to, planes, interval / pieces, bodies_);
    ++counts_.steps;
    if (last_.outcome == StepOutcome::damped) ++counts_.damped;
    if (last_.outcome == StepOutcome::stopped) ++counts_.stopped;
    counts_.left_out += last_.left_out;
    from = to;
  }
  used_ = newest_;
}

void DeformableDynamics::send() {
  const Time valid = used_.stamp.valid;
  state.send(valid, {.X_WT = bodies_.X_WB[0],
                     .V_WT = bodies_.V_WB[0],
                     .X_WD = used_.value.X_WD,
                     .V_WD = used_.value.V_WD,
                     .contact_T_W = last_.contact_T_W,
                     .contacts = last_.touching,
                     .damped = last_.outcome == StepOutcome::converged ? 0 : 1});
  if (patch.wanted()) {
    step_->refresh(bodies_);
    if (const auto local = condensation_->condense()) {
      patch.send(valid, *local);
    } else {
      ++unsent_;
    }
  }
  if (surfaces.wanted()) {
    const auto nodes = surface_pool_->make(soft_->shown_nodes.size(), [&](std::span<ShownPoint> to) {
      for (std::size_t i = 0; i < to.size(); ++i) {
        const Eigen::Vector3f p = step_->x().segment<3>(3 * soft_->shown_nodes[i]).cast<float>();
        to[i] = {{p.x(), p.y(), p.z()}};
      }
    });
    if (nodes) surfaces.send(valid, {*nodes});
  }
  bodies.send(valid, bodies_);
  if (expected.wanted()) send_expected();
}

/// Where the bodies are by the newest sample of the handle if they keep their velocities.
void DeformableDynamics::send_expected() {
  const Time now = std::max(device.latest()->stamp.valid, used_.stamp.valid);
  const double ahead = (now - used_.stamp.valid).seconds();
  expected.send(now, moved_on(bodies_, ahead));
}

}  // namespace tactor
