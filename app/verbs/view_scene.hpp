// What `tactor view` does with a graph, for other verbs.
#pragma once

#include <filesystem>

namespace tactor {

struct PageOptions;

/// Shows the graph live in the browser, with its tool on the mouse, until somebody ends it. Returns the exit code.
/// Throws InputError before anything moves, also where this build has no view.
int view_by_mouse(const std::filesystem::path& graph, const PageOptions& page);

}  // namespace tactor
