// The entry of libtactor_build.so.
#include "app/run/build_info.hpp"
#include "framework/node/abi.hpp"
#include "tactor_abi.hpp"
#include "tactor_build.hpp"

namespace {

constexpr tactor::BuildLibrary library{TACTOR_COMMIT, TACTOR_IS_DIRTY, TACTOR_COMPILER, TACTOR_FLAGS};

}  // namespace

TACTOR_STATES_ABI;

extern "C" __attribute__((visibility("default"))) const tactor::BuildLibrary* tactor_build_library() {
  return &library;
}
