// An engine that moves a tool on the coupling from a given state, step by step.
#pragma once

#include <cstdint>
#include <span>

#include "framework/core/engine_state.hpp"
#include "framework/core/messages.hpp"

namespace tactor {

/// The numbers of an engine's state, as in EngineState.
struct EngineNumbers {
  std::span<const double> position, velocity, activation, acceleration;
  Pose X_WT;   ///< m, of the tool; not read by an engine whose coordinates tell it
  Twist V_WT;  ///< m/s, rad/s, likewise
};

/// The tool after a step.
struct EngineTool {
  Pose X_WT;                  ///< m, its origin the centre of mass
  Twist V_WT;                 ///< m/s, rad/s
  Wrench contact_T_W;         ///< N and N m, of the contacts in the last step, about the tool's origin
  std::int32_t contacts = 0;  ///< contacts that carried force
};

/// How far to look for the trees that have to move.
struct TreeSearch {
  double horizon = 0;       ///< s, for which the trees are chosen
  double handle_speed = 0;  ///< m/s
  double stretch = 0;       ///< m, between handle and tool, which the tool may jump when it comes free
  double step_budget = 0;   ///< s, that a step may cost, on the scale of SteppedEngine::step_cost
};

/// Steps the scene. A partial engine can let some of its trees stand; of any other all trees move, and it leaves the
/// functions on trees as they are here. Allocates and throws nothing but where it says so.
class SteppedEngine {
 public:
  SteppedEngine() = default;
  virtual ~SteppedEngine() = default;
  SteppedEngine(const SteppedEngine&) = delete;
  SteppedEngine& operator=(const SteppedEngine&) = delete;

  /// States of an engine of another identity are none of this one.
  [[nodiscard]] virtual std::uint64_t identity() const = 0;
  /// False where the tool keeps its orientation.
  [[nodiscard]] virtual bool tool_rotates() const = 0;
  /// Bodies that can move apart from each other as the engine is, such as the tool and a door. A body that stands with
  /// its tree is none. 1 where the engine tells of its tool alone.
  [[nodiscard]] virtual int moving_bodies() const { return 1; }

  /// Whether nothing that can move stands where these trees move.
  [[nodiscard]] virtual bool is_whole(Trees /*moving*/) const { return true; }
  /// Whether a step in which these trees move may allocate memory, as far as the engine knows.
  [[nodiscard]] virtual bool may_allocate(Trees /*moving*/) const { return false; }
  /// Of a partial engine: the trees to move while the scene goes on from `numbers`. They are the tool's and those that
  /// it touches or may touch over the horizon, and then those that these may touch, the nearest to the tool first, as
  /// long as a step stays within its budget and allocates nothing. A tree may be touched where the gap between the
  /// spheres around geoms is less than both sides may go: by their speeds, by the speed of the handle, which may grow
  /// by 10 m/s^2, and by the spring's stretch. All trees, where the engine is not partial or `numbers` do not fit it.
  [[nodiscard]] virtual Trees near_trees(const EngineNumbers& /*numbers*/, const TreeSearch& /*search*/) {
    return all_trees;
  }
  /// s of CPU time of a step in which these trees move, from the numbers that came last, by a model:
  ///   a + b geoms + c dofs + d pairs.
  /// Geoms are those of all trees, degrees of freedom those of the trees that move, and pairs are geoms of theirs whose
  /// sphere meets that of a geom of another tree. The figures were measured once, on heaps of 6 to 60 bodies, and hold
  /// within a factor of two there; another machine differs by a factor. 0 where the engine is not partial.
  [[nodiscard]] virtual double step_cost(Trees /*moving*/) const { return 0; }
  /// Of a partial engine: the trees that move from the next `restore` on. The others stand where that state has them,
  /// and push as fixed bodies do.
  virtual void let_move(Trees /*moving*/) {}

  /// The state as it is; until the next step.
  [[nodiscard]] virtual EngineNumbers numbers() const = 0;
  /// Goes to that state. False, and nothing changes, where it is of another model or not finite.
  virtual bool restore(const EngineNumbers& numbers) = 0;

  /// Makes a step of `h` s to where the handle is at `to`. The tool feels the coupling without its limits. False where
  /// the engine could not: it has to be restored then. Contacts are put into `found`, unless it is null; an engine that
  /// knows none leaves it.
  virtual bool step(const CouplingParameters& coupling, const DeviceState& to, double h, ContactSet* found) = 0;
  /// Why the last step failed.
  [[nodiscard]] virtual const char* failure() const = 0;

  [[nodiscard]] virtual const EngineTool& tool() const = 0;
};

}  // namespace tactor
