// Short texts for queues, costs and parameter values, shared by what prints graphs.
#pragma once

#include <string>

#include "framework/graph/spec.hpp"

namespace tactor {

/// As graphs write it: `latest`, `queue(64, drop_oldest)`.
std::string queue_text(const Queue& queue);
/// `none`, `5 ms`, `6 ms + 0.5 ms a contact, jitter 10 %`.
std::string cost_text(const CostModel& cost);
/// `5 ms`, `10 s`, `until stopped`.
std::string duration_text(Duration duration);
/// `6 degrees of freedom`, `translation-only`, `nothing moves`.
std::string motion_text(const Scene& scene);

}  // namespace tactor
