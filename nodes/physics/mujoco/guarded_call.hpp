// Keeps MuJoCo's fatal errors from ending the process.
#pragma once

#include <array>

namespace tactor {

/// MuJoCo's own words.
using MujocoText = std::array<char, 256>;

/// Calls `work(argument)`. False where MuJoCo met a fatal error in it, told in `text`; its data are then in no usable
/// state. `text` also gets a warning, and is empty where there is neither. MuJoCo's handler of fatal errors must not
/// return, and an exception must not pass through C, so that the handler jumps back here: between here and the call of
/// MuJoCo nothing may have a destructor. Allocates nothing of its own.
bool call_guarded(MujocoText& text, void (*work)(void*), void* argument);

}  // namespace tactor
