// The library of the live engine, which a run under the virtual clock does not load.
#pragma once

#include <memory>

#include "framework/engine/engine.hpp"

namespace tactor {

/// The functions of the library of the live engine.
struct LiveLibrary {
  /// Makes the nodes of a plan, which must outlive the run. Throws InputError with the node's name where a node refuses
  /// its input, where a node asks for a core that this machine does not have, and where hardware has no dead-man button
  /// and the options do not do without one; RunError where the system refuses a
  /// privilege and the graph says `on_missing_privilege: fail`.
  std::unique_ptr<Engine> (*make)(const Plan& plan, const EngineOptions& options);
};

/// Loads libtactor_live.so, once: a run under the virtual clock never loads the actor framework. Throws InputError
/// where it is not there: then the build has no live engine.
const LiveLibrary& load_live_library();

}  // namespace tactor

/// The one symbol that libtactor_live.so exports; null where the caller is of another build.
extern "C" const tactor::LiveLibrary* tactor_live_library();
