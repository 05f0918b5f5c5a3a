#include "nodes/collision/cell_parameters.hpp"

namespace tactor {

namespace {
/// Up to it the blocks of a grid whose band is an eighth of the mesh's length are 40^3, and with 512 cells each within
/// what build_cells takes of any mesh. Beyond, only making the cells tells.
constexpr int always_takes = 256;
}  // namespace

void check_cells(const ContactOptions& contacts, const CellOptions& cells, const NodeContext& context) {
  require_moving_body(*context.scene);
  const SceneContacts made(*context.scene, contacts,
                           cells.resolution > always_takes ? cell_distances(cells, context.notes) : tree_distances(),
                           context.hand, context.notes);
}

}  // namespace tactor
