#include "framework/record/packed_layout.hpp"

#include <algorithm>

namespace tactor {

PackedLayout::PackedLayout(const std::vector<Field>& fields) {
  add_fields(fields, 0, "");
}

void PackedLayout::add_fields(const std::vector<Field>& fields, std::size_t begin, const std::string& path) {
  for (const Field& field : fields) {
    const std::size_t at = begin + field.offset;
    const std::string name = path.empty() ? field.name : path + "." + field.name;
    if (field.changes_size) {
      parts_.push_back({at, 0, array_index(field, name)});
      size_ += 2 * sizeof(std::uint64_t);
    } else if (field.kind == FieldKind::record) {
      const std::size_t stride = element_size(field);
      for (std::size_t i = 0; i < count_of(field); ++i) add_fields(field.fields, at + i * stride, name);
    } else {
      add_bytes(at, count_of(field) * scalar_size(field.kind));
    }
  }
}

void PackedLayout::add_bytes(std::size_t offset, std::size_t size) {
  size_ += size;
  if (!parts_.empty() && parts_.back().size > 0 && parts_.back().offset + parts_.back().size == offset) {
    parts_.back().size += size;
  } else {
    parts_.push_back({offset, size, 0});
  }
}

std::size_t PackedLayout::array_index(const Field& field, const std::string& path) {
  const auto known = std::find(paths_.begin(), paths_.end(), path);
  if (known != paths_.end()) return static_cast<std::size_t>(known - paths_.begin());
  arrays_.push_back(&field);
  paths_.push_back(path);
  return paths_.size() - 1;
}

Field element_of(const Field& field) {
  Field element = field;
  element.changes_size = false;
  element.offset = 0;
  return element;
}

}  // namespace tactor
