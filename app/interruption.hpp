// Whether somebody has asked the command to end, and which signals ask.
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

/// From now on these signals end the program at once. If one came before, the program ends now. For long work that does
/// not look for signals and has nothing to save.
void stop_listening_for_interruption();

/// So does every other signal from now on that would end or stop the program and that a program can handle. To be
/// called before a device is opened: a live run must not end or stop on the spot, because its device would go on with
/// the last force that it got. A pipe that nobody reads makes a write fail, and ends nothing by itself.
void ramp_down_on_signals();

}  // namespace tactor
