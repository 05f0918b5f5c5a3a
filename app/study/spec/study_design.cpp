// Ranges and designs of a study: which combinations of values are run.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>

#include "app/study/spec/study_spec.hpp"
#include "framework/core/check.hpp"
#include "framework/core/random.hpp"

namespace tactor {

namespace {

/// Six significant digits, so that a table can be read and a range of any length ends on round numbers.
std::string six_digits(double value) {
  std::array<char, 40> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::general, 6);
  return {buffer.data(), result.ptr};
}

/// In [0, 1), the k-th of the stream `name`.
double draw(std::uint64_t seed, const std::string& name, std::size_t k) {
  return static_cast<double>(derive_seed(seed, name + "#" + std::to_string(k)) >> 11U) * 0x1p-53;
}

/// The slices 0 to n - 1 in an order drawn for the axis.
std::vector<std::size_t> shuffled(std::size_t n, std::uint64_t seed, const std::string& name) {
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::vector<double> keys;
  for (std::size_t k = 0; k < n; ++k) keys.push_back(draw(seed, name + " order", k));
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return keys[a] < keys[b]; });
  return order;
}

std::vector<StudyPoint> grid(const std::vector<StudyAxis>& axes) {
  std::vector<StudyPoint> points(1);
  for (const StudyAxis& axis : axes) {
    std::vector<StudyPoint> more;
    for (const StudyPoint& point : points) {
      for (const StudyValue& value : axis.values) {
        more.push_back(point);
        more.back().values.push_back(value);
      }
    }
    points = std::move(more);
  }
  return points;
}

std::vector<StudyPoint> one_at_a_time(const std::vector<StudyAxis>& axes) {
  StudyPoint base;
  for (const StudyAxis& axis : axes) base.values.push_back(axis.values.front());
  std::vector<StudyPoint> points{base};
  for (std::size_t a = 0; a < axes.size(); ++a) {
    for (std::size_t v = 1; v < axes[a].values.size(); ++v) {
      points.push_back(base);
      points.back().values[a] = axes[a].values[v];
    }
  }
  return points;
}

std::vector<StudyPoint> latin_hypercube(const StudySpec& spec) {
  const auto n = static_cast<std::size_t>(spec.samples);
  std::vector<StudyPoint> points(n);
  for (const StudyAxis& axis : spec.vary) {
    const std::vector<std::size_t> slice = shuffled(n, spec.design_seed, axis.name);
    for (std::size_t i = 0; i < n; ++i) {
      const double q = (static_cast<double>(slice[i]) + draw(spec.design_seed, axis.name, i)) / static_cast<double>(n);
      if (axis.range) {
        points[i].values.push_back({axis.range->at(q), {}, axis.values.front().place});
      } else {
        const auto v = static_cast<std::size_t>(q * static_cast<double>(axis.values.size()));
        points[i].values.push_back(axis.values[std::min(v, axis.values.size() - 1)]);
      }
    }
  }
  return points;
}

}  // namespace

std::string StudyRange::at(double q) const {
  double value = log ? from * std::pow(to / from, q) : from + q * (to - from);
  if (q <= 0) value = from;
  if (q >= 1) value = to;
  if (whole) value = std::round(value);
  return six_digits(value) + (unit.empty() ? "" : " " + unit);
}

std::vector<StudyPoint> study_points(const StudySpec& spec) {
  switch (spec.design) {
    case StudyDesign::grid:
      return grid(spec.vary);
    case StudyDesign::one_at_a_time:
      return one_at_a_time(spec.vary);
    case StudyDesign::latin_hypercube:
      return latin_hypercube(spec);
  }
  TACTOR_DEMAND(false);
}

}  // namespace tactor
