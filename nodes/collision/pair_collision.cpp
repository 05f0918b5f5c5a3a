#include "nodes/collision/pair_collision.hpp"

namespace tactor {

PairCollision::PairCollision(const ContactOptions& options, const NodeContext& context,
                             const MakeMeshDistance& make_distance)
    : CollisionNode(*context.scene), contacts_(*context.scene, options, make_distance, context.hand, context.notes) {}

void PairCollision::report(Report& report) const {
  if (queries() == 0 || touching_queries() > 0) return;
  report.remark("nothing touched: none of " + std::to_string(queries()) +
                " contact queries found a contact; every force is that of a tool in free space");
}

}  // namespace tactor
