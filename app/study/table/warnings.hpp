// What makes a comparison or a study doubtful, said where its results begin.
#pragma once

#include <string>
#include <vector>

#include "app/study/table/comparison.hpp"
#include "framework/graph/spec.hpp"

namespace tactor {

/// A sentence each: rows in whose runs nothing touches, and rows that are unlike what they are compared with.
std::vector<std::string> comparison_warnings(const Comparison& comparison);
/// The same as lines for the terminal; empty for none.
std::string warning_lines(const Comparison& comparison);
/// Warnings for a page; empty for none.
std::string warnings_html(const std::vector<std::string>& warnings);

/// In what the graph's scene or coupling differs from that of `other`, as a sentence that begins `its scene` or
/// `its coupling`; empty: in nothing.
std::string difference_beside_method(const GraphSpec& graph, const GraphSpec& other);

}  // namespace tactor
