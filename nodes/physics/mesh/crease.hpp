// Where the surface about a sample folds: how much of it faces which way, and how much of that counts in a contact.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "framework/core/spatial.hpp"

namespace tactor {

/// A part of a surface that faces one way.
struct FacingArea {
  double area = 0;  ///< m^2
  Vec3 normal;      ///< the mean outward unit normal, in the frame of the body; shorter than 1 where the part is curved
};

/// The parts of the surface about a sample at an edge or a corner: two or three.
struct Crease {
  static constexpr std::size_t capacity = 3;
  std::array<FacingArea, capacity> part;
  std::size_t parts = 0;
};

/// The parts of a surface that consists of `faces`, with unit normals, in any order. Faces whose normals are within 32
/// degrees of each other's are of one part, and so is what a chain of such faces connects: a surface that bends
/// smoothly is one part, however far it bends. Of more than three parts the two whose normals are nearest become one,
/// until three are left; a part of less than a hundredth of the area joins the one that it faces most alike, so that
/// neither slivers nor a blunt end that is much smaller than the spacing decides. Nothing where one part is left.
std::optional<Crease> find_crease(std::vector<FacingArea> faces);

/// The least cosine between the normals of neighbours in one part: 32 degrees. No regular prism has this angle
/// between its faces.
constexpr double same_part = 0.85;

/// How much of the area about a crease counts, in m^2, where what it touches lies in direction `towards` (unit, in the
/// frame of the body):
///
///   sum over the parts of area * (c^2 + s) / (largest c^2 + s),  c = max(0, normal . towards),  s = 0.001.
///
/// c^2 is how stiff springs that stand along a part's normal are along `towards`. Of two faces at a right angle that
/// one alone counts which lies on the other body (s adds a thousandth of the other), both where it is touched edge-on,
/// and in between what is between. Where no part faces the other body more than another does, as at the tip of a needle
/// or where all face away, all of the area counts. The part that faces it most always counts whole. The result changes
/// continuously with `towards`, a radian by no more than 2 / sqrt(s) = 64 times the area of the other parts, and by so
/// much only where none of them faces within 88 degrees of the other body; at most 5 times where one is within 45.
inline double area_towards(const Crease& crease, const Vec3& towards) {
  constexpr double s = 0.001;
  std::array<double, Crease::capacity> stiffness{};
  double most = 0, sum = 0;
  for (std::size_t i = 0; i < crease.parts; ++i) {
    const double c = std::max(0.0, dot(crease.part[i].normal, towards));
    stiffness[i] = c * c + s;
    most = std::max(most, stiffness[i]);
  }
  for (std::size_t i = 0; i < crease.parts; ++i) sum += crease.part[i].area * stiffness[i];
  return sum / most;
}

}  // namespace tactor
