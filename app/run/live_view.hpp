// The state of a live run on the terminal while it goes on.
#pragma once

#include <string>
#include <vector>

#include "app/run/live_look.hpp"
#include "framework/graph/plan.hpp"

namespace tactor {

/// A block of lines that is drawn over itself a few times a second; nothing where standard error is no terminal.
class LiveView {
 public:
  explicit LiveView(const Plan& plan);
  /// Draws it.
  void draw(const LiveLook& look);
  /// Leaves the terminal as it was before the block.
  void clear();

 private:
  /// What brings the cursor to the first row of the block.
  [[nodiscard]] std::string back() const;

  const Plan& plan_;
  const bool terminal_;
  EngineStatus drawn_;    // what was drawn last, for rates
  std::size_t rows_ = 0;  // on the terminal
};

/// The block for `now`, with rates since `before`. At most 100 columns wide.
std::string live_block(const Plan& plan, const EngineStatus& before, const LiveLook& now);

/// The lines of `block` cut to a terminal of so many rows and columns, each at least 1; where rows are missing the last
/// one tells how many.
std::vector<std::string> fitted(const std::string& block, std::size_t rows, std::size_t columns);

}  // namespace tactor
