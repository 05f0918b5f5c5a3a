// What can be measured of a mesh file before anything is repaired.
#pragma once

#include <cstddef>

#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/mesh/polygon_soup.hpp"

namespace tactor {

/// Lengths in the unit of the file. Vertices at one place count once, as a repair makes them one.
struct MeshMeasures {
  std::size_t vertices = 0, faces = 0;  ///< as the file lists them
  Bounds bounds;                        ///< of the vertices that faces use
  double area = 0;
  std::size_t pieces = 0;        ///< that hang together by vertices
  std::size_t open_edges = 0;    ///< of one face
  std::size_t shared_edges = 0;  ///< of more than two faces
  double shortest_edge = 0, longest_edge = 0;
};

MeshMeasures measures_of(const PolygonSoup& soup);

}  // namespace tactor
