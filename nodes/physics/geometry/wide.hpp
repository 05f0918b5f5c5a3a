// Eight floats at a time: the vector type of collision's inner loops, and the distances to eight faces.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "nodes/physics/geometry/face_tree.hpp"

// A function so marked is compiled for processors with AVX2 too, and the loader picks. Both give the same bits: neither
// fuses multiplications with additions. Without optimisation, lambdas in it would pass vectors by another convention;
// the resolver runs before the sanitizers are ready. Hence none with either, nor by clang, which fuzzes under
// sanitizers.
#if !defined(__x86_64__) || !defined(__OPTIMIZE__) || defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || \
    defined(__clang__)
#define TACTOR_WIDE
#else
#define TACTOR_WIDE __attribute__((target_clones("arch=x86-64-v3", "default")))
#endif

namespace tactor::wide {

using F4 = float __attribute__((vector_size(16)));
using F8 = float __attribute__((vector_size(32)));
using I8 = std::int32_t __attribute__((vector_size(32)));

#define TACTOR_INLINE inline __attribute__((always_inline))

TACTOR_INLINE F8 load(const float* p) {
  F8 v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}
TACTOR_INLINE void store(float* p, const F8& v) {
  __builtin_memcpy(p, &v, sizeof v);
}
TACTOR_INLINE F8 all(float v) {
  return F8{v, v, v, v, v, v, v, v};
}
TACTOR_INLINE F8 min(const F8& a, const F8& b) {
  return a < b ? a : b;
}
TACTOR_INLINE F8 max(const F8& a, const F8& b) {
  return a > b ? a : b;
}
TACTOR_INLINE float least(const F8& v) {
  const F8 a = min(v, __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3));
  const F8 b = min(a, __builtin_shufflevector(a, a, 2, 3, 0, 1, 6, 7, 4, 5));
  const F8 c = min(b, __builtin_shufflevector(b, b, 1, 0, 3, 2, 5, 4, 7, 6));
  return c[0];
}

/// The squared distances of x to eight faces.
TACTOR_INLINE F8 squared_distances(const FaceRecord* const* face, float x, float y, float z) {
  // Row r of all eight records becomes four vectors.
  F8 row[4][4];
#pragma GCC unroll 4
  for (int r = 0; r < 4; ++r) {
    F8 both[4];
#pragma GCC unroll 4
    for (int k = 0; k < 4; ++k) {
      F4 low, high;
      __builtin_memcpy(&low, reinterpret_cast<const char*>(face[k]) + 16 * r, sizeof low);
      __builtin_memcpy(&high, reinterpret_cast<const char*>(face[k + 4]) + 16 * r, sizeof high);
      both[k] = __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
    }
    const F8 s0 = __builtin_shufflevector(both[0], both[1], 0, 8, 1, 9, 4, 12, 5, 13);
    const F8 s1 = __builtin_shufflevector(both[0], both[1], 2, 10, 3, 11, 6, 14, 7, 15);
    const F8 s2 = __builtin_shufflevector(both[2], both[3], 0, 8, 1, 9, 4, 12, 5, 13);
    const F8 s3 = __builtin_shufflevector(both[2], both[3], 2, 10, 3, 11, 6, 14, 7, 15);
    row[r][0] = __builtin_shufflevector(s0, s2, 0, 1, 8, 9, 4, 5, 12, 13);
    row[r][1] = __builtin_shufflevector(s0, s2, 2, 3, 10, 11, 6, 7, 14, 15);
    row[r][2] = __builtin_shufflevector(s1, s3, 0, 1, 8, 9, 4, 5, 12, 13);
    row[r][3] = __builtin_shufflevector(s1, s3, 2, 3, 10, 11, 6, 7, 14, 15);
  }
  const F8 zero = all(0), one = all(1);
  const F8 px = x - row[0][0], py = y - row[0][1], pz = z - row[0][2];
  const F8 &ux = row[1][0], &uy = row[1][1], &uz = row[1][2];
  const F8 &vx = row[2][0], &vy = row[2][1], &vz = row[2][2];
  const F8 du = ux * px + uy * py + uz * pz, dv = vx * px + vy * py + vz * pz;
  const auto squared = [](const F8& rx, const F8& ry, const F8& rz) { return rx * rx + ry * ry + rz * rz; };

  // Every branch measures to a point of the face, so that a branch wrongly taken can only be too far.
  const F8 s = min(max(du * row[1][3], zero), one);
  F8 result = squared(px - s * ux, py - s * uy, pz - s * uz);
  const F8 t = min(max(dv * row[2][3], zero), one);
  result = min(result, squared(px - t * vx, py - t * vy, pz - t * vz));
  const F8 qx = px - ux, qy = py - uy, qz = pz - uz, wx = vx - ux, wy = vy - uy, wz = vz - uz;
  const F8 r = min(max((qx * wx + qy * wy + qz * wz) * row[3][3], zero), one);
  result = min(result, squared(qx - r * wx, qy - r * wy, qz - r * wz));
  const F8 m = row[3][0] * du - row[3][1] * dv, n = row[3][2] * dv - row[3][1] * du;
  const F8 on_face = squared(px - m * ux - n * vx, py - m * uy - n * vy, pz - m * uz - n * vz);
  const F8 inside = min(min(m, n), one - m - n) >= zero ? on_face : result;
  result = min(result, inside);
  // Not a number becomes 0.
  return result > zero ? result : zero;
}

