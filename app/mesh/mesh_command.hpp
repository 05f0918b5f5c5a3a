// What `tactor mesh` does: looks at mesh files, repairs them, and makes them coarser.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "app/results_folder.hpp"
#include "nodes/physics/mesh/mesh_change.hpp"
#include "nodes/physics/mesh/polygon_soup.hpp"

namespace tactor {

/// A length in the unit of the file, or a share of the diagonal of its bounds.
struct MeshLength {
  double value = 0;
  bool of_diagonal = true;
};

struct MeshRequest {
  std::filesystem::path file;
  bool json = false;
};
struct MeshCheckRequest : MeshRequest {
  std::optional<double> scale;  ///< m that one unit of the file is; absent: 1, or as guessed_scale has it
};
struct MeshRepairRequest : MeshRequest {
  ResultsRequest results;
  MeshLength max_hole{0.6, true};  ///< a cube without its lid has 58 %
  MeshLength merge{1e-4, true};
  bool sheets = false;  ///< --max-hole was given
  bool wrap = false;
};
struct MeshDecimateRequest : MeshRequest {
  ResultsRequest results;
  std::int64_t faces = 0;
};

/// Each returns the exit code and throws InputError where the file cannot be read, the plugin `tactor_cgal` is missing,
/// or nothing can be made of the mesh. `check` and `info` tell whether a graph would take the mesh; `check` returns 2
/// where it would not.
int check_mesh(const MeshCheckRequest& request);
int show_mesh(const MeshRequest& request);
int repair_mesh(const MeshRepairRequest& request);
int decimate_mesh(const MeshDecimateRequest& request);

/// The repair that `request` asks for, nothing written.
MeshChange repaired(const PolygonSoup& soup, const MeshRepairRequest& request);

/// `0.12 (0.3 % of the diagonal)`: how far a surface moved, both ways, as text of some lines.
std::string moved_text(const MeshChange& change, double diagonal);

/// The diagonal of the bounds of what faces use, in the unit of the file.
double diagonal_of(const PolygonSoup& soup);

}  // namespace tactor
