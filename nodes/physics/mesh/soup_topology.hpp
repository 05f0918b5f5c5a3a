// How the polygons of a soup meet: doubles are taken out, and edges and vertices that no solid has are found.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "nodes/physics/mesh/mesh_report.hpp"
#include "nodes/physics/mesh/polygon_soup.hpp"

namespace tactor {

/// A soup whose polygons keep the numbers that they have in their file, counted from 0.
struct NumberedSoup {
  std::vector<Vec3> points;
  std::vector<std::vector<std::size_t>> polygons;
  std::vector<std::size_t> numbers;  ///< of each polygon
};

/// Leaves out isolated points, makes points at one place one, leaves out repeated corners, and polygons with fewer than
/// three corners after that, and keeps one of polygons with the same corners. The order of what is kept stays. Tells
/// the report.
NumberedSoup tidy(PolygonSoup soup, MeshReport& report);

/// Takes out the polygons of which `drop` is true.
void remove_polygons(NumberedSoup& soup, const std::vector<bool>& drop);

/// The edges of a soup that do not belong to two polygons. In a solid there are none.
struct EdgeFaults {
  struct Edge {
    std::size_t a = 0, b = 0;           ///< points
    std::vector<std::size_t> polygons;  ///< that share it
  };
  std::size_t borders = 0;    ///< edges of one polygon
  std::size_t branches = 0;   ///< edges of three or more
  std::optional<Edge> first;  ///< a branch where there is one, else a border
  std::size_t against = 0;    ///< edges that both of their polygons go through in the same direction
  [[nodiscard]] bool closed_and_manifold() const { return borders + branches == 0; }
};

/// Polygons of which `ignored` is true count as absent.
EdgeFaults find_edge_faults(const NumberedSoup& soup, const std::vector<bool>& ignored);

/// The points in which parts of the surface touch that are not neighbours there (bow ties). Every edge must belong to
/// two polygons.
std::vector<std::size_t> find_bow_ties(const NumberedSoup& soup);

}  // namespace tactor
