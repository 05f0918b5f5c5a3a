// Two nodes with a message type of their own between them: one spreads a force over a pad, the other looks for its
// peak.
#include <algorithm>
#include <cmath>
#include <span>

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/register_nodes.hpp"
#include "pad.hpp"

namespace example_nodes {

class Press final : public tactor::Node {
 public:
  struct Params {
    double width = 0.004;
  };
  Press(const Params& params, const tactor::NodeContext&) : width_(params.width) {}

  static tactor::NodeInfo declare() {
    return tactor::Declare<Press>("example.press", "Spreads a force over a pad, as a bell around its middle.")
        .input("force", &Press::force, {.doc = "the force on the pad", .trigger = tactor::Trigger::yes})
        .output("pad", &Press::pad, "what the pad feels")
        .real("width", &Params::width,
              {.doc = "of the bell", .unit = "m", .default_value = 0.004, .min = 1e-4, .max = 0.1})
        .info();
  }

  void step(tactor::StepContext&) override {
    const auto* message = force.latest();
    if (message == nullptr) return;
    constexpr int side = 8;
    constexpr double field = 0.002;  // m
    const double newton = tactor::norm(message->value.force);
    Pad felt;
    felt.force = newton;
    if (newton > 0 && !pressed_) pressed_since_ = message->stamp.valid;
    pressed_ = newton > 0;
    felt.pressed_since = pressed_since_;
    auto pressure = pool_.make(side * side, [&](std::span<float> fields) {
      const double peak = newton / (2 * 3.14159265358979 * width_ * width_);
      for (int i = 0; i < side * side; ++i) {
        const double x = (i % side - 3.5) * field, y = (i / side - 3.5) * field;
        fields[static_cast<std::size_t>(i)] =
            static_cast<float>(peak * std::exp(-(x * x + y * y) / (2 * width_ * width_)));
      }
    });
    if (!pressure) return;  // readers hold all arrays
    felt.pressure = *pressure;
    pad.send(message->stamp.valid, felt);
  }

  tactor::Input<tactor::Wrench> force;
  tactor::Output<Pad> pad;

 private:
  double width_;
  bool pressed_ = false;
  tactor::Time pressed_since_;
  tactor::ArrayPool<float> pool_{16, 64};
};

class Peak final : public tactor::Node {
 public:
  struct Params {};
  Peak(const Params&, const tactor::NodeContext&) {}

  static tactor::NodeInfo declare() {
    return tactor::Declare<Peak>("example.peak", "Tells the largest pressure of a run.")
        .sink()
        .input("pad", &Peak::pad, {.doc = "what the pad feels", .trigger = tactor::Trigger::yes})
        .metric("pressure_max", "Pa", "the largest pressure of a field", tactor::Better::neither, &Peak::peak_)
        .info();
  }

  void step(tactor::StepContext&) override {
    if (const auto* message = pad.latest()) {
      for (const float pressure : message->value.pressure) peak_ = std::max(peak_, static_cast<double>(pressure));
    }
  }

  tactor::Input<Pad> pad;

 private:
  double peak_ = 0;
};

}  // namespace example_nodes

TACTOR_NODES(registry) {
  registry.add<example_nodes::Press>();
  registry.add<example_nodes::Peak>();
}
