// What a run came to, in a few lines: the top of what the terminal shows at the end, and of the report.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "app/run/run.hpp"

namespace tactor {

/// What the user is to know before any metric: a privilege that the run lacked, messages that it dropped, steps of
/// dynamics that could not be solved, and what the nodes remark.
std::vector<std::string> warnings_of(const RunResult& result);

/// `no force: button 1 was never held`, for each device that no force reached, with its name where there are several;
/// empty where there is none. Of a blind run only what stood in the way, because the rest tells the condition.
std::string no_force_text(const RunResult& result);

struct HeadlineLine {
  std::string name;
  std::string text;
  std::string metric;  ///< the first metric of the text, which says what the name means; or empty
};

/// Verdict, error, what is felt of it, delay, smoothness, gate, run time and what was left out. A line of which the run
/// tells nothing is not there.
std::vector<HeadlineLine> headline(const RunResult& result);

/// What `tactor run` prints at the end: the name, the warnings, the headline, where the report is, and how to see `all`
/// where that is not asked for.
std::string headline_text(const RunResult& result, const std::string& report, bool all, std::size_t columns);

}  // namespace tactor
