// A foreign engine that moves a scene of its own, whose tool hangs on the coupling.
#pragma once

#include <cstddef>
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
  /// Why a step of this model may allocate memory; empty where none does.
  [[nodiscard]] virtual std::string allocates() const = 0;
  /// Bodies that can move apart from each other, such as the tool and a door.
  [[nodiscard]] virtual int moving_bodies() const = 0;

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
