// The folders in which the program keeps files of the user between two runs.
#pragma once

#include <filesystem>

namespace tactor {

/// For what the user adds, such as nodes: $XDG_DATA_HOME/tactor, or ~/.local/share/tactor.
std::filesystem::path user_data_folder();

/// For what can be computed again: $TACTOR_CACHE, or $XDG_CACHE_HOME/tactor, or ~/.cache/tactor.
std::filesystem::path default_cache_folder();

/// For what must be found again by the next command: $XDG_STATE_HOME/tactor, or ~/.local/state/tactor.
std::filesystem::path state_folder();

/// For what is lost when the machine is switched off: $XDG_RUNTIME_DIR/tactor, or the folder of the state.
std::filesystem::path runtime_folder();

// `~` is $HOME, or the home folder of the user's entry in the password database. Variables of XDG and HOME that are not
// absolute count as not set. A path is empty where none of these is known: no folder stands in for it, because in the
// folder for temporary files another user may have made one of the same name. See KeptFolder for how they are opened.

}  // namespace tactor
