// The `live` key of a graph: what a run with a real clock asks of the system and does where it does not get it.
#include "framework/fields/read_fields.hpp"
#include "framework/graph/live_fields.hpp"
#include "framework/graph/readers.hpp"

namespace tactor {

void check(LiveSettings& live, const FieldCheck& /*map*/) {
  if (live.pool.policy == SchedulingPolicy::other) live.pool.priority = 0;
}

LiveSettings read_live(const Tree& tree, const FileFinder& files, Diagnostics& diagnostics) {
  LiveSettings live;
  read_fields(tree, "live", live, files, diagnostics);
  return live;
}

}  // namespace tactor
