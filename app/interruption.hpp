// Whether somebody has asked the command to end.
#pragma once

#include <atomic>

namespace tactor {

/// How often signals have asked; read by several threads. Not 0 once the command is to end.
extern std::atomic<int> interruption;

inline bool is_interrupted() {
  return interruption != 0;
}

/// From now on Ctrl-C, SIGTERM and a terminal that closes count in `interruption`. To be called first.
void listen_for_interruption();

/// So do Ctrl-Z and Ctrl-\ from now on. A live run must not be stopped on the spot, nor end there: its device would go
/// on with the last force that it got.
void end_instead_of_stopping();

}  // namespace tactor
