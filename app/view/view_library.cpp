// Finds and loads the library of the view, so that a run that nobody looks at loads no server.
#include "app/view/view_server.hpp"
#include "framework/node/plugin.hpp"

namespace tactor {

const ViewLibrary& load_view_library() {
  static const ViewLibrary& library =
      load_plugin<ViewLibrary>("libtactor_view.so", "tactor_view_library",
                               "this build has no view (install node and npm, and configure and build again)");
  return library;
}

}  // namespace tactor
