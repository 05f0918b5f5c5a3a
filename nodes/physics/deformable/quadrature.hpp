// Where elements are integrated, and what their mid-edge nodes add to the deformation gradient.
#pragma once

#include <array>

#include <Eigen/Core>

namespace tactor {

/// Edges of a tetrahedron in the order of its mid-edge nodes 4 to 9.
inline constexpr std::array<std::array<int, 2>, 6> tet_edges{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// Barycentric coordinates of quadrature points of equal weight: `near` for one corner, `far` for the other three.
/// Exact to the second degree (Hammer and Stroud 1956). near = (5 + 3 sqrt 5) / 20, far = (5 - sqrt 5) / 20.
inline constexpr double tet_near = 0.58541019662496845446, tet_far = 0.13819660112501051518;

/// Of an element of straight edges the deformation gradient at a point is F = sum_c y_c (grad L_c)^T over its four
/// corners, L the barycentric coordinates. Linear: y = x.
inline void corner_values(const std::array<Eigen::Vector3d, 4>& x, int /*point*/, std::array<Eigen::Vector3d, 4>& y) {
  y = x;
}
/// Quadratic, at the point near corner `point`: y_c = (4 L_c - 1) x_c + sum over edges (c, b) of 4 L_b x_cb.
inline void corner_values(const std::array<Eigen::Vector3d, 10>& x, int point, std::array<Eigen::Vector3d, 4>& y) {
  const auto l = [point](std::size_t c) { return static_cast<int>(c) == point ? tet_near : tet_far; };
  for (std::size_t c = 0; c < 4; ++c) y[c] = (4 * l(c) - 1) * x[c];
  for (std::size_t e = 0; e < 6; ++e) {
    const auto a = static_cast<std::size_t>(tet_edges[e][0]), b = static_cast<std::size_t>(tet_edges[e][1]);
    y[a] += 4 * l(b) * x[4 + e];
    y[b] += 4 * l(a) * x[4 + e];
  }
}

/// The transposed of it: from forces on y to forces on x, added.
inline void add_node_values(const std::array<Eigen::Vector3d, 4>& y, int /*point*/, std::array<Eigen::Vector3d, 4>& x) {
  for (std::size_t c = 0; c < 4; ++c) x[c] += y[c];
}
inline void add_node_values(const std::array<Eigen::Vector3d, 4>& y, int point, std::array<Eigen::Vector3d, 10>& x) {
  const auto l = [point](std::size_t c) { return static_cast<int>(c) == point ? tet_near : tet_far; };
  for (std::size_t c = 0; c < 4; ++c) x[c] += (4 * l(c) - 1) * y[c];
  for (std::size_t e = 0; e < 6; ++e) {
    const auto a = static_cast<std::size_t>(tet_edges[e][0]), b = static_cast<std::size_t>(tet_edges[e][1]);
    x[4 + e] += 4 * l(b) * y[a] + 4 * l(a) * y[b];
  }
}

}  // namespace tactor
