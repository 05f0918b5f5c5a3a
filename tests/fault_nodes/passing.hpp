// Nodes that pass on what they get and go wrong once: they stall, throw, end the process, or send what is not finite.
#pragma once

#include <string>

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"

namespace tactor::fault {

/// When a node goes wrong, in time of the run: from `at` on, for `lasts`.
struct When {
  Duration at;
  Duration lasts;
  [[nodiscard]] bool is_now(Time now) const { return now >= Time{} + at && now < Time{} + at + lasts; }
};

/// Declares `at` and `lasts`, in s, of the parameters of N, which derive from When.
template <class N>
void declare_when(Declare<N>& declaration) {
  using P = typename N::Params;
  declaration
      .real("at", static_cast<Duration P::*>(&When::at),
            {.doc = "when it goes wrong", .unit = "s", .default_value = 1, .min = 0})
      .real("lasts", static_cast<Duration P::*>(&When::lasts),
            {.doc = "for how long", .unit = "s", .default_value = 0.5, .min = 0});
}

/// The first step after `at` takes `lasts`, asleep or computing.
class Stall final : public Node {
 public:
  struct Params : When {
    bool computes = false;
  };
  Stall(const Params& params, const NodeContext&) : params_(params) {}
  static NodeInfo declare();
  void step(StepContext& context) override;

  Input<PhysicsState> in;
  Output<PhysicsState> out;

 private:
  Params params_;
  bool done_ = false;
};

/// Throws at its first step after `at`.
class Throws final : public Node {
 public:
  using Params = When;
  Throws(const Params& params, const NodeContext&) : params_(params) {}
  static NodeInfo declare();
  void step(StepContext& context) override;

  Input<Wrench> in;
  Output<Wrench> out;

 private:
  Params params_;
};

/// Ends the process at its first step after `at`, or does not come back from it; or ends it while a run is planned.
class Aborts final : public Node {
 public:
  enum class By { abort, overflow, kill, exit, hang, planning, segv };
  struct Params : When {
    By by = By::abort;
    std::string once;
    void go_wrong() const;
  };
  Aborts(const Params& params, const NodeContext&) : params_(params) {}
  static NodeInfo declare();
  void step(StepContext& context) override;

  Input<Wrench> in;
  Output<Wrench> out;

 private:
  Params params_;
};

/// Sends forecasts whose forces are NaN and infinite in turn.
class NotFinite final : public Node {
 public:
  using Params = When;
  NotFinite(const Params& params, const NodeContext&) : params_(params) {}
  static NodeInfo declare();
  void step(StepContext& context) override;

  Input<Forecast> in;
  Output<Forecast> out;

 private:
  Params params_;
  bool infinite_ = false;
};

}  // namespace tactor::fault
