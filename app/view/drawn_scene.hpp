// The bodies that views and pictures draw: those of a graph's scene, and the shapes that its nodes bring.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "framework/core/scene.hpp"
#include "framework/graph/spec.hpp"
#include "nodes/physics/mesh/mesh.hpp"

namespace tactor {

/// What is drawn. It begins with the bodies of the graph's scene, but for those that a node draws by shapes of its own.
struct DrawnScene {
  /// The triangles of a body, in its frame.
  using Surface = std::shared_ptr<const TriangleMesh>;
  /// How a shape moves that a node brings.
  struct Moved {
    std::string node;      ///< its messages BodyPoses have the pose of the body
    std::string body;      ///< of the node's scene
    std::size_t pose = 0;  ///< index into the message; 0 is the tool
    Pose X_BS;             ///< m, the shape in the frame of that body
  };

  DrawnScene() = default;
  /// A scene without what nodes bring.
  // NOLINTNEXTLINE(google-explicit-constructor): what draws a scene draws this
  DrawnScene(Scene of) : scene(std::move(of)), surfaces(scene.bodies.size()), moved(scene.bodies.size()) {}

  [[nodiscard]] bool is_tool(std::size_t body) const {
    return moved[body] ? moved[body]->pose == 0 : &scene.bodies[body] == scene.tool();
  }
  /// Of the body of the graph's scene of that name; none where a node draws it.
  [[nodiscard]] std::optional<std::size_t> index_of(const std::string& name) const {
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      if (scene.bodies[i].name == name) return i;
    }
    return std::nullopt;
  }
  /// Puts a moving body of the graph's scene there, whoever draws it.
  void put(const std::string& name, bool is_the_tool, const Pose& X_WB);
  /// Whether a body moves that is none of that scene.
  [[nodiscard]] bool has_bodies_beside(const Scene& of) const;
  /// Where the tool is drawn; none where there is none.
  [[nodiscard]] std::optional<Pose> tool_pose() const;

  Scene scene;                              ///< for drawing alone
  std::vector<Surface> surfaces;            ///< by body; null: as the scene has it
  std::vector<std::optional<Moved>> moved;  ///< by body; none: it is of the graph's scene, or stays
};

/// What is drawn of a graph. Asks the nodes that bring a scene. Throws YamlError where one cannot tell it, or where a
/// name of it is that of another body.
DrawnScene drawn_scene(const GraphSpec& graph);

/// The surface of that body in its own frame; not of a plane. Throws InputError where a file holds none. Notes of the
/// file go to `notes`, unless it is null.
TriangleMesh drawn_surface(const DrawnScene& drawn, std::size_t body, std::vector<std::string>* notes = nullptr);

}  // namespace tactor
