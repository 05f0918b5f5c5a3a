// Makes the show of a recording, or of a graph run in virtual time.
#pragma once

#include <filesystem>

#include "app/view/show.hpp"

namespace tactor {

class Registry;
struct GraphSpec;

/// What a recording shows. Its run is made again, which gives all streams and the reference, where that comes out equal
/// in all that was recorded; else what was recorded is shown alone, and a note says why. `reference`: with the
/// reference. Throws InputError where it is no recording, or its graph cannot be loaded here.
Show show_of_recording(const std::filesystem::path& recording, Registry& registry, bool reference,
                       const ShowOptions& options);

/// What a run of the graph under the virtual clock shows.
Show show_of_graph(GraphSpec graph, Registry& registry, bool reference, const ShowOptions& options);

}  // namespace tactor
