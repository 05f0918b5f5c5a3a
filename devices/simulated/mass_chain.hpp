// Two or three masses in a row on each axis, with springs and dampers between them: motors, handle and hand.
#pragma once

#include <array>
#include <cstddef>

#include "devices/simulated/cogging.hpp"
#include "devices/simulated/friction.hpp"
#include "devices/simulated/step_cache.hpp"
#include "framework/core/spatial.hpp"

namespace tactor {

/// Position (m) and velocity (m/s) of a point in W.
struct PointState {
  Vec3 p;
  Vec3 v;
};

/// N masses on each axis of W. x_1 is the motor side, x_N what the hand's spring and damper to the target hold:
///   m_1 a_1 = f_1 - b v_1 - friction(v_1) + cogging(x_1) + s_1
///   m_i a_i = s_i - s_{i-1}
///   m_N a_N = f_N - B v_N - K (x_N - x_N(0)) - s_{N-1}
///   s_i = k_i d_i + c_i (v_{i+1} - v_i),   d_i = x_{i+1} - x_i,
/// with the motors' force f_1 and the hand's f_N. The first link may have a half gap g:
///   s_1 = k_1 (d_1 - g sign d_1) + c_1 (v_2 - v_1) where |d_1| > g, else 0.
/// Inside the gap neither side feels the other. The damper may pull a little just before the contact opens.
///
/// Two masses are a motor side and a handle with a transmission between, or a device and a hand with a grip between;
/// three have both. The same holds for rotation by small angles (rad, kg m^2, N m).
///
/// A step of h: half of friction and cogging as impulses, the linear part exactly by the matrix exponential, the other
/// half (Strang splitting): an error of order h^2, and none where both are zero and there is no gap. An axis that
/// enters or leaves its gap within a step is stepped in halves of halves, down to h/256, so that it changes at most
/// h/256 late; a contact that opens and closes again within h/2^n of an undivided step is not seen. Motors at rest,
/// or that the first half of the friction brings to rest, stay for the step where the force on them is at most the
/// friction. Stable for any constants, since each part is.
template <std::size_t N>
class MassChain {
 public:
  struct Link {
    double stiffness = 0;  ///< N/m
    double damping = 0;    ///< N s/m
  };
  /// `damping` b, `motor_friction` and `cogging` act on the first mass, `hand_stiffness` K and `hand_damping` B on the
  /// last.
  struct Parameters {
    std::array<double, N> mass{};    ///< kg, above 0
    std::array<Link, N - 1> link{};  ///< from mass i to mass i + 1
    double half_gap = 0;             ///< m, of the first link, to each side, of every axis
    double damping = 0;              ///< N s/m
    double hand_stiffness = 0;       ///< N/m
    double hand_damping = 0;         ///< N s/m
  };
  using Points = std::array<PointState, N>;

  MassChain(const Parameters& parameters, const Friction& motor_friction, const Cogging& cogging);

  /// The longest step (s) that sees the contacts of its gap; no bound where there is none.
  [[nodiscard]] double longest_step() const;
  /// Moves all masses on by `h` s under `motor_F_W` on the first, while the hand pulls with `hand_F_W` at the last
  /// one's present place.
  void advance(double h, const Vec3& motor_F_W, const Vec3& hand_F_W, Points& points) noexcept;
  /// The first link's force on the first mass, in W.
  [[nodiscard]] Vec3 link_force(const PointState& motor, const PointState& next) const noexcept;

 private:
  static constexpr int finest = 8;  // halvings of a step
  /// y_1, v_1, y_2, v_2, ... (rows) after a step from y = 0, by v_1, v_2, ..., f_1, f_2, ... (columns).
  using Propagator = std::array<std::array<double, 2 * N>, 2 * N>;
  using Levels = std::array<Propagator, finest + 1>;  // of h, h/2, h/4, ...
  // By what the motor side does (0: it moves, 1: friction holds it) and the first link (0: in the gap, 1: it touches).
  using Regimes = std::array<std::array<Levels, 2>, 2>;
  struct Axis {
    std::array<double, N> x, v;
  };

  void make_regimes(double h, Regimes& regimes) const noexcept;
  void make_levels(double h, bool held, bool touching, Levels& levels) const noexcept;
  [[nodiscard]] double side_of(double d) const noexcept;
  void step(Axis& axis, const Propagator& by, double side, double motor_f, double hand_f, double start) const noexcept;
  void advance_axis(Axis& axis, const std::array<Levels, 2>& by, double motor_f, double hand_f) const noexcept;

  Parameters parameters_;
  Friction friction_;
  Cogging cogging_;
  StepCache<Regimes> regimes_;
};

extern template class MassChain<2>;
extern template class MassChain<3>;

}  // namespace tactor
