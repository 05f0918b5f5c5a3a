// Points that stand for the surface of a mesh in contact, each with its share of the area.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/physics/mesh/crease.hpp"
#include "nodes/physics/mesh/mesh.hpp"

namespace tactor {

struct SurfaceSample {
  Vec3 p;           ///< m, in the frame of the mesh
  double area = 0;  ///< m^2
  /// The mean outward normal of the surface about it, unit, in the frame of the mesh; zero: it faces every way.
  Vec3 normal;
  std::int32_t crease = -1;  ///< which of the creases it is at, or -1: the surface about it faces one way
};

struct SurfaceSamples {
  std::vector<SurfaceSample> points;
  std::vector<Crease> creases;  ///< whose parts have the area of their sample in all
};

/// The vertices, in their order. Each face gives a third of its area to each corner.
SurfaceSamples vertex_samples(const TriangleMesh& mesh);

/// Samples that cover the surface evenly, however it is divided into triangles: where those are larger than `spacing`
/// (m, > 0), points on edges and faces are added, where they are smaller, few vertices are kept.
///
/// Bound: every point of the surface has a sample of its sheet no farther than rho = spacing. Of its sheet: on a face
/// whose normal is within 60 degrees of that at the point, and reached over the surface without leaving the ball of rho
/// about the sample, so that no side of a wall stands for the other. A signed distance changes by no more than the way
/// moved, so no place is deeper in another body than its nearest sample by more than rho; and far less is missed where
/// surfaces lie along each other.
///
/// How: the mesh is refined until no edge is longer than spacing / 4, which leaves no point farther than spacing / (4
/// sqrt(3)) from a vertex; of these vertices, corners first, then edges, then those of the mesh, one is kept unless one
/// kept before is of all its sheets and within the rest, 0.85 spacing (Poisson disks by dart throwing: R. L. Cook,
/// "Stochastic sampling in computer graphics", ACM Transactions on Graphics 5, 1986). So where the surface is smooth no
/// two samples are nearer than 0.85 spacing, and there are about 0.9 area / spacing^2.
///
/// Areas: a third of each small face for each of its corners goes to the nearest sample that stands for the corner.
/// They sum to the surface's, and the parts at creases that face as a flat face does to that of the face.
///
/// `mesh`: of a solid, as load_solid returns it. The same mesh has the same samples. Throws InputError where the
/// refined mesh would have more than four million vertices.
SurfaceSamples sample_surface(const TriangleMesh& mesh, double spacing);

}  // namespace tactor
