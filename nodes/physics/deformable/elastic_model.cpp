#include "nodes/physics/deformable/elastic_model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <Eigen/LU>

#include "framework/core/check.hpp"
#include "nodes/physics/deformable/elastic_law.hpp"
#include "nodes/physics/deformable/quadrature.hpp"

namespace tactor {

namespace {

/// A tetrahedron's corners, ascending, so that all its pairs of nodes are ordered as their unknowns are.
std::array<int, 4> ascending(std::array<int, 4> tet) {
  std::sort(tet.begin(), tet.end());
  return tet;
}

/// Of the mass rho V times this, between nodes a and b of an element: integrals of products of shape functions.
double mass_share(int nodes, int a, int b) {
  if (nodes == 4) return a == b ? 0.1 : 0.05;
  if (a < 4 && b < 4) return (a == b ? 6.0 : 1.0) / 420;
  const auto& edge = tet_edges[static_cast<std::size_t>(std::max(a, b) - 4)];
  if (a < 4 || b < 4) {
    const int corner = std::min(a, b);
    return (edge[0] == corner || edge[1] == corner ? -4.0 : -6.0) / 420;
  }
  if (a == b) return 32.0 / 420;
  const auto& other = tet_edges[static_cast<std::size_t>(std::min(a, b) - 4)];
  const bool meet = edge[0] == other[0] || edge[0] == other[1] || edge[1] == other[0] || edge[1] == other[1];
  return (meet ? 16.0 : 8.0) / 420;
}

}  // namespace

ElasticModel::ElasticModel(std::vector<SoftBody> bodies, Elasticity law, ElementOrder order)
    : bodies_(std::move(bodies)), law_(law), order_(order), size_(order == ElementOrder::linear ? 4 : 10) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) check_soft_body(bodies_[b], b);
  number_nodes();
  make_elements();
  make_pattern();
  make_mass();
}

void ElasticModel::number_nodes() {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const SoftBody& body = bodies_[b];
    const int first = static_cast<int>(ends_.size());
    first_node_.push_back(first);
    const auto add = [&](bool fixed, std::array<int, 2> ends) {
      ends_.push_back(ends);
      unknown_of_.push_back(fixed ? -1 : 3 * static_cast<int>(node_of_.size()));
      if (fixed) return;
      node_of_.push_back(static_cast<int>(ends_.size()) - 1);
      body_of_.push_back(static_cast<int>(b));
    };
    for (std::size_t i = 0; i < body.mesh.nodes.size(); ++i) {
      const int node = first + static_cast<int>(i);
      add(body.fixed[i] != 0, {node, node});
    }
    std::vector<std::array<int, 2>> edges;
    if (order_ == ElementOrder::quadratic) add_mid_edges(b, edges);
    for (const auto& [low, high] : edges) {
      add(body.fixed[static_cast<std::size_t>(low)] != 0 && body.fixed[static_cast<std::size_t>(high)] != 0,
          {first + low, first + high});
    }
    const int middle = first + static_cast<int>(body.mesh.nodes.size());
    for (const std::array<int, 4>& tet : body.mesh.tets) {
      const std::array<int, 4> sorted = ascending(tet);
      for (const int node : sorted) corners_.push_back(first + node);
      if (order_ == ElementOrder::linear) continue;
      for (const auto& [a, c] : tet_edges) {
        const std::array<int, 2> edge{sorted[static_cast<std::size_t>(a)], sorted[static_cast<std::size_t>(c)]};
        corners_.push_back(middle +
                           static_cast<int>(std::lower_bound(edges.begin(), edges.end(), edge) - edges.begin()));
      }
    }
  }
  rest_.resize(3 * nodes());
  for (int node = 0; node < nodes(); ++node) {
    const auto end = static_cast<std::size_t>(body_at(node));
    const auto place = [&](int n) {
      const Vec3& p = bodies_[end].mesh.nodes[static_cast<std::size_t>(n - first_node_[end])];
      return Eigen::Vector3d(p.x, p.y, p.z);
    };
    const auto [low, high] = ends_of(node);
    rest_.segment<3>(3 * node) = low == high ? place(low) : Eigen::Vector3d(0.5 * (place(low) + place(high)));
  }
}

int ElasticModel::body_at(int node) const {
  return static_cast<int>(std::upper_bound(first_node_.begin(), first_node_.end(), node) - first_node_.begin()) - 1;
}

void ElasticModel::add_mid_edges(std::size_t body, std::vector<std::array<int, 2>>& edges) const {
  for (const std::array<int, 4>& tet : bodies_[body].mesh.tets) {
    const std::array<int, 4> sorted = ascending(tet);
    for (const auto& [a, b] : tet_edges)
      edges.push_back({sorted[static_cast<std::size_t>(a)], sorted[static_cast<std::size_t>(b)]});
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
}

void ElasticModel::make_elements() {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const SoftBody& body = bodies_[b];
    for (std::size_t t = 0; t < body.mesh.tets.size(); ++t) {
      const std::array<int, 4> tet = ascending(body.mesh.tets[t]);
      Eigen::Matrix3d edges;
      const auto corner = [&](std::size_t c) { return rest_.segment<3>(3 * (first_node_[b] + tet[c])); };
      for (std::size_t c = 1; c < 4; ++c) edges.col(static_cast<int>(c) - 1) = corner(c) - corner(0);
      const Eigen::Matrix3d inverse = edges.inverse();
      const Lame moduli = lame(body.young[t], body.poisson);
      Element element;
      for (std::size_t c = 0; c < 3; ++c) element.gradient[c] = inverse.row(static_cast<int>(c)).transpose();
      element.volume = std::abs(edges.determinant()) / 6;
      element.mu = moduli.mu;
      element.lambda = moduli.lambda;
      elements_.push_back(element);
    }
  }
}

