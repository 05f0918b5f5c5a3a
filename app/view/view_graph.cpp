#include "app/view/view_graph.hpp"

#include <algorithm>
#include <cstdlib>
#include <memory>

#include "app/output.hpp"
#include "app/run/experiment.hpp"
#include "app/run/provenance.hpp"
#include "app/run/record.hpp"
#include "app/view/judge.hpp"
#include "app/view/mouse_graph.hpp"
#include "app/view/session_view.hpp"
#include "framework/core/check.hpp"
#include "framework/core/user_folders.hpp"
#include "framework/graph/plan.hpp"
#include "framework/record/recorder.hpp"

namespace tactor {

namespace {

constexpr Duration look_period{20'000'000};
constexpr Duration reference_patience{200'000'000};
/// A busy desktop is no stall. The gate takes the force to zero long before.
constexpr Duration mouse_stall_timeout{5'000'000'000};

}  // namespace

std::optional<std::string> view_graph(GraphSpec graph, Registry& registry, const ViewOptions& options) {
  // The view and physics each load a mesh and have the same to say of it.
  const auto note_once = once(options.note);
  SessionView::Options shown;
  shown.ports = options.ports;
  shown.drawn = std::make_shared<const DrawnScene>(drawn_scene(graph));
  shown.meshes = mesh_messages(*shown.drawn, note_once);
  if (!options.own_device) {
    shown.start = first_handle_pose(graph);
    shown.mouse = lead_by_mouse(graph, shown.start, registry);
    if (!graph.places || !graph.places->contains("live.stall_timeout")) graph.live.stall_timeout = mouse_stall_timeout;
  } else if (const Body* tool = graph.scene.tool(); tool != nullptr) {
    shown.start = tool->X_WB;
  }
  take_out_sinks(graph);
  // A run is made for something: without sinks for what its device displays.
  if (graph.record.empty()) graph.record.push_back(device_of(graph).name + ".commanded");
  Session session(make_plan(std::move(graph)),
                  {.engine = {.without_dead_man = options.without_dead_man}, .keeps_tables = true});
  for (const std::string& note : session.nodes().notes()) note_once(note);
  const std::unique_ptr<Follower> follower =
      options.reference && !experiment_of(session.plan())
          ? judging_follower(session, registry, Follower::usual_most_behind, options.note)
          : nullptr;
  std::unique_ptr<Recorder> recorder;
  if (options.recording) {
    const RecordLibrary& library = load_record_library();
    const Plan& plan = session.plan();
    const std::string provenance = provenance_text(provenance_of(plan, default_cache_folder()));
    recorder = library.create(*options.recording, {to_yaml(plan.graph), plan.graph.seed, TACTOR_VERSION, provenance});
    record(session, *recorder);
  }
  session.stop_when(options.stop_asked);
  SessionView view(session, follower.get(), std::move(shown));
  if (follower) follower->start();
  options.opened(view.url(), view.foxglove_url());
  std::optional<std::string> failure;
  try {
    session.run(look_period, [&view] { view.attend(); });
    failure = session.failure();
  } catch (const RunError& error) {
    failure = error.what();
  }
  if (follower) follower->finish(reference_patience);
  if (recorder) recorder->close();
  // The page of an experiment is what the participant sees, and a failure may name the condition.
  const bool blind = experiment_of(session.plan()).has_value();
  const RunEnd end = view.end_of_run(failure.has_value(), options.stop_asked());
  view.tell_end(end, !failure ? "the run was ended" : blind ? "the run has failed; call the experimenter" : *failure);
  if (session.is_abandoned()) {
    // A step that never came back still runs on its thread: nothing may be cleaned up under it.
    options.note(*failure);
    std::_Exit(1);
  }
  return failure;
}

}  // namespace tactor
