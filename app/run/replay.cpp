#include "app/run/replay.hpp"

#include "app/output.hpp"
#include "app/run/record.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"
#include "framework/session/run_log.hpp"

namespace tactor {

Plan recorded_plan(const RecordingHeader& header, Registry& registry) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "graph.yaml";
  write_file(file, header.graph);
  return make_plan(load_graph(file, registry));
}

void replay_recording(const std::filesystem::path& recording, const std::filesystem::path& folder, Registry& registry) {
  const std::unique_ptr<RecordingReader> reader = load_record_library().open(recording);
  if (!reader->complete()) {
    throw InputError(recording.string() + " cannot be replayed: its run ended without closing it");
  }
  const Plan plan = recorded_plan(reader->header(), registry);
  if (plan.graph.clock != Clock::real) {
    throw InputError(recording.string() +
                     " comes from a run under the virtual clock; run its graph again to get the same result");
  }
  const RunLog log = read_run_log(*reader, plan);
  Session session(plan, {.replay = &log});
  const std::unique_ptr<Recorder> recorder = load_record_library().create(folder / "recording.h5", reader->header());
  record(session, *recorder);
  session.run(Duration{100'000'000}, [] {});
  recorder->close();
}

}  // namespace tactor