void ElasticModel::make_pattern() {
  const auto size = static_cast<std::size_t>(size_);
  const std::size_t free = node_of_.size();
  // For each free node, the free nodes above it that share an element with it.
  std::vector<std::vector<int>> above(free);
  const auto number = [&](std::size_t element, std::size_t k) { return unknown_of(corners_[element * size + k]) / 3; };
  const auto is_free = [&](std::size_t element, std::size_t k) {
    return unknown_of(corners_[element * size + k]) >= 0;
  };
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    for (std::size_t i = 0; i < size; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (is_free(e, i) && is_free(e, j)) above[static_cast<std::size_t>(number(e, j))].push_back(number(e, i));
      }
    }
  }
  std::size_t blocks = 0;
  for (std::vector<int>& list : above) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    blocks += list.size();
  }
  mass_.resize(unknowns(), unknowns());
  mass_.resizeNonZeros(static_cast<Eigen::Index>(9 * blocks + 6 * free));
  int at = 0;
  for (std::size_t n = 0; n < free; ++n) {
    for (int column = 0; column < 3; ++column) {
      mass_.outerIndexPtr()[3 * n + static_cast<std::size_t>(column)] = at;
      for (int row = column; row < 3; ++row) mass_.innerIndexPtr()[at++] = 3 * static_cast<int>(n) + row;
      for (const int other : above[n]) {
        for (int row = 0; row < 3; ++row) mass_.innerIndexPtr()[at++] = 3 * other + row;
      }
    }
  }
  mass_.outerIndexPtr()[3 * free] = at;
  places_.reserve(elements_.size() * size * (size + 1) / 2);
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    for (std::size_t i = 0; i < size; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        BlockPlace place;
        if (is_free(e, i) && is_free(e, j)) {
          const std::vector<int>& list = above[static_cast<std::size_t>(number(e, j))];
          place.at = mass_.outerIndexPtr()[3 * number(e, j)];
          place.length = 3 + 3 * static_cast<int>(list.size());
          if (i != j)
            place.at +=
                3 + 3 * static_cast<int>(std::lower_bound(list.begin(), list.end(), number(e, i)) - list.begin());
        }
        places_.push_back(place);
      }
    }
  }
}

void ElasticModel::make_mass() {
  std::fill_n(mass_.valuePtr(), mass_.nonZeros(), 0.0);
  const auto size = static_cast<std::size_t>(size_);
  std::vector<Eigen::Matrix3d> blocks(size * (size + 1) / 2);
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const double mass = bodies_[static_cast<std::size_t>(body_at(corners_[e * size]))].density * elements_[e].volume;
    std::size_t k = 0;
    for (int i = 0; i < size_; ++i) {
      for (int j = 0; j <= i; ++j) blocks[k++] = mass * mass_share(size_, i, j) * Eigen::Matrix3d::Identity();
    }
    add_blocks(e, blocks.data(), mass_.valuePtr());
  }
}

void ElasticModel::displace(const Eigen::VectorXd& u, double share, Eigen::VectorXd& x) const {
  for (int unknown = 0; unknown < unknowns(); unknown += 3) {
    x.segment<3>(3 * node_of(unknown)) += share * u.segment<3>(unknown);
  }
}

double ElasticModel::work(const Eigen::VectorXd& force, const Eigen::VectorXd& x) const {
  double sum = 0;
  for (int unknown = 0; unknown < unknowns(); unknown += 3) {
    const Eigen::Index at = 3 * node_of(unknown);
    sum += force.segment<3>(unknown).dot(x.segment<3>(at) - rest_.segment<3>(at));
  }
  return sum;
}

double ElasticModel::volume() const {
  double sum = 0;
  for (const Element& element : elements_) sum += element.volume;
  return sum;
}

Eigen::VectorXd ElasticModel::weight(const Vec3& gravity) const {
  Eigen::VectorXd f = Eigen::VectorXd::Zero(unknowns());
  const auto size = static_cast<std::size_t>(size_);
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const double mass = bodies_[static_cast<std::size_t>(body_at(corners_[e * size]))].density * elements_[e].volume;
    for (std::size_t i = 0; i < size; ++i) {
      const int unknown = unknown_of(corners_[e * size + i]);
      if (unknown < 0) continue;
      // The integral of the shape function over the volume.
      const double share = size == 4 ? 0.25 : i < 4 ? -0.05 : 0.2;
      f.segment<3>(unknown) += mass * share * Eigen::Vector3d(gravity.x, gravity.y, gravity.z);
    }
  }
  return f;
}

}  // namespace tactor
