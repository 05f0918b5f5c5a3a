// How charts and tables show each method: its colour and its mark.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tactor {

/// The colour of a row's method, and a mark that tells it from other rows of that colour.
struct MethodStyle {
  std::string color;
  std::size_t mark = 0;  ///< as Curve::mark

  /// The mark as a character in its colour, for tables: HTML.
  [[nodiscard]] std::string html() const;
};

/// One for each name of a row, such as `bunny_local` or `hold stiffness=800`. A shipped method has the same colour on
/// every page, and so have its variants (`local_exact`). Others get the colours that are left.
std::vector<MethodStyle> method_styles(const std::vector<std::string>& names);

}  // namespace tactor
