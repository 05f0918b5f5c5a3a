// `tactor new graph`: a complete scene around a mesh or a box, as files that one reads and changes.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace tactor {

struct NewGraphRequest {
  std::string name;                           ///< of the scene: a folder of that name is made
  std::optional<std::filesystem::path> mesh;  ///< absent: a box
  std::string method = "off";                 ///< of graphs/methods; `off`: the physics force is held
  std::optional<double> size;                 ///< m, the longest side that the body is to have
  std::optional<double> unit;                 ///< m, what one unit of the mesh file is; not with `size`
  std::optional<double> young;                ///< Pa; the body deforms, by this modulus
  std::filesystem::path folder = ".";         ///< where the folder of the scene is made
  bool overwrite = false;
};

/// Makes FOLDER/NAME with `scene.yaml`, the mesh, and `METHOD.yaml`, and tells what to run next. A mesh that a graph
/// refuses is repaired, where its surface moves by no more than 1 % of its diagonal, and that is told.
/// Throws InputError, before anything is written, where the name, the mesh or the method cannot be used or files are
/// there already.
void make_new_graph(const NewGraphRequest& request);

}  // namespace tactor
