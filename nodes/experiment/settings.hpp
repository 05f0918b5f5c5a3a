// All settings that an experiment makes, as one list that its requests name by index.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "framework/node/info.hpp"

namespace tactor {

struct ProtocolSettings {
  struct Range {
    std::size_t begin = 0, end = 0;
  };
  std::vector<Setting> list;
  std::vector<Range> conditions;       ///< into `list`, by condition; at least one
  std::size_t muted = 0, unmuted = 0;  ///< indices; `unmuted` counts where the level is not the mute
  std::optional<std::size_t> level;    ///< index of the standard level; none: the procedure has no levels

  /// The settings of a condition, in their order.
  [[nodiscard]] std::span<const Setting> of_condition(std::size_t condition) const {
    return std::span(list).subspan(conditions[condition].begin,
                                   conditions[condition].end - conditions[condition].begin);
  }
};

}  // namespace tactor
