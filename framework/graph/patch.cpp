#include "framework/graph/patch.hpp"

#include <algorithm>

#include "framework/core/text.hpp"

namespace tactor {

Patch set_patch(const std::string& text, const std::string& said_by) {
  const SourceLocation place{said_by + " " + text, 0, 0};
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) {
    throw YamlError({{place, std::string(assignment_form) + ", found no ="}});
  }
  return {place, Assignment{std::string(trimmed(std::string_view(text).substr(0, equals))), text.substr(equals + 1)}};
}

Patch option_patch(const std::string& option, const std::string& path, const std::string& value) {
  return {{option + " " + value, 0, 0}, Assignment{path, value}};
}

Patch over_patch(const std::filesystem::path& file, const std::string& said_by) {
  return {{said_by + " " + file.string(), 0, 0}, file};
}

const Patch* find_assignment(const Overrides& overrides, std::string_view path) {
  const auto gives = [&](const Patch& patch) {
    return patch.assignment() != nullptr && patch.assignment()->path == path;
  };
  const auto found = std::find_if(overrides.rbegin(), overrides.rend(), gives);
  return found == overrides.rend() ? nullptr : &*found;
}

}  // namespace tactor
