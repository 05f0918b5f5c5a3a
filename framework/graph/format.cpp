#include "framework/graph/format.hpp"

#include <algorithm>

namespace tactor {

void take_format(Tree& file, Diagnostics& diagnostics) {
  const TreeEntry* entry = file.find("format");
  if (entry == nullptr) return;
  const std::string current = std::to_string(file_format);
  if (!entry->value.is_scalar() || entry->value.text != current) {
    diagnostics.error(entry->value.place, "format: expected " + current + ", found " + describe(entry->value) +
                                              "; `tactor migrate` rewrites older files");
  }
  std::erase_if(file.entries, [](const TreeEntry& e) { return e.key == "format"; });
}

std::string renamed_text(const std::string& now, const SourceLocation& place) {
  return " is called " + now + " now" + (place.line > 0 ? "; tactor migrate " + place.file + " rewrites it" : "");
}

}  // namespace tactor
