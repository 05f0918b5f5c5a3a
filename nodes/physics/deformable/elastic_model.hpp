// All deformable bodies of a scene as one system of finite elements.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "framework/core/spatial.hpp"
#include "nodes/physics/deformable/soft_body.hpp"

namespace tactor {

/// Energy, forces and stiffness of elastic bodies, by positions of their nodes in the world.
///
/// Elements are tetrahedra whose edges are straight at rest. Linear ones have one quadrature point; quadratic ones have
/// four, exact to the second degree, and their mass matrix is exact. Fixed nodes stay in `x` and have no unknowns; a
/// mid-edge node is fixed where both ends of its edge are. After the first call of a function with the same output,
/// none of them allocates.
class ElasticModel {
 public:
  /// warped: R K_e R^T, the linear stiffness turned with the material (Mueller and Gross, Graphics Interface 2004):
  /// lacks the stiffness that stress adds; positive definite. Of the corotational law alone, else as projected.
  /// projected: the Hessian of each quadrature point with its negative eigenvalues set to 0, so that K is positive
  /// semidefinite (Smith, De Goes and Kim, TOG 2019).
  /// exact: the Hessian, which may be indefinite.
  /// mean: half of it and half of the warped one; half of the projected one of another law than the corotational, and
  /// where two singular values of F nearly cancel.
  enum class Tangent { warped, projected, exact, mean };

  /// Throws InputError where a body's lists do not fit its mesh, a modulus is out of its bounds, or a tetrahedron has
  /// no volume.
  ElasticModel(std::vector<SoftBody> bodies, Elasticity law, ElementOrder order);

  /// Of all bodies, fixed ones and mid-edge nodes included. Body b's are consecutive from first_node(b): those of its
  /// mesh in their order, then the mid-edge nodes in the order of their edges (lower end, upper end).
  [[nodiscard]] int nodes() const { return static_cast<int>(unknown_of_.size()); }
  [[nodiscard]] int first_node(int body) const { return first_node_[static_cast<std::size_t>(body)]; }
  /// The nodes between which a mid-edge node lies; for a node of the mesh, itself twice.
  [[nodiscard]] std::array<int, 2> ends_of(int node) const { return ends_[static_cast<std::size_t>(node)]; }

  /// Three for each free node, in the order of the nodes.
  [[nodiscard]] int unknowns() const { return 3 * static_cast<int>(node_of_.size()); }
  /// The first of a node's three, or -1 where it is fixed.
  [[nodiscard]] int unknown_of(int node) const { return unknown_of_[static_cast<std::size_t>(node)]; }
  [[nodiscard]] int node_of(int unknown) const { return node_of_[static_cast<std::size_t>(unknown / 3)]; }
  [[nodiscard]] int body_of(int unknown) const { return body_of_[static_cast<std::size_t>(unknown / 3)]; }

  [[nodiscard]] const std::vector<SoftBody>& bodies() const { return bodies_; }
  [[nodiscard]] Elasticity law() const { return law_; }
  [[nodiscard]] ElementOrder order() const { return order_; }
  /// Adds `share` times the displacement u (m, of the unknowns) to x (m, of all nodes).
  void displace(const Eigen::VectorXd& u, double share, Eigen::VectorXd& x) const;
  /// J, the work of `force` (N, on the unknowns) from rest to x (m, of all nodes).
  [[nodiscard]] double work(const Eigen::VectorXd& force, const Eigen::VectorXd& x) const;
  /// Tetrahedra of all bodies.
  [[nodiscard]] int elements() const { return static_cast<int>(elements_.size()); }
  /// m, 3 * nodes(): positions at rest.
  [[nodiscard]] const Eigen::VectorXd& rest() const { return rest_; }
  /// m^3, of all bodies at rest.
  [[nodiscard]] double volume() const;

  /// J, 0 at rest. `x`: m, 3 * nodes(), positions of all nodes.
  [[nodiscard]] double energy(const Eigen::VectorXd& x) const;
  /// N, elastic force on the unknowns: -d energy / d x.
  void force(const Eigen::VectorXd& x, Eigen::VectorXd& f) const;
  /// N/m, d(-f) / d x by the lower triangle, with the same pattern each time; and the force.
  void assemble(const Eigen::VectorXd& x, Tangent tangent, Eigen::SparseMatrix<double>& K, Eigen::VectorXd& f) const;
  /// kg, consistent, by the lower triangle, with the pattern of K.
  [[nodiscard]] const Eigen::SparseMatrix<double>& mass() const { return mass_; }
  /// N, on the unknowns: what gravity (m/s^2) does to each, by the shape functions. Of quadratic elements, the corners'
  /// share is against gravity.
  [[nodiscard]] Eigen::VectorXd weight(const Vec3& gravity) const;
  /// The least det F at a quadrature point: 1 at rest, 0 or less where an element is flat or inverted.
  [[nodiscard]] double smallest_volume_ratio(const Eigen::VectorXd& x) const;

 private:
  struct Element {
    std::array<Eigen::Vector3d, 3> gradient;  ///< 1/m, of the barycentric coordinates of corners 1, 2, 3
    double volume = 0;                        ///< m^3
    double mu = 0, lambda = 0;                ///< Pa, Lame's
  };
  /// Where a block of the lower triangle lies in the values: at `at` its first column, `length` values to the next.
  struct BlockPlace {
    int at = -1, length = 0;
  };

  void number_nodes();
  void add_mid_edges(std::size_t body, std::vector<std::array<int, 2>>& edges) const;
  [[nodiscard]] int body_at(int node) const;
  void make_elements();
  void make_pattern();
  void make_mass();

  template <class Law, std::size_t size>
  double energy_by(const Eigen::VectorXd& x) const;
  template <class Law, std::size_t size>
  void force_by(const Eigen::VectorXd& x, Eigen::VectorXd& f) const;
  template <class Law, std::size_t size>
  void assemble_by(const Eigen::VectorXd& x, Tangent tangent, double* values, Eigen::VectorXd& f) const;
  template <std::size_t size>
  double smallest_ratio(const Eigen::VectorXd& x) const;
  template <std::size_t size>
  void gather(std::size_t element, const Eigen::VectorXd& x, std::array<Eigen::Vector3d, size>& at) const;
  template <std::size_t size>
  void add_force(std::size_t element, const std::array<Eigen::Vector3d, size>& force, double* f) const;
  void add_blocks(std::size_t element, const Eigen::Matrix3d* blocks, double* values) const;

  std::vector<SoftBody> bodies_;
  Elasticity law_;
  ElementOrder order_;
  int size_;  ///< nodes of an element
  std::vector<int> first_node_;
  std::vector<std::array<int, 2>> ends_;
  std::vector<int> unknown_of_, node_of_, body_of_;
  Eigen::VectorXd rest_;
  std::vector<Element> elements_;
  std::vector<int>
      corners_;  ///< size_ nodes an element, ascending; mid-edges of (0,1) (0,2) (0,3) (1,2) (1,3) (2,3) last
  std::vector<BlockPlace> places_;  ///< size_ (size_ + 1) / 2 an element: (0,0), (1,0), (1,1), (2,0), ...
  Eigen::SparseMatrix<double> mass_;
};

}  // namespace tactor
