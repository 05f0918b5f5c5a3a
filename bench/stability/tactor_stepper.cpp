// The project's dynamics node as a stepper.
#include "bench/stability/stepper.hpp"
#include "framework/node/info.hpp"
#include "nodes/dynamics/rigid.hpp"
#include "nodes/dynamics/translation.hpp"

namespace tactor::bench {

namespace {

class TactorStepper final : public Stepper {
 public:
  TactorStepper(const Trial& trial, Duration period, bool as_made)
      : trial_(trial),
        context_{.name = "dynamics", .scene = &trial.scene, .torque = trial.scene.rotates()},
        info_(context_.torque ? RigidDynamics::declare() : TranslationDynamics::declare()) {
    std::vector<ParamValue> values;
    for (const ParamInfo& p : info_.params) {
      values.push_back(as_made && p.name == "dissipate_above" ? ParamValue(1e6) : p.default_value.value());
    }
    node_ = info_.create(values, context_);
    dynamics_ = static_cast<DynamicsNode*>(node_.get());
    dynamics_->contacts.configure({});
    dynamics_->device.configure({QueuePolicy::drop_oldest, 4096});
    dynamics_->coupling.configure({});
    dynamics_->coupling.push({}, &trial.coupling);
    sample_ = std::min(period, Duration{1'000'000});
    push(Time{}, Time{});
    step(Time{});
  }

  // A graph gives the node all samples of a period at once. Given one by one it takes the same sub-steps, and shows the
  // states between.
  void advance(const ContactSet& set, Time until, std::vector<Reached>& reached) override {
    dynamics_->contacts.push({until, until, 0}, &set);
    while (now_ < until) {
      const Time next = now_ + sample_;
      const DeviceState device = push(next, now_);
      now_ = next;
      reached.push_back({next, device, step(until)});
    }
  }

  void report(Finding& finding) const override {
    Report report;
    report.ask(*dynamics_, "dynamics", info_.metrics);
    for (const auto& [name, value] : report.metrics()) {
      if (name == "dynamics_damped_steps") finding.damped_steps = static_cast<std::int64_t>(value);
      if (name == "dynamics_stopped_steps") finding.stopped_steps = static_cast<std::int64_t>(value);
    }
  }

 private:
  DeviceState push(Time t, Time before) {
    const DeviceState device = trial_.hand.at(t, before);
    dynamics_->device.push({t, t, 0}, &device);
    return device;
  }

  BodyStates step(Time until) {
    dynamics_->state.clear_pending();
    dynamics_->bodies.clear_pending();
    StepContext context(until);
    node_->step(context);
    TACTOR_DEMAND(dynamics_->bodies.pending() == 1);
    return *static_cast<const BodyStates*>(dynamics_->bodies.pending_value(0));
  }

  const Trial& trial_;
  NodeContext context_;
  NodeInfo info_;
  std::unique_ptr<Node> node_;
  DynamicsNode* dynamics_ = nullptr;
  Duration sample_;
  Time now_;
};

}  // namespace

std::unique_ptr<Stepper> make_tactor(const Trial& trial, Duration period, bool as_made) {
  return std::make_unique<TactorStepper>(trial, period, as_made);
}

}  // namespace tactor::bench
