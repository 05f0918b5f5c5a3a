// Where a rollout may find the tool's contacts with a few faces of a deforming surface.
#pragma once

#include <span>
#include <vector>

#include "nodes/physics/contact/soft_contact.hpp"

namespace tactor {

/// Some faces of deforming surfaces.
struct SoftFaces {
  std::span<const std::array<std::int32_t, 3>> node;  ///< counter-clockwise as seen from outside
  std::span<const std::int32_t> body;                 ///< of each face, in Scene::deformable()
  std::span<const double> area;                       ///< m^2, of each face at rest
};

class SoftContactSource {
 public:
  virtual ~SoftContactSource() = default;
  /// Bodies that deform: faces are of one of them.
  [[nodiscard]] virtual int deformable() const = 0;
  /// The tool's contacts with the faces where their nodes and the tool are. False, and `found` is empty, where finding
  /// them is more work than may be done. It allocates nothing.
  virtual bool find_on(const SoftFaces& faces, std::span<const Vec3> nodes_W, const Pose& X_WT,
                       std::vector<SoftContact>& found) = 0;
};

}  // namespace tactor
