// The exponential of a small square matrix, for exact steps of linear motion.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace tactor {

template <std::size_t N>
using SquareMatrix = std::array<std::array<double, N>, N>;

template <std::size_t N>
SquareMatrix<N> product(const SquareMatrix<N>& a, const SquareMatrix<N>& b) {
  SquareMatrix<N> c{};
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t k = 0; k < N; ++k) {
      if (a[i][k] == 0) continue;  // as in the rows of held forces
      for (std::size_t j = 0; j < N; ++j) c[i][j] += a[i][k] * b[k][j];
    }
  }
  return c;
}

/// exp(a) by scaling and squaring of its Taylor series; 14 terms are exact in double for a norm up to 1/4.
template <std::size_t N>
SquareMatrix<N> exponential(SquareMatrix<N> a) {
  double size = 0;
  for (const auto& row : a) {
    double sum = 0;
    for (const double entry : row) sum += std::abs(entry);
    size = std::max(size, sum);
  }
  int halvings = 0;
  for (; size > 0.25 && halvings < 60; size *= 0.5) ++halvings;
  SquareMatrix<N> one{};
  for (std::size_t i = 0; i < N; ++i) {
    one[i][i] = 1;
    for (double& entry : a[i]) entry = std::ldexp(entry, -halvings);
  }
  SquareMatrix<N> sum = one;
  // Horner: 1 + a (1 + a/2 (1 + a/3 (...))).
  for (int n = 14; n >= 1; --n) {
    sum = product(a, sum);
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t j = 0; j < N; ++j) sum[i][j] = sum[i][j] / n + one[i][j];
    }
  }
  for (; halvings > 0; --halvings) sum = product(sum, sum);
  return sum;
}

}  // namespace tactor
