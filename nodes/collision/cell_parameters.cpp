#include "nodes/collision/cell_parameters.hpp"

#include "nodes/collision/exact_distance.hpp"

namespace tactor {

namespace {

/// Up to it the blocks of a grid whose band is an eighth of the mesh's length are 40^3, and with 512 cells each within
/// what build_cells takes of any mesh. Beyond, only making the cells tells.
constexpr int always_takes = 256;

class Checked final : public PairCollision {
 public:
  Checked(const PairParams& params, const NodeContext& context, const MakeMeshDistance& make_distance)
      : PairCollision(params, context, make_distance) {}
};

std::unique_ptr<SignedDistance> without_cells(const TriangleMesh& mesh, double /*reach*/) {
  return std::make_unique<ExactDistance>(mesh);
}

}  // namespace

void check_cells(const PairParams& params, const CellOptions& options, const NodeContext& context) {
  MakeMeshDistance make_distance = without_cells;
  if (options.resolution > always_takes) make_distance = make_cells(options, context.notes);
  const Checked collision(params, context, make_distance);
}

}  // namespace tactor
