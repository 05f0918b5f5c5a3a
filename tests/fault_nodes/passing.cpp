#include "tests/fault_nodes/passing.hpp"

#include <chrono>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <thread>

namespace tactor::fault {

NodeInfo Stall::declare() {
  Declare<Stall> declaration("fault.stall", "Passes states of the physics on, and once takes far too long.");
  declaration.input("in", &Stall::in, {.doc = "what it passes on", .trigger = Trigger::yes})
      .output("out", &Stall::out, "what came in")
      .boolean("computes", &Params::computes, false, "true: it computes all the while; false: it sleeps");
  declare_when(declaration);
  return declaration.info();
}

void Stall::step(StepContext& context) {
  if (!done_ && context.now() >= Time{} + params_.at) {
    done_ = true;
    const auto until = std::chrono::steady_clock::now() + std::chrono::nanoseconds(params_.lasts.ns);
    if (!params_.computes) std::this_thread::sleep_until(until);
    while (std::chrono::steady_clock::now() < until) {
    }
  }
  out.send(in.latest()->stamp.valid, in.latest()->value);
}

NodeInfo Throws::declare() {
  Declare<Throws> declaration("fault.throws", "Passes wrenches on, and throws.");
  declaration.input("in", &Throws::in, {.doc = "what it passes on", .trigger = Trigger::yes})
      .output("out", &Throws::out, "what came in");
  declare_when(declaration);
  return declaration.info();
}

void Throws::step(StepContext& context) {
  if (params_.is_now(context.now())) throw std::runtime_error("it broke on purpose");
  out.send(in.latest()->stamp.valid, in.latest()->value);
}

NodeInfo Aborts::declare() {
  Declare<Aborts> declaration("fault.aborts", "Passes wrenches on, and ends the process.");
  declaration.input("in", &Aborts::in, {.doc = "what it passes on", .trigger = Trigger::yes})
      .output("out", &Aborts::out, "what came in");
  declare_when(declaration);
  return declaration.info();
}

void Aborts::step(StepContext& context) {
  if (params_.is_now(context.now())) std::abort();
  out.send(in.latest()->stamp.valid, in.latest()->value);
}

NodeInfo NotFinite::declare() {
  Declare<NotFinite> declaration("fault.not_finite", "Passes forecasts on, for a while with NaN and infinity in them.");
  declaration.input("in", &NotFinite::in, {.doc = "what it passes on", .trigger = Trigger::yes})
      .output("out", &NotFinite::out, "what came in, or not");
  declare_when(declaration);
  return declaration.info();
}

void NotFinite::step(StepContext& context) {
  Forecast forecast = in.latest()->value;
  if (params_.is_now(context.now())) {
    infinite_ = !infinite_;
    forecast.current_D_W.force.x = infinite_ ? std::numeric_limits<double>::infinity() : 0.0;
    forecast.predicted_D_W[0].force.y = std::numeric_limits<double>::quiet_NaN();
  }
  out.send(in.latest()->stamp.valid, forecast);
}

}  // namespace tactor::fault
