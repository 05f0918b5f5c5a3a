// Rewrites graph and study files that say something by a name it had before.
#pragma once

#include <string>
#include <vector>

#include "framework/node/info.hpp"
#include "framework/yaml/diagnostics.hpp"

namespace tactor {

/// A name that was replaced.
struct Migration {
  SourceLocation place;
  std::string before, now;  ///< `before` is empty for a line that was added
};

struct Migrated {
  std::string text;
  std::vector<Migration> changes;  ///< in the order of the file
};

/// The file `text` with the names that the declarations in `types` have now, and with the key `format`. All else stays
/// as it is: comments, order, spaces. A node that says no type here gets the names that all types agree on. Errors of
/// YAML, and a form that cannot be rewritten, go to `diagnostics`; the text is then returned as it was.
Migrated migrate(const std::string& text, const std::string& file, const std::vector<const NodeInfo*>& types,
                 Diagnostics& diagnostics);

}  // namespace tactor
