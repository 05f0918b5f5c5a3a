// Descriptors of devices stay with the process that opened them: a child that kept one would keep the device's line
// open when its parent has ended, and the device would not see that end.
#pragma once

namespace tactor {

/// No child is forked while one of these lives: who forks waits. It is held from before a descriptor is opened until
/// `keep_from_children`, for a second at most, and its thread starts no process meanwhile. A thread may hold several.
class NoFork {
 public:
  NoFork();
  NoFork(const NoFork&) = delete;
  NoFork& operator=(const NoFork&) = delete;
  ~NoFork();
};

/// From now on this descriptor is closed in the child of every fork(), and where the process executes another program.
/// A child that a program makes by the system call clone, without the C library, has it all the same.
void keep_from_children(int descriptor);
/// The end of that; a `NoFork` is held until the descriptor is closed. False, and nothing happens, where it is not
/// kept.
bool forget_descriptor(int descriptor);
/// Forgets and closes it. Nothing happens where it is not kept: in a child the number may be another file's by now.
void close_kept(int descriptor);

}  // namespace tactor
