// The points that stand for a body's surface in contact, whatever its shape.
#pragma once

#include <vector>

#include "framework/core/scene.hpp"
#include "nodes/physics/mesh/surface_samples.hpp"

namespace tactor {

/// Points of a body, or balls of it, in the body's frame.
struct ContactSamples {
  std::vector<SurfaceSample> points;  ///< area in m^2, zero where `weights` counts
  std::vector<double> radii;          ///< m, of balls about the points; empty: points
  std::vector<double> weights;        ///< in contact patches; empty: area / patch area of the softer material
  std::vector<Crease> creases;        ///< those of the points
};

/// How much of the area of sample i counts, in m^2, where what it touches lies in direction `towards` (unit, in the
/// frame of the body). On a face it is the area as seen from there, area * max(0, normal . towards): a sample whose
/// nearest place of the other body is that body's side pushes nothing. At a crease it is area_towards, all of it where
/// the mean normal or that of a part is within 60 degrees of `towards`, and none where all are 90 degrees or more away.
double area_facing(const ContactSamples& samples, std::size_t i, const Vec3& towards);

/// How long an edge between samples is where a spacing of 0 leaves it to the shape: an eighth of a box's longest edge;
/// for a capsule of radius r sqrt(0.08) r, with which the error below is no more than a hundredth of r at touch.
double default_spacing(const Shape& shape);

/// Samples with at most `spacing` (m) between neighbours, or that of default_spacing where it is 0.
///   sphere   its centre, as a ball of the whole radius and of weight 1: its distance is exact.
///   capsule  n + 1 balls of its radius r along its segment of length L, n >= 2. The ends weigh 1, as the half balls
///            they are, and the part between them L / (2 r): one patch a diameter. So a line contact weighs
///            2 + L / (2 r), whatever the spacing s. It is exact against a plane, whose distance is linear along the
///            segment. Where the other body is within the axis' distance d > 0 the depth found falls short by at most
///            sqrt(d^2 + s^2 / 4) - d <= s^2 / (8 d), since the nearest point q of the deepest place is no farther than
///            that from the next sample; d = r - depth. Only a spike comes near it.
///   box      the lattice of its corners, edges and faces, each with its share of the area (the trapezoid rule), so
///            that the areas sum to the surface's. At edges and corners each face is a part of its own (Crease).
///            Against a plane the depth is exact. Elsewhere it falls short by at most half the diagonal of a lattice
///            cell, and only where an edge or corner of the other body meets a face between samples, which that body's
///            own samples see.
///   plane    none.
/// Throws InputError for more than a million samples and for a mesh, whose samples are sample_surface's.
ContactSamples shape_samples(const Shape& shape, double spacing);

}  // namespace tactor
