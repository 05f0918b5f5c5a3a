// A foreign engine that moves a scene of its own, whose tool hangs on the coupling.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "framework/core/body_poses.hpp"
#include "framework/core/messages.hpp"
#include "framework/core/own_scene.hpp"
#include "nodes/physics/engine/stepped_engine.hpp"

namespace tactor {

/// The model that an engine loads.
struct EngineModel {
  std::filesystem::path file;
  std::string tool;                 ///< the name of its body on the coupling
  std::string keyframe;             ///< the name of the state it begins with; empty: the model's own
  std::vector<std::string> bodies;  ///< names of the other bodies that the engine tells of
  /// Some of its trees may be let stand; such an engine tells neither of `bodies` nor of contacts, and
  /// shows no scene.
  bool partial = false;
};

/// Steps the scene of a model. Its identity is of the model's files, the tool and the keyframe. It solves the coupling
/// with the contacts by implicit Euler. Allocates and throws nothing but where it says so.
class CoupledEngine : public SteppedEngine {
 public:
  /// kg, of the tool and all that hangs on it.
  [[nodiscard]] virtual double tool_mass() const = 0;
  /// kg m^2, of the tool alone about its centre of mass, in no order.
  [[nodiscard]] virtual Vec3 tool_principal_inertia() const = 0;
  /// m/s^2.
  [[nodiscard]] virtual Vec3 gravity_W() const = 0;
  /// Bodies that move and of which the engine does not tell, nor of what they are welded to.
  [[nodiscard]] virtual std::vector<std::string> untold_bodies() const = 0;
  /// Why a step in which these trees move may allocate memory; empty where it does not.
  [[nodiscard]] virtual std::string allocates(Trees moving) const = 0;

  /// All that can be drawn of the model, its bodies where they are. Allocates.
  [[nodiscard]] virtual OwnScene own_scene() const = 0;
  /// How many bodies that scene has.
  [[nodiscard]] virtual std::size_t shown_bodies() const = 0;
  /// Writes where they are; `poses` has room for all.
  virtual void show(std::span<ShownPose> poses) const = 0;
  /// Puts the tool there, and says whether a surface touches it or is in it. Not while the engine steps a scene: the
  /// others stay where they are, and nothing is solved.
  virtual bool touches_at(const Pose& X_WT) = 0;

  /// Puts the tool there, at rest; one that keeps its orientation goes to the place alone.
  virtual void place_tool(const Pose& X_WT) = 0;
  /// The tool, then the other bodies that the engine tells of.
  [[nodiscard]] virtual BodyStates bodies() = 0;
};

}  // namespace tactor
