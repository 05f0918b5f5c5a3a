// The metrics of what a hand notices of the delivered force's error.
#pragma once

#include <span>

#include "framework/core/spatial.hpp"
#include "framework/node/declare.hpp"

namespace tactor {

class Metrics;

/// Declares delivered.force.share_beyond_weber and those of vibration.
void declare_felt_metrics(Declare<Metrics>& node);

/// Tells them of a judged interval, as declared: forces x_i and reference_i in N, `rate_Hz` samples a second, on a
/// handle of `handle_mass` kg.
void report_felt(Report& report, std::span<const Vec3> x, std::span<const Vec3> reference, double rate_Hz,
                 double handle_mass);

}  // namespace tactor
