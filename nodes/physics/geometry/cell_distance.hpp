// The signed distance of a point to a closed triangle mesh, by lists of faces made beforehand for the space near it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "nodes/physics/geometry/face_tree.hpp"

namespace tactor {

/// How the space about a mesh is cut into cells.
struct CellOptions {
  int resolution = 128;  ///< cells along the longest side of the mesh's box, 8 to 1024
  double band = 0.0025;  ///< m, the distance from the surface, on both sides, within which cells have lists
};

/// A cell: what is known of all of its points.
struct Cell {
  float distance = 0;      ///< m, the signed distance of its centre rounded down
  std::uint32_t list = 0;  ///< first batch of its list * 16 + number of batches; 0 batches: it has no list
};

/// A cube of 8 x 8 x 8 cells.
struct CellBlock {
  std::int32_t cells = -1;    ///< index of its cells / 512, or -1 far from the surface
  float distance = 0;         ///< m, of its centre, as Cell::distance
  std::uint32_t palette = 0;  ///< where the records of the tree that its lists name begin
};

/// Everything a CellDistance consists of, in flat arrays. Cells are cubes, blocks cubes of 8 x 8 x 8 of them, x
/// fastest in both.
struct CellData {
  Surface surface;
  FaceTree tree;
  Vec3 box_low, box_high;                ///< m, of the mesh
  double slack = 0;                      ///< m, what rounding may add to a lower bound
  Vec3 low;                              ///< m, the lowest corner of the grid
  double edge = 0;                       ///< m, of a cell
  std::array<std::int32_t, 3> blocks{};  ///< along each axis
  LargeVector<CellBlock> block;
  LargeVector<Cell> cells;
  LargeVector<std::uint32_t> palette;                 ///< records of the tree, those of each block together
  LargeVector<std::array<std::uint16_t, 8>> batches;  ///< places in the palette of their block
  LargeVector<float> batch_bound;  ///< m, no face of this batch or the later ones of its list is nearer to the centre
};

/// Cuts the space about a solid into cells. The resolution must be 8 to 1024 and the band not negative. Throws
/// InputError where there would be more than 33 million cells.
CellData build_cells(const TriangleMesh& mesh, const CellOptions& options);

/// Exact distance as ExactDistance's, to the bit. Near the surface each cell lists every face that can be nearest to
/// one of its points, nearest to its centre first: the faces f with dist(f, c) <= min dist(., c) + 2 r for a point c,
/// where all points are within r of c. Eight faces are measured at once in floats; those that rounding cannot tell from
/// the nearest are compared in doubles. Elsewhere, and where a list would be too long, a tree over all faces is
/// searched.
class CellDistance final : public SignedDistance {
 public:
  /// `mesh`: of a solid, as load_solid returns it.
  explicit CellDistance(const TriangleMesh& mesh, const CellOptions& options = {})
      : data_(build_cells(mesh, options)) {}

  /// From what build_cells made.
  explicit CellDistance(CellData data) : data_(std::move(data)) {}

  [[nodiscard]] Nearest nearest(const Vec3& x, int hint = -1) const override;
  void lower_bounds(const Points8& x, unsigned wanted, std::array<float, 8>& bound) const override;
  [[nodiscard]] Eigen::Matrix3d hessian(const Nearest& nearest, const Vec3& x) const override;

  [[nodiscard]] const CellData& data() const { return data_; }

 private:
  CellData data_;
};

}  // namespace tactor
