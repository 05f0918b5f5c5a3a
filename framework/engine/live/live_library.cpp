// Loads the live engine, so that a run under the virtual clock never loads the actor framework.
#include "framework/core/check.hpp"
#include "framework/engine/live/live_engine.hpp"
#include "framework/node/own_library.hpp"

namespace tactor {

namespace {

const LiveLibrary& load() {
  constexpr const char* file_name = "libtactor_live.so";
  const auto entry = reinterpret_cast<decltype(&tactor_live_library)>(load_from_own_library(
      file_name, "tactor_live_library",
      "clock: real: this build has no live engine (configure with -DTACTOR_WITH_CAF=ON, or use clock: virtual)"));
  const LiveLibrary* library = entry(TACTOR_LIVE_ABI);
  if (library == nullptr)
    throw InputError(std::string(file_name) + " belongs to another build of tactor; build it again");
  return *library;
}

}  // namespace

const LiveLibrary& load_live_library() {
  static const LiveLibrary& library = load();
  return library;
}

}  // namespace tactor
