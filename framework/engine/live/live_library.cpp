// Loads the live engine, so that a run under the virtual clock never loads the actor framework.
#include "framework/engine/live/live_library.hpp"
#include "framework/core/check.hpp"
#include "framework/node/plugin.hpp"

namespace tactor {

const LiveLibrary& load_live_library() {
  static const LiveLibrary& library =
      load_plugin<LiveLibrary>("libtactor_live.so", "tactor_live_library",
                               "clock: real: there is no live engine; build it with scripts/build release tactor "
                               "(options: -DTACTOR_WITH_CAF=ON), or use clock: virtual");
  return library;
}

}  // namespace tactor
