// Repairs of a soup of triangles before it becomes a surface: rims are joined, loose and inner faces taken out.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "nodes/physics/mesh/polygon_soup.hpp"
#include "nodes/physics/mesh/soup_topology.hpp"

namespace tactor {

/// Makes points of open edges one that are nearer than `reach` to each other; each moves by less than that. Returns how
/// many are gone. Faces that have no three corners left are gone too.
std::size_t merge_rims(NumberedSoup& soup, double reach);

/// Cuts faces at points of open edges that lie on another open edge, `reach` or less beside it. Returns how many.
std::size_t cut_at_rims(NumberedSoup& soup, double reach);

/// Takes out pieces that hang on edges of more than two faces and end freely (fins), and those that part the inside
/// (walls), where their area is small beside the rest. The numbers of the faces are added to `removed`. Returns how
/// many.
std::size_t remove_fins(NumberedSoup& soup, std::vector<std::size_t>& removed);

/// The area of a triangle or a fan.
double area_of(const NumberedSoup& soup, std::size_t polygon);

}  // namespace tactor
