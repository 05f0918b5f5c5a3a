// What `tactor mesh repair` and `tactor mesh decimate` ask of the plugin `tactor_meshing`, and what comes of it.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "nodes/physics/mesh/mesh.hpp"
#include "nodes/physics/mesh/mesh_report.hpp"

namespace tactor {

/// How far a repair may go. Lengths are in the unit of the file.
struct RepairOptions {
  double merge = 0;     ///< vertices of open edges that are nearer become one
  double max_hole = 0;  ///< wider holes are not filled: twice the way from the rim to the middle of the filling
  bool sheets = false;  ///< also close what is more opening than surface
  bool wrap = false;    ///< make a new surface around everything instead (CGAL's alpha wrap)
};

/// A solid that was made of another mesh.
struct MeshChange {
  TriangleMesh mesh;                 ///< in the unit and frame of the file
  std::vector<std::string> changes;  ///< each a phrase: `2 holes were filled, the widest 3.2 wide about (0, 1, 2)`
  MeshReport report;                 ///< of the check that the new mesh has passed

  /// What of the file has no counterpart in the new mesh on purpose: loose and inner pieces. Numbers of faces in the
  /// file, ascending.
  std::vector<std::size_t> removed;
  /// Faces of the file of which a part lies inside the new body, since bodies were united. Numbers, ascending.
  std::vector<std::size_t> inside;
  double inside_share = 0;  ///< of the area of the file's faces: what lies inside, by samples
  /// Faces of the new mesh that fill holes, ascending.
  std::vector<std::size_t> filled;
  double filled_share = 0;  ///< of the area of the new mesh: what fills holes

  /// No point of the file's faces is farther from the new surface (Hausdorff, one side), but for those removed and what
  /// lies inside. Pieces of 1/32 of the diagonal across the edge of what lies inside are judged by samples.
  double old_to_new = 0;
  /// No point of the new surface but of what fills holes is farther from the faces of the file (the other side).
  double new_to_old = 0;
  double moved_error = 0;  ///< the two may be too large by this much, never too small

  double old_volume = 0;  ///< as far as the file's surface goes: an open one is closed to the middle of its bounds
  double new_volume = 0;
};

}  // namespace tactor
