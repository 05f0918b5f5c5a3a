// What this machine offers to a real-time loop, tried and told: the verb `doctor`.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "framework/realtime/loop_trial.hpp"
#include "framework/realtime/system_findings.hpp"

namespace tactor {

/// The findings, and the loops that were tried.
struct Diagnosis {
  std::string kernel;
  std::vector<Finding> findings;
  std::vector<Finding> devices;  ///< whether devices can be reached; not part of the grade
  double rate = 1000;            ///< Hz, of the trials
  Duration length;               ///< of each trial
  std::vector<LoopTrial> trials;
  Duration bookkeeping;  ///< of the loop itself, a tick
};

/// Probes the machine and tries a loop of 1 kHz for `length`, four times: as a plain thread and as one that asks for
/// SCHED_FIFO, each alone and beside a computing thread on every core. Twice where asking would change nothing.
Diagnosis diagnose(Duration length);

/// For programs.
nlohmann::ordered_json to_json(const Diagnosis& diagnosis);

/// For people: at most 100 columns wide. `coloured` puts terminal colours on the grades.
std::string diagnosis_text(const Diagnosis& diagnosis, bool coloured);

}  // namespace tactor
