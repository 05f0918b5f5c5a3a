#include "nodes/prediction/local.hpp"

#include <algorithm>

#include "nodes/mechanics/scene_model.hpp"

namespace tactor {

namespace {
SystemModel model_of(const LocalPredictor::Params& params, const NodeContext& context) {
  SystemModel model = scene_model("prediction.local", *context.scene, context.notes);
  model.iterations = params.iterations;
  model.stick_velocity = params.stick_velocity;
  return model;
}
}  // namespace

NodeInfo LocalPredictor::declare() {
  return Declare<LocalPredictor>("prediction.local", "Simulates from each physics result to now against its contacts.")
      .input("bodies", &LocalPredictor::bodies, {.doc = "where physics has the moving bodies", .trigger = Trigger::yes})
      .input("contacts", &LocalPredictor::contacts, {.doc = "the contacts around them", .required = false})
      .input("law", &LocalPredictor::law, {.doc = "the spring and damper between handle and tool"})
      .input("device", &LocalPredictor::device, {.doc = "every sample of the handle", .queue = {QueuePolicy::drop_oldest, 512}})
      .output("model", &LocalPredictor::model, "bodies and contacts to go on from")
      .output("expected", &LocalPredictor::expected, "where the bodies are by now")
      .integer<std::int32_t>("max_contacts", &Params::max_contacts, {.doc = "contacts kept", .default_value = 48, .min = 1, .max = LocalContacts::capacity})
      .integer<std::int32_t>("iterations", &Params::iterations, {.doc = "Newton iterations a step, at most", .default_value = 30, .min = 1, .max = 200})
      .real("stick_velocity", &Params::stick_velocity, {.doc = "sliding speed below which friction is viscous", .unit = "m/s", .default_value = 1e-4, .min = 0, .max = 1, .above_min = true})
      .boolean("resimulate", &Params::resimulate, true, "go back to the stamp of the result")
      .info();
}

LocalPredictor::LocalPredictor(const Params& params, const NodeContext& context)
    : params_(params), rollout_(model_of(params, context)) {}

void LocalPredictor::step(StepContext&) {
  Stamped<DeviceState> sample;
  while (new_states_.next(device, sample)) track_.push(sample);
  const Stamped<BodyStates>* result = bodies.latest();
  const Stamped<CouplingLaw>* spring = law.latest();
  if (result == nullptr || spring == nullptr || track_.size() == 0) return;
  // The handle at the result's stamp.
  std::size_t age = 0;
  while (age + 1 < track_.size() && track_[age].stamp.valid > result->stamp.valid) ++age;
  start_.time = result->stamp.valid;
  start_.device = track_[age].value;
  start_.bodies = result->value;
  start_.law = spring->value;
  start_.contacts.count = 0;
  if (contacts.connected() && contacts.latest() != nullptr) {
    start_.contacts = contacts.latest()->value;
    start_.contacts.count = std::min(start_.contacts.count, params_.max_contacts);
  }
  rollout_.restart(start_);
  if (params_.resimulate) {
    while (age > 0) rollout_.advance(track_[--age]);
    model.send(result->stamp.valid, rollout_.model());
  } else {
    LocalModel m = start_;
    m.time = track_[0].stamp.valid;
    m.device = track_[0].value;
    model.send(result->stamp.valid, m);
  }
  expected.send(rollout_.model().time, rollout_.model().bodies);
}

}  // namespace tactor
