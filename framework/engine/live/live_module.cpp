// What libtactor_live.so exports.
#include "framework/engine/live/live_engine.hpp"
#include "framework/engine/live/live_library.hpp"
#include "framework/node/abi.hpp"
#include "tactor_abi.hpp"

TACTOR_STATES_ABI;

extern "C" __attribute__((visibility("default"))) const tactor::LiveLibrary* tactor_live_library() {
  static const tactor::LiveLibrary library{
      [](const tactor::Plan& plan, const tactor::EngineOptions& options) -> std::unique_ptr<tactor::Engine> {
        return std::make_unique<tactor::LiveEngine>(plan, options);
      }};
  return &library;
}
