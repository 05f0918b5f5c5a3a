#include "tests/fault_nodes/passing.hpp"

#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <optional>
#include <stdexcept>
#include <thread>
#include <vector>

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

namespace {

// Told as the process ends, so that no compiler takes the stack away.
volatile int depth = 0;
// Read again each time, so that no compiler knows where it leads.
int* volatile nowhere = nullptr;

int run_over() {
  volatile int here[1024] = {};
  depth = depth + 1;
  const int deeper = depth > 0 ? run_over() : 0;  // it always is
  return deeper + here[7];
}

}  // namespace

void Aborts::Params::go_wrong() const {
  if (!once.empty()) {
    if (std::ifstream(once)) return;
    std::ofstream(once) << "once\n";
  }
  switch (by) {
    case By::abort:
    case By::planning:
      std::abort();
    case By::segv:
      *nowhere = 1;
      break;
    case By::overflow:
      std::exit(run_over());
    case By::kill:
      raise(SIGKILL);
      break;
    case By::exit:
      std::_Exit(3);
    case By::hang:
      for (;;) pause();
  }
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
      .output("out", &Aborts::out, "what came in")
      .choice(
          "by", &Params::by,
          {{"abort", By::abort},
           {"overflow", By::overflow},
           {"kill", By::kill},
           {"exit", By::exit},
           {"hang", By::hang},
           {"planning", By::planning},
           {"segv", By::segv}},
          std::optional(By::abort),
          "abort: as a broken belief does; overflow: its stack runs over; kill: SIGKILL; exit: exit code 3; hang: it "
          "sleeps for ever; planning: as abort, while the run is planned; segv: it writes where no memory is")
      .check([](const Params& params, const NodeContext&) {
        if (params.by == By::planning) params.go_wrong();
      })
      .text("once", &Params::once, "",
            "a file: made where it is missing, and where it is there nothing happens; empty: "
            "it goes wrong every time");
  declare_when(declaration);
  return declaration.info();
}

void Aborts::step(StepContext& context) {
  if (params_.is_now(context.now())) params_.go_wrong();
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
