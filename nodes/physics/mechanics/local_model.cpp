#include "nodes/physics/mechanics/local_model.hpp"

#include "framework/core/describe.hpp"

namespace tactor {

template <>
const MessageType& message_type<LocalModel>() {
  static const MessageType type = Describe<LocalModel>("LocalModel", "W")
                                      .field("time", &LocalModel::time)
                                      .field("device", &LocalModel::device)
                                      .field("bodies", &LocalModel::bodies)
                                      .field("p_WT_result", "m", &LocalModel::p_WT_result)
                                      .field("wrench_result", &LocalModel::wrench_result)
                                      .field("law_error", "N", &LocalModel::law_error)
                                      .field("law_unknown", "1", &LocalModel::law_unknown)
                                      .field("coupling", &LocalModel::coupling)
                                      .field("contacts", &LocalModel::contacts)
                                      .field("correction", &LocalModel::correction)
                                      .field("patch", &LocalModel::patch)
                                      .type();
  return type;
}

}  // namespace tactor
