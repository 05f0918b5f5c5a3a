// Reads what graphs alone have out of a tree: parameters of nodes, seeds, names. Each tells what it expected.
#pragma once

#include <optional>
#include <string>

#include "framework/node/info.hpp"
#include "framework/yaml/file_finder.hpp"
#include "framework/yaml/yaml_values.hpp"

namespace tactor {

// Step rates beyond these, in Hz, have no whole number of nanoseconds worth the name as their period.
inline constexpr double lowest_rate = 1e-6;
inline constexpr double highest_rate = 1e6;

std::optional<std::uint64_t> read_seed(const Tree& tree, const std::string& path, Diagnostics& diagnostics);
std::optional<ParamValue> read_param(const Tree& tree, const std::string& path, const ParamInfo& param,
                                     const FileFinder& files, Diagnostics& diagnostics);

/// False, with an error, where the name of a node or body is no identifier or a word with a meaning of its own.
bool check_name(const TreeEntry& entry, const std::string& path, Diagnostics& diagnostics);

}  // namespace tactor
