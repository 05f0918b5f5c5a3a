// What is told of a scene whose physics cannot be measured, on a node that fails in its step.
#include <boost/test/unit_test.hpp>
#include <fstream>

#include "app/lean/physics_fit.hpp"
#include "framework/core/check.hpp"
#include "framework/core/messages.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/registry.hpp"

BOOST_AUTO_TEST_SUITE(physics_fit_test)

using namespace tactor;

namespace {

/// Moves bodies, and fails in the step after `good_steps`: with a RunError, or as bad input.
class Mover final : public Node {
 public:
  struct Params {
    double rate = 0;
    std::int32_t good_steps = 0;
    bool bad_input = false;
  };
  Mover(const Params& params, const NodeContext&) : params_(params) {}
  static NodeInfo declare() {
    return Declare<Mover>("test.mover", "Moves bodies.")
        .role(Role::dynamics)
        .output("out", &Mover::out, "")
        .rate("rate", &Params::rate, {.doc = "steps", .default_value = 1000})
        .integer("good_steps", &Params::good_steps, {.doc = "steps that do not fail", .default_value = 0})
        .boolean("bad_input", &Params::bad_input, false, "the failure is that of bad input")
        .info();
  }
  void step(StepContext& context) override {
    if (steps_++ < params_.good_steps) return out.send(context.now(), {});
    if (params_.bad_input) throw InputError("this cannot be moved");
    throw RunError("this cannot be moved");
  }
  Output<Wrench> out;

 private:
  Params params_;
  int steps_ = 0;
};

struct Listener final : Node {
  struct Params {};
  Listener(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Listener>("test.listener", "Listens.")
        .sink()
        .input("in", &Listener::in, {.trigger = Trigger::yes})
        .info();
  }
  void step(StepContext&) override {}
  Input<Wrench> in;
};

std::optional<PhysicsFit> measured(const std::string& mover) {
  const TemporaryFolder folder;
  Registry registry{{}};
  registry.add<Mover>();
  registry.add<Listener>();
  const auto file = folder.path() / "graph.yaml";
  std::ofstream(file) << "clock: virtual\nduration: 50 ms\nscene: {bodies: {}}\n"
                         "nodes: {mover: {type: test.mover, "
                      << mover << "}, listener: {type: test.listener}}\nedges: [mover.out -> listener.in]\n";
  return measure_physics_fit(make_plan(load_graph(file, registry)), [] { return false; });
}

}  // namespace

BOOST_AUTO_TEST_CASE(physics_that_fails_in_a_step_is_told_as_not_measured) {
  for (const char* bad_input : {"true", "false"}) {
    for (const int good_steps : {0, 5}) {
      const auto fit = measured("good_steps: " + std::to_string(good_steps) + ", bad_input: " + bad_input);
      BOOST_REQUIRE(fit.has_value());
      BOOST_TEST(fit->not_measured.find("this cannot be moved") != std::string::npos, fit->not_measured);
      BOOST_TEST(fit->nodes.empty());
      BOOST_TEST(!fit->fits());
      BOOST_TEST(text_of(*fit).find("was not measured: ") != std::string::npos);
    }
  }
}

BOOST_AUTO_TEST_CASE(physics_that_goes_on_is_measured) {
  const auto fit = measured("good_steps: 1000");
  BOOST_REQUIRE(fit.has_value());
  BOOST_TEST(fit->not_measured == "");
  BOOST_TEST(fit->nodes.size() == 1U);
}

BOOST_AUTO_TEST_SUITE_END()
