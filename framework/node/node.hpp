// The node contract: a plain class without its own thread, lock or clock; an engine decides when it steps.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "framework/core/scene.hpp"
#include "framework/core/time.hpp"
#include "framework/node/port.hpp"
#include "framework/node/report.hpp"

namespace tactor {

class Pace;
class FlightRing;
struct FlightDevice;

/// Where a graph leads the hand, as its sources know it before the run.
struct HandPath {
  /// Poses of the target in the world, m, from the start of the run to its end, close enough that the path between two
  /// of them is nearly straight; never empty.
  std::vector<Pose> X_WH;
};

/// A parameter that does not get what it asks for, because another one limits it.
struct LimitedParameter {
  std::string parameter;  ///< `k_0`
  std::string by;         ///< `k_device`
  std::string note;       ///< the note that says so
};

/// The duration of a run that goes on until somebody stops it: longer than any time that a file can name. Such a run is
/// live, so a node must not keep something of each step for its end.
inline constexpr Duration until_stopped{2'000'000'000'000'000'000};

/// What a node may know when it is made or checked.
struct NodeContext {
  std::string name;                ///< its name in the graph
  const Scene* scene;              ///< never null; outlives the node
  bool torque = true;              ///< false: the scene is translation-only, torques are neither computed nor sent
  std::uint64_t seed = 0;          ///< for its random streams, derived from the run's seed and its name
  Duration duration;               ///< of the run; until_stopped: it has no end of its own
  bool foreign_physics = false;    ///< an edge leads here from dynamics of another law than the scene's
  bool in_loop = false;            ///< it steps in a loop of the real-time lane, which may miss ticks
  bool wall_clock = false;         ///< the run goes by the machine's clock, so measured times may decide
  const HandPath* hand = nullptr;  ///< null: not known
  /// The node adds notes here that the user should read but that do not stop the run, each once; null: not wanted.
  std::vector<std::string>* notes = nullptr;
  std::vector<LimitedParameter>* limits = nullptr;  ///< the node adds here what `note_limit` says; null: not wanted
  FlightRing* flight = nullptr;                     ///< where the line of a device tells its cycles; null: nowhere
  std::size_t index = 0;                            ///< of the node in the plan, for `flight`

  /// Adds a note that says that `by` takes the place of what `parameter` asks for; experiments refuse such a setting.
  void note_limit(const std::string& parameter, const std::string& by, const std::string& note) const {
    if (notes != nullptr) notes->push_back(note);
    if (limits != nullptr) limits->push_back({parameter, by, note});
  }
};

/// Where a run is. Under the virtual clock it ends without stopping: nothing moves.
enum class Phase : std::uint8_t {
  starting,  ///< some node upstream of a device has not finished a step yet: devices stay disengaged
  running,
  stopping,  ///< devices ramp down
};

/// What a step may ask of the engine.
class StepContext {
 public:
  explicit StepContext(Time now, Phase phase = Phase::running) : now_(now), phase_(phase) {}
  /// The time of this step.
  [[nodiscard]] Time now() const { return now_; }
  [[nodiscard]] Phase phase() const { return phase_; }
  /// While stopping: asks for further steps before the run ends, because this node is not at rest yet.
  void not_at_rest() { at_rest_ = false; }
  [[nodiscard]] bool at_rest() const { return at_rest_; }
  /// Tells how many items (contacts, ...) this step worked on; cost models charge for them.
  void add_work(std::int64_t items) { work_ += items; }
  [[nodiscard]] std::int64_t work() const { return work_; }
  /// Where a device tells what it did at this tick, for the flight recorder; null: nobody asks.
  [[nodiscard]] FlightDevice* flight() const { return flight_; }
  void tell_flight(FlightDevice* flight) { flight_ = flight; }

 private:
  Time now_;
  Phase phase_;
  bool at_rest_ = true;
  std::int64_t work_ = 0;
  FlightDevice* flight_ = nullptr;
};

/// A node. Its ports are members of the derived class; its constructor gets checked parameters and throws InputError
/// on what only it can check (a broken mesh).
class Node {
 public:
  Node() = default;
  virtual ~Node() = default;
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  /// Called once at time zero, after the ports are connected and before any step; may send.
  virtual void start(StepContext& context) { static_cast<void>(context); }
  /// The work. Reads inputs, sends outputs; what it sends becomes visible when its cost has passed.
  virtual void step(StepContext& context) = 0;
  /// Called before a step, once for each request of the node to set something, in their order: the setting is in force.
  /// In the real-time lane it allocates, locks and waits for nothing.
  virtual void request_done() {}
  /// In the real-time lane: what its loop waits for in place of its deadlines; null: its deadlines. Constant.
  [[nodiscard]] virtual Pace* pace() { return nullptr; }
  /// The time since when the node works normally, such as since its window is full. Empty if it does not yet. A type
  /// that may return anything but zero declares that (Declare::warms_up). Asked between two steps or after the run.
  [[nodiscard]] virtual std::optional<Time> warm_since() const { return Time{}; }
  /// In a reference run: `tested` is the node of the same name in the run under test.
  virtual void follow(const Node& tested) { static_cast<void>(tested); }
  /// True where a reference run depends on what this node did in the run under test (see `follow`).
  [[nodiscard]] virtual bool must_be_followed() const { return false; }
  /// Called once after the run, with the reference set on the inputs that asked for it: for curves, remarks, and
  /// metrics that are declared without a value. May report no others.
  virtual void report(Report& report) const { static_cast<void>(report); }
};

}  // namespace tactor
