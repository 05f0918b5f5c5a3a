// Writes texts and numbers as YAML.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tactor {

/// A double-quoted scalar, in which every text can be written.
std::string yaml_quoted(std::string_view text);
/// `[1, 2.5]`.
std::string yaml_list(const std::vector<double>& values);

}  // namespace tactor
