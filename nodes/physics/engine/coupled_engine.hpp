// A foreign engine that moves a scene of its own, whose tool hangs on the coupling.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "framework/core/messages.hpp"

namespace tactor {

/// The model that an engine loads.
struct EngineModel {
  std::filesystem::path file;
  std::string tool;                 ///< the name of its body on the coupling
  std::string keyframe;             ///< the name of the state it begins with; empty: the model's own
  std::vector<std::string> bodies;  ///< names of the other bodies that the engine tells of
  /// Some of its trees may be let stand; such an engine tells neither of `bodies` nor of contacts.
  bool partial = false;
};

/// Trees of a scene as a set: bit k is tree k. A tree is a child of the world with all that hangs on it. Trees that the
/// model joins otherwise are one. Tree 0 has the tool, and with it what always moves.
using Trees = std::uint64_t;
inline constexpr int most_trees = 64;
inline constexpr Trees all_trees = ~Trees{0};

/// How far to look for the trees that have to move.
struct TreeSearch {
  double horizon = 0;       ///< s, for which the trees are chosen
  double handle_speed = 0;  ///< m/s
  double stretch = 0;       ///< m, between handle and tool, which the tool may jump when it comes free
  double step_budget = 0;   ///< s, that a step may cost, on the scale of CoupledEngine::step_cost
};

/// The numbers of an engine's state, as in EngineState.
struct EngineNumbers {
  std::span<const double> position, velocity, activation, acceleration;
};

/// The tool after a step.
struct EngineTool {
  Pose X_WT;                  ///< m, its origin the centre of mass
  Twist V_WT;                 ///< m/s, rad/s
  Wrench contact_T_W;         ///< N and N m, of the contacts in the last step, about the tool's origin
  std::int32_t contacts = 0;  ///< contacts that carried force
};

/// Steps the scene. Allocates and throws nothing but where it says so.
class CoupledEngine {
 public:
  CoupledEngine() = default;
  virtual ~CoupledEngine() = default;
  CoupledEngine(const CoupledEngine&) = delete;
  CoupledEngine& operator=(const CoupledEngine&) = delete;

  /// Of the model's files, the tool and the keyframe: states of an engine of another identity are none of this one.
  [[nodiscard]] virtual std::uint64_t identity() const = 0;
  /// kg, of the tool and all that hangs on it.
  [[nodiscard]] virtual double tool_mass() const = 0;
  /// kg m^2, of the tool alone about its centre of mass, in no order.
  [[nodiscard]] virtual Vec3 tool_principal_inertia() const = 0;
  /// m/s^2.
  [[nodiscard]] virtual Vec3 gravity_W() const = 0;
  /// False where the tool keeps its orientation.
  [[nodiscard]] virtual bool tool_rotates() const = 0;
  /// Bodies that move and of which the engine does not tell, nor of what they are welded to.
  [[nodiscard]] virtual std::vector<std::string> untold_bodies() const = 0;
  /// Whether a step in which these trees move may allocate memory.
  [[nodiscard]] virtual bool may_allocate(Trees moving) const = 0;
  /// Why it does; empty where it does not.
  [[nodiscard]] virtual std::string allocates(Trees moving) const = 0;
  /// Bodies that can move apart from each other as the engine is, such as the tool and a door. A body that stands with
  /// its tree is none.
  [[nodiscard]] virtual int moving_bodies() const = 0;

  /// Of a partial engine: the trees to move while the scene goes on from `numbers`. They are the tool's and those that
  /// it touches or may touch over the horizon, and then those that these may touch, the nearest to the tool first, as
  /// long as a step stays within its budget and allocates nothing. A tree may be touched where the gap between the
  /// spheres around geoms is less than both sides may go: by their speeds, by the speed of the handle, which may grow
  /// by 10 m/s^2, and by the spring's stretch. All trees, where the engine is not partial or `numbers` do not fit it.
  [[nodiscard]] virtual Trees near_trees(const EngineNumbers& numbers, const TreeSearch& search) = 0;
  /// s of CPU time of a step in which these trees move, from the numbers that came last, by a model:
  ///   a + b geoms + c dofs + d pairs.
  /// Geoms are those of all trees, degrees of freedom those of the trees that move, and pairs are geoms of theirs whose
  /// sphere meets that of a geom of another tree. The figures were measured once, on heaps of 6 to 60 bodies, and hold
  /// within a factor of two there; another machine differs by a factor. 0 where the engine is not partial.
  [[nodiscard]] virtual double step_cost(Trees moving) const = 0;
  /// Of a partial engine: the trees that move from the next `restore` on. The others stand where that state has them,
  /// and push as fixed bodies do.
  virtual void let_move(Trees moving) = 0;

  /// Puts the tool there, at rest; one that keeps its orientation goes to the place alone.
  virtual void place_tool(const Pose& X_WT) = 0;
  /// The state as it is; until the next step.
  [[nodiscard]] virtual EngineNumbers numbers() const = 0;
  /// Goes to that state. False, and nothing changes, where it is of another model or not finite.
  virtual bool restore(const EngineNumbers& numbers) = 0;

  /// Makes a step of `h` s to where the handle is at `to`. The coupling is solved with the contacts by implicit Euler,
  /// and the tool feels it without its limits. False where the engine could not: it has to be restored then. Contacts
  /// are put into `found`, unless it is null.
  virtual bool step(const CouplingParameters& coupling, const DeviceState& to, double h, ContactSet* found) = 0;
  /// Why the last step failed.
  [[nodiscard]] virtual const char* failure() const = 0;

  [[nodiscard]] virtual const EngineTool& tool() const = 0;
  /// The tool, then the other bodies that the engine tells of.
  [[nodiscard]] virtual BodyStates bodies() = 0;
};

}  // namespace tactor