/// Bit k is set where element k of `v` is all ones.
TACTOR_INLINE unsigned mask_of(const I8& v) {
  const I8 bits = v & I8{1, 2, 4, 8, 16, 32, 64, 128};
  const I8 a = bits | __builtin_shufflevector(bits, bits, 4, 5, 6, 7, 0, 1, 2, 3);
  const I8 b = a | __builtin_shufflevector(a, a, 2, 3, 0, 1, 6, 7, 4, 5);
  const I8 c = b | __builtin_shufflevector(b, b, 1, 0, 3, 2, 5, 4, 7, 6);
  return static_cast<unsigned>(c[0]);
}

/// What a search knows: the nearest face so far, and the squared distance in floats beyond which no face can be nearer.
struct Search {
  const Surface& surface;
  Vec3 x;            // m, in the frame of the mesh
  float fx, fy, fz;  // m, about the records' origin
  double error;      // m, of distances in floats
  NearestFace best;
  float limit = std::numeric_limits<float>::infinity();

  TACTOR_INLINE void look_at(int face) {
    // Of a point beyond what floats can square the face that fills up is as far as all others.
    if (face < 0) return;
    if (best.face < 0) {
      best = surface.candidate(face, x);
    } else {
      surface.compare(face, x, best);
    }
    const double reach = std::sqrt(best.squared) + error;
    limit = static_cast<float>(1.000001 * reach * reach);
  }

  /// Takes eight faces into account.
  TACTOR_INLINE void consider(const FaceRecord* const* face) {
    const F8 squared = squared_distances(face, fx, fy, fz);
    const float nearest = least(squared);
    if (!(nearest <= limit)) return;
    const int first = std::countr_zero(mask_of(squared <= all(nearest)));
    look_at(face[first]->face);
    unsigned others = mask_of(squared <= all(limit)) & ~(1U << first);
    for (; others != 0; others &= others - 1) look_at(face[std::countr_zero(others)]->face);
  }
};

/// A search of the tree's faces about x that has seen none yet.
TACTOR_INLINE Search search_about(const FaceTree& tree, const Surface& surface, const Vec3& x) {
  const Vec3 about = x - tree.origin;
  return {.surface = surface,
          .x = x,
          .fx = static_cast<float>(about.x),
          .fy = static_cast<float>(about.y),
          .fz = static_cast<float>(about.z),
          .error = relative_error * (norm(about) + tree.reach),
          .best = {}};
}

}  // namespace tactor::wide
