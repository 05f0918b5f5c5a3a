// What libtactor_live.so exports.
#include "framework/engine/live/live_run.hpp"
#include "framework/node/abi.hpp"
#include "tactor_abi.hpp"

TACTOR_STATES_ABI;

extern "C" __attribute__((visibility("default"))) const tactor::LiveLibrary* tactor_live_library() {
  static const tactor::LiveLibrary library{[](const tactor::Plan& plan) -> std::unique_ptr<tactor::LiveEngine> {
    return std::make_unique<tactor::LiveRun>(plan);
  }};
  return &library;
}
