// Lines that delay: what the motors truly gave, what the line counts, and what the run says of it.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <string>
#include <vector>

#include "app/run/headline.hpp"
#include "tests/support/page_text.hpp"
#include "tests/support/shipped_graphs.hpp"

BOOST_AUTO_TEST_SUITE(delayed_line_test)

using namespace tactor;
using namespace tactor::test;

namespace {

struct Delays {
  const char* in;
  const char* out;
};
constexpr Delays lines[]{{"0 s", "0 s"}, {"0 s", "1 ms"}, {"1 ms", "1 ms"}, {"2 ms", "2 ms"}};

/// A wall of 6,400 N/m in a light hand, whose port a stage or a line of waves keeps passive where nothing delays.
RunResult run_with(const Delays& line, const Over& more) {
  const Over over{"duration=4 s",
                  "device.hand_mass=0.15 kg",
                  "scene.bodies.wall.material.stiffness=100 N/mm",
                  "scene.bodies.tool.material.stiffness=100 N/mm",
                  std::string("device.delay_in=") + line.in,
                  std::string("device.delay_out=") + line.out};
  return run(planned("wall/closed_loop.yaml", over + more), {}, {.without_reference = true});
}

const Over stiff{"methods/hold.yaml", "passivity/energy_bound.yaml", "coupling.k_t=6400 N/m"};
const Over waves{"passivity/waves.yaml"};

std::string verdict(const RunResult& result) {
  for (const HeadlineLine& line : headline(result)) {
    if (line.name == "verdict") return line.text;
  }
  return {};
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_line_counts_what_the_motors_gave_and_the_verdict_is_its) {
  for (const Over& over : {stiff, waves}) {
    int active = 0;
    for (const Delays& line : lines) {
      BOOST_TEST_CONTEXT("in " << line.in << ", out " << line.out) {
        const RunResult found = run_with(line, over);
        // By the motors' own sub-steps.
        const double given = found.metric("device.energy_generated_J");
        const double counted = found.metric("device.line.energy_generated_J");
        const double allowed = found.metric("device.line.energy_allowed_J");
        near(counted, given, 0.1 * allowed + 0.01 * given);
        const bool passive = given <= allowed;
        says(verdict(found), passive ? ", port passive" : ", port not passive: it gave");
        active += passive ? 0 : 1;
        // The port's own count knows nothing of a delay, so that it tells no verdict there.
        BOOST_TEST(std::isfinite(found.metric("stability.passive")) == (line.in[0] == '0' && line.out[0] == '0'));
      }
    }
    BOOST_TEST(active >= 2);
  }
}

BOOST_AUTO_TEST_CASE(a_bound_on_the_line_holds_whatever_it_delays) {
  for (const Over& over : {stiff, waves}) {
    for (const Delays& line : lines) {
      BOOST_TEST_CONTEXT("in " << line.in << ", out " << line.out) {
        const RunResult found = run_with(line, over + Over{"device.energy_bound=true"});
        BOOST_TEST(found.metric("device.energy_generated_J") <= found.metric("device.line.energy_allowed_J"));
        says(verdict(found), ", port passive");
      }
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
