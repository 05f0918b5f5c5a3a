#include "nodes/prediction/local.hpp"

#include <algorithm>

#include "nodes/physics/contact/told_contacts.hpp"
#include "nodes/physics/mechanics/coupling_wrench.hpp"
#include "nodes/physics/mechanics/rollout_parameters.hpp"
#include "nodes/physics/mechanics/scene_model.hpp"

namespace tactor {

namespace {

/// Models that edges and their readers hold at the same time.
constexpr std::size_t most_models = 32;

/// Factors on the law of contacts, to see what a wrong one does.
void declare_scales(Declare<LocalPredictor>& node) {
  using Params = LocalPredictor::Params;
  node.real("stiffness_scale", &Params::stiffness_scale,
            {.doc = "factor on the stiffness and damping of contacts before the fit, to see what a wrong model does",
             .default_value = 1,
             .min = 0,
             .max = 100})
      .real("friction_scale", &Params::friction_scale,
            {.doc = "factor on the friction of contacts, for the same purpose",
             .default_value = 1,
             .min = 0,
             .max = 100});
}

}  // namespace

void LocalPredictor::declare_metrics(Declare<LocalPredictor>& node) {
  node.metric("prediction.resimulated_steps", "1", "steps from a result to now, mean of a result", Better::neither,
              [](const LocalPredictor& self) {
                return self.results_ > 0 ? static_cast<double>(self.resimulated_) / static_cast<double>(self.results_)
                                         : 0.0;
              })
      .metric("prediction.rejected_results", "1", "physics results that were not usable", Better::lower,
              [](const LocalPredictor& self) {
                return self.refused_.refused() - self.refused_.refused(RefusalReason::unsolved);
              })
      .summed()
      .metric("prediction.rejected_samples", "1", "samples that were not finite, or too late to be used", Better::lower,
              [](const LocalPredictor& self) { return self.track_.rejected(); })
      .summed()
      .metric("prediction.failed_steps", "1", "steps that were not solved", Better::lower,
              [](const LocalPredictor& self) { return self.refused_.refused(RefusalReason::unsolved); })
      .summed();
  const auto fit = [&node](const char* name, const char* doc, Better better, const auto& value) {
    const auto if_fitted = [value](const LocalPredictor& self) {
      const auto found = static_cast<double>(std::invoke(value, self));
      return self.params_.fit && self.state.connected() ? std::optional(found) : std::nullopt;
    };
    node.metric(std::string("local.fit.") + name, "1", doc, better, if_fitted)
        .left_out_when([](const LocalPredictor::Params& params, const MetricUse& use) {
          if (!params.fit) return std::string("fit is false");
          return std::string(use.is_fed("state") ? "" : "nothing feeds the input state");
        });
  };
  fit("stiffness_scale", "scale of stiffness and damping of contacts at the end", Better::neither,
      [](const LocalPredictor& self) { return self.fit_.error().stiffness_scale; });
  fit("friction_excess", "excess of the friction of contacts at the end", Better::neither,
      [](const LocalPredictor& self) { return self.fit_.error().friction_excess; });
  fit("results", "physics results that the fit used", Better::neither,
      [](const LocalPredictor& self) { return self.fit_.used(); });
  fit("friction_results", "physics results that told the fit of the friction", Better::neither,
      [](const LocalPredictor& self) { return self.fit_.used_for_friction(); });
  fit("left_out", "physics results that the fit could not use", Better::neither, &LocalPredictor::left_out_of_fit_);
  fit("silent", "physics results whose force no contact known explains", Better::lower,
      [](const LocalPredictor& self) { return self.fit_.unexplained(); });
  fit("surprises", "physics results beyond three standard deviations", Better::lower,
      [](const LocalPredictor& self) { return self.fit_.surprises(); });
  fit("resets", "times that the fit began anew", Better::lower,
      [](const LocalPredictor& self) { return self.fit_.resets(); });
}

NodeInfo LocalPredictor::declare() {
  Declare<LocalPredictor> node("prediction.local",
                               "Simulates the tool from each physics result to now, against the contacts around it.");
  node.details(
          "A physics result is late by its computing time, and the hand has moved on. The force depends only on the "
          "bodies at the result's stamp, the spring to the handle and the contacts around the bodies, and the device's "
          "motion since then is known. So the node takes each result at its stamp and moves it on through the real "
          "samples of the handle, by the same step that the dynamics takes. interpolation.rollout continues from there "
          "tick by tick. Two things stay unknown: the motion of the next tick, and what the contacts do not tell. That "
          "is how surfaces bend (each contact is known at several anchors, with curvature) and where the set of "
          "contacts ends.\nWith the edge `dynamics.expected -> collision.expected`, collision searches contacts where "
          "the tool is by now and not where it last was. This makes them a period younger.\nWith the edge "
          "`dynamics.state -> local.state`, the node compares the contact force of physics with that of the known "
          "contacts. A Kalman filter of two numbers, a scale of stiffness and damping and an excess of friction, "
          "corrects the tool's contacts before they are used and sent on. A sticking contact gives only a lower bound "
          "of the friction; without contact nothing is learnt or forgotten. The report has the estimate at the end "
          "(`local.fit.stiffness_scale`, `local.fit.friction_excess`).\nThe node takes as long for a result as a few "
          "dozen steps; it is not for the real-time lane. Coupling, contact law and sub-steps are those of "
          "dynamics.\nThe method is this project's own. Going back to the stamp comes from the Smith predictor (O. "
          "Smith, 1957), and local models of the contact from Y. Adachi, T. Kumano, K. Ogino (1995) and W. Mark et al. "
          "(1996).")
      .input("bodies", &LocalPredictor::bodies,
             {.doc = "the moving bodies of a physics result, as dynamics sends them", .trigger = Trigger::yes})
      .input("contacts", &LocalPredictor::contacts,
             {.doc = "the contacts around the bodies; without this input, those of `found`", .required = false})
      .input(
          "found", &LocalPredictor::found,
          {.doc = "the contacts that came with the result, each with its law, from physics that tells them, such as "
                  "physics.external. They are used as planes where nothing feeds `contacts`; without either, nothing "
                  "touches. A result without a set of the same time is refused, so physics sends an empty set where "
                  "nothing touches",
           .required = false,
           .queue = {QueuePolicy::drop_oldest, 8}})
      .input("patch", &LocalPredictor::patch,
             {.doc = "the deformable surface around the tool from the same result, as dynamics.deformable sends it",
              .required = false})
      .needed_when(something_deforms)
      .unneeded_when(nothing_deforms)
      .input("used", &LocalPredictor::used,
             {.doc = "the contacts that dynamics uses, for the fit; without this input, the fit uses `contacts`. Meant "
                     "for dynamics with `advance_to: contacts`",
              .required = false,
              .queue = {QueuePolicy::drop_oldest, 8}})
      .ignored_when([](const Params& p) {
        return p.fit ? std::string() : std::string("fit is false: contacts are used as they come");
      })
      .input("state", &LocalPredictor::state,
             {.doc = "the contact force of the same result, as dynamics sends it, for the fit", .required = false})
      .ignored_when([](const Params& p) {
        return p.fit ? std::string() : std::string("fit is false: contacts are used as they come");
      })
      .input("coupling", &LocalPredictor::coupling, {.doc = "the spring and damper between handle and tool"})
      .input("device", &LocalPredictor::device,
             {.doc = "every sample of the handle", .queue = {QueuePolicy::drop_oldest, 2048}})
      .output("model", &LocalPredictor::model,
              "the bodies by now and the contacts to continue from, with the stamp of the result")
      .boolean(
          "resimulate", &Params::resimulate, true,
          "move each result on from its stamp to now; false, for comparison: use the bodies as they were at the stamp")
      .boolean("curvature", &Params::curvature, true,
               "use the curvature of contacts; false, for comparison: use planes")
      .boolean("fit", &Params::fit, true,
               "if `state` is connected, learn from physics' contact force how stiff and rough contacts are")
      .real("min_step", &Params::min_step,
            {.doc = "samples of the handle that are closer in time than this to the last step are skipped, except the "
                    "newest",
             .unit = "s",
             .default_value = 9e-4,
             .min = 0,
             .max = 0.01})
      .unneeded(nothing_moves)
      .role(Role::prediction);
  declare_scales(node);
  declare_rollout(node);
  declare_patch_contacts(node);
  declare_metrics(node);
  return node.formerly("coupling", "law").coarser("curvature", {false}).coarser("resimulate", {false}).info();
}

LocalPredictor::LocalPredictor(const Params& params, const NodeContext& context)
    : params_(params),
      soft_(patch_contacts(params, context)),
      rollout_(rollout_model("prediction.local", params, context), nullptr, soft_.get()),
      modes_(soft_ == nullptr ? nullptr : std::make_unique<ArrayPool<PatchMode>>(most_models, LocalPatch::most_modes)),
      fit_(rollout_.tool_rotates(), params.stick_velocity,
           {.scale_all = params.stiffness_scale, .friction_scale_all = params.friction_scale}) {
  start_.law_unknown = context.foreign_physics ? 1 : 0;
}

/// Puts the contacts into the start. False where those of the result have not come.
bool LocalPredictor::take_contacts(Time result) {
  start_.contacts.count = 0;
  start_.contacts.anchors = 0;
  if (!contacts.connected()) {
    if (!take_found(result)) return false;
  } else if (contacts.latest() != nullptr) {
    start_.contacts = contacts.latest()->value;
  }
  // A count of no message is for restart to refuse.
  if (start_.contacts.count < 0 || start_.contacts.count > LocalContacts::capacity) return true;
  for (std::size_t i = 0; i < static_cast<std::size_t>(start_.contacts.count); ++i) {
    for (Contact& c : start_.contacts.contact[i]) {
      if (!params_.curvature) c.H_W = {};
    }
  }
  return true;
}

/// Puts the contacts that came with the result into the start, each known at one anchor: where the bodies then were.
bool LocalPredictor::take_found(Time result) {
  if (!found.connected()) return true;
  const ContactSet* set = found_sets_.at(result);
  if (set != nullptr) take_told(*set, start_.contacts);
  start_.contacts_told = 1;
  return set != nullptr;
}

/// Puts what deforms into the start. False where it is not there, or not of the result of that time.
bool LocalPredictor::take_patch(Time result) {
  if (soft_ == nullptr) return true;
  const Stamped<LocalPatch>* newest = patch.latest();
  if (newest == nullptr || newest->stamp.valid != result) return false;
  start_.patch = newest->value;
  return true;
}

/// Sends where the rollout is; false where readers hold all arrays.
bool LocalPredictor::send(Time result) {
  if (!params_.resimulate || rollout_.patch() == nullptr) {
    model.send(result, params_.resimulate ? rollout_.model() : start_);
    return true;
  }
  const auto modes =
      modes_->make(start_.patch.modes.size(), [&](std::span<PatchMode> to) { rollout_.patch()->write(to); });
  if (!modes) return false;
  LocalModel moved = rollout_.model();
  moved.patch.modes = *modes;
  model.send(result, moved);
  return true;
}

/// Number of the sample to step to from where the rollout is: the first from `sample` on that is far enough in time, or
/// the newest.
std::size_t LocalPredictor::next_step(std::size_t sample) const {
  const Time from = rollout_.model().time;
  while (sample + 1 < track_.count() && track_[sample].stamp.valid - from < params_.min_step) ++sample;
  return sample;
}

const ContactSet* ContactSetTrack::of(Time result) const {
  const Stamped<ContactSet>* found = nullptr;
  for (std::size_t i = 0; i < std::min(taken_, sets_.size()); ++i) {
    const Stamped<ContactSet>& set = sets_[i];
    if (set.stamp.valid < result) continue;
    if (found == nullptr || set.stamp.valid < found->stamp.valid) found = &set;
  }
  return found == nullptr ? nullptr : &found->value;
}

const ContactSet* ContactSetTrack::at(Time result) const {
  for (std::size_t i = 0; i < std::min(taken_, sets_.size()); ++i) {
    if (sets_[i].stamp.valid == result) return &sets_[i].value;
  }
  return nullptr;
}

/// Learns from the result, which must be one that the rollout accepts, how its contacts are to be corrected.
void LocalPredictor::fit_contacts(const Stamped<BodyStates>& result) {
  start_.correction = fit_.correction();
  start_.law_error = 0;
  // Of the contact force, what deforms has its part, which no plane explains.
  if (!params_.fit || !state.connected() || soft_ != nullptr) return;
  const Stamped<PhysicsState>* physics = state.latest();
  if (physics == nullptr || physics->stamp.valid != result.stamp.valid || physics->value.damped != 0) {
    ++left_out_of_fit_;
  } else {
    const bool massless = start_.coupling.massless != 0;
    const Wrench& felt = physics->value.contact_T_W;
    const int touching = physics->value.contacts;
    const ContactSet* set = used.connected() ? used_sets_.of(result.stamp.valid) : nullptr;
    const Twist acceleration = rollout_.acceleration_of(physics->value, start_.coupling);
    const FitOutcome outcome =
        set != nullptr
            ? fit_.take(result.stamp.valid, contact_planes(*set), result.value, massless, felt, touching, acceleration)
            : fit_.take(result.stamp.valid, start_.contacts, result.value, massless, felt, touching, acceleration);
    const bool compared = outcome != FitOutcome::unusable && outcome != FitOutcome::repeated;
    if (compared) start_.law_error = fit_.law_error();
    if (!compared) ++left_out_of_fit_;
  }
  start_.correction = fit_.correction();
}

void LocalPredictor::step(StepContext&) {
  track_.take(device);
  found_sets_.take(found);
  used_sets_.take(used);
  const Stamped<BodyStates>* result = bodies.latest();
  const Stamped<CouplingParameters>* spring = coupling.latest();
  if (result == nullptr || spring == nullptr || track_.count() == 0) return;
  const RefusalReason refusal = take_result(*result, spring->value);
  if (refusal == RefusalReason::too_many) {
    refused_.count_too_many(start_.contacts.count, LocalContacts::capacity);
  } else {
    refused_.count(refusal);
  }
}

/// Sends the model of the result, brought on to the newest sample; or why not.
RefusalReason LocalPredictor::take_result(const Stamped<BodyStates>& result, const CouplingParameters& spring) {
  const std::size_t later = track_.after(result.stamp.valid);
  start_.time = result.stamp.valid;
  start_.device = track_.at(result.stamp.valid, rollout_.tool_rotates());
  start_.bodies = result.value;
  start_.p_WT_result = result.value.X_WB[0].p;
  start_.coupling = spring;
  // As dynamics stepped, whatever the spring would be for a tool with mass.
  if (result.value.massless != 0) start_.coupling.massless = 1;
  start_.wrench_result = coupling_wrench(start_.coupling,
                                         {.X_WT = start_.bodies.X_WB[0],
                                          .V_WT = start_.bodies.V_WB[0],
                                          .X_WD = start_.device.X_WD,
                                          .V_WD = start_.device.V_WD},
                                         rollout_.tool_rotates());
  if (!take_contacts(result.stamp.valid) || !take_patch(result.stamp.valid)) return RefusalReason::incomplete;
  if (const RefusalReason refusal = rollout_.refusal(start_); refusal != RefusalReason::none) return refusal;
  fit_contacts(result);
  rollout_.restart(start_);
  if (params_.resimulate) {
    for (std::size_t k = later; k < track_.count(); ++k) {
      k = next_step(k);
      // What goes on from a step that failed is nobody's truth; the display goes on with the model before.
      if (!rollout_.advance(track_[k])) return RefusalReason::unsolved;
      ++resimulated_;
    }
  } else {
    start_.time = track_.newest().stamp.valid;
    start_.device = track_.newest().value;
  }
  if (!send(result.stamp.valid)) return RefusalReason::incomplete;
  ++results_;
  return RefusalReason::none;
}

}  // namespace tactor
