// What libtactor_view.so exports.
#include "app/view/foxglove/export_mcap.hpp"
#include "app/view/server/http_server.hpp"
#include "framework/node/abi.hpp"
#include "tactor_abi.hpp"

TACTOR_STATES_ABI;

extern "C" __attribute__((visibility("default"))) const tactor::ViewLibrary* tactor_view_library() {
  static const tactor::ViewLibrary library{tactor::make_http_server, tactor::export_mcap, tactor::view_files};
  return &library;
}
