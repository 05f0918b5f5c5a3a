// Trajectories of the benchmark, computed and never stored: poses of the tool in the frame of the fixed body.
#pragma once

#include <nlohmann/json.hpp>

#include "bench/collision/contender.hpp"

namespace tactor::bench {

/// A part of a trajectory: `count` samples, evenly from `begin` on, each `period` after the one before (s).
struct Samples {
  double begin = 0, period = 0.001;
  int count = 0;
};

/// Seven seconds of a tool that is pressed against the fixed body along z while it slides and turns. The slide, the
/// turn and the depth are sums of sines; at each sample the offset along z is solved so that the deepest vertex of
/// either body is as deep in the other as the profile says, 0 to `deepest` (m). Throws RunError where no offset does.
std::vector<Step> press_and_slide(const Pair& pair, const Samples& samples, double deepest = 0.002);
inline constexpr double press_and_slide_duration = 7;  // s

/// The way-points of graphs/peg_in_hole/scene.yaml, with minimum jerk between them.
std::vector<Step> insert_peg(const Samples& samples);
inline constexpr double insert_peg_duration = 8;  // s

/// Fills in what is inside what, by the reference.
void add_exact(Contender& reference, std::vector<Step>& steps);

/// The properties of a trajectory: speeds, depths, penetrating samples.
nlohmann::ordered_json describe(const std::vector<Step>& steps, double period);

}  // namespace tactor::bench
