// Learns from physics' own contact force how stiff and how rough the contacts of the tool really are.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "framework/core/messages.hpp"
#include "nodes/physics/contact/local_contacts.hpp"
#include "nodes/physics/mechanics/contact_correction.hpp"
#include "nodes/physics/mechanics/system.hpp"

namespace tactor {

/// What is wrong with a model of contacts, as two numbers for all contacts of the tool.
struct ContactError {
  double stiffness_scale = 1;  ///< multiplies stiffness, damping and inertia
  double friction_excess = 0;  ///< is added to each Coulomb coefficient; what comes out is 0 at least
};

/// What a result of physics was to the fit.
enum class FitOutcome : std::uint8_t {
  used,
  silent,       ///< nothing pushes in physics or in the model, or too little: it says nothing
  awaiting,     ///< a surprise that the next one has to confirm; nothing has changed
  unexplained,  ///< no stiffness and friction within the bounds makes it; nothing has changed
  repeated,     ///< no later than one that was used or waited
  unusable,     ///< not finite, or not of these bodies
};

/// A Kalman filter of (a, e), the stiffness scale and the friction excess. At a result of physics the contacts of the
/// model, where the bodies are then, would push the tool by
///   h(a, e) = a sum_i N_i (n_i + max(0, mu_i + e) t_i),   t_i = -u_ti / |u_ti|,
///   N_i = max(0, -k_i d_i - b_i n_i . u_i - m_i n_i . u_i' + l_i b_i mu_i s_i),
/// a force and a torque about the tool's origin, with d_i the distance there, u_i the relative velocity at the contact,
/// u_i' its rate by the tool's acceleration, k_i, b_i, m_i stiffness, damping and inertia times weight, l_i the lift
/// and s_i the sliding beyond the creep: the law of RigidStep. Physics' own contact wrench is compared with it; weight
/// and coupling are in neither. The torque is divided by the root mean square of the levers, weighted with N_i, so that
/// all is in N; of a tool that does not rotate it is left out.
///
/// Each number of the wrench has the standard deviation r, r^2 = (20 mN)^2 + (5 % of F)^2 + a^2 sum_i (k_i 2 um)^2,
/// with F the norm of physics' force or a sum_i N_i (1 + max(0, mu_i + e)), whichever is more. So a small force tells
/// little, and a result that alone tells neither a to better than its half nor e to better than 0.5 is not used. What
/// of the difference h has no slope for, whatever a and e, raises the variance: by its mean square in units of r, if
/// above 1.
///
/// A contact that creeps at less than twice the stick velocity, or than twice its own creep, sticks: its friction is
/// anything within the cone. Then it is an unknown force in the plane of the contact, whose variance, (10 a N_i (1 +
/// max(0, mu_i + e)))^2 in each direction, adds to that of the wrench. Only if it is more than the friction of the
/// model could hold does it raise e, along the direction in which the contacts creep.
///
/// Both numbers may drift, by 0.4 % and 0.004, with each result that tells of them to better than a half, and with
/// nothing else. What lies within three standard deviations of what is expected is met at once. Of what lies beyond,
/// two results in a row have to agree, each judged with nothing known before, within three standard deviations; then
/// the estimate is theirs. 0.1 <= a <= 10, e <= 2, and of a result -max_i mu_i <= e; an e known to be below that stays,
/// for contacts that have more friction to lose. A result that with the numbers it has led to is still three standard
/// deviations off, in what h has slopes for, is one of another law of contact: it changes nothing.
///
/// The estimate is of the materials (stiffness, damping and friction as declared) that pushed in the last result that
/// was used, all of them together. Contacts of others are left as they are, and it begins at (1, 0) again with the
/// first result that is of others alone.
///
/// Allocates nothing and throws nothing.
class ContactFit {
 public:
  /// `rotates`: the tool has 6 degrees of freedom. `stick_velocity`: m/s, as dynamics has it. `scales`: of all
  /// contacts, before the estimate.
  ContactFit(bool rotates, double stick_velocity, const ContactCorrection& scales = {})
      : rotates_(rotates), stick_velocity_(stick_velocity), scales_(scales) {}

  /// `contacts`: as declared, around `bodies`, those of the result that is valid at `valid`; `massless`: the tool was
  /// moved without its inertia, hence without dampers. `contact_T_W`, N and N m about the tool's origin: of
  /// `touching` contacts. `acceleration`: m/s^2 and rad/s^2, of the tool then, which contacts with inertia feel.
  FitOutcome take(Time valid, const LocalContacts& contacts, const BodyStates& bodies, bool massless,
                  const Wrench& contact_T_W, int touching, const Twist& acceleration = {});
  /// The same with the contacts that dynamics itself used, as planes. With these an old or coarse query makes no
  /// difference, and what is left comes from another law of contact.
  FitOutcome take(Time valid, const ContactPlanes& planes, const BodyStates& bodies, bool massless,
                  const Wrench& contact_T_W, int touching, const Twist& acceleration = {});

  [[nodiscard]] const ContactError& error() const { return error_; }
  /// The estimate, for the contacts of the tool as declared.
  [[nodiscard]] ContactCorrection correction() const;

  /// N: what of the contact wrench of the last result the estimate does not explain, but for what contacts that stick
  /// may hold. Near 0 where physics has the law of RigidStep, however coarse its steps are; 0 before the first result.
  [[nodiscard]] double law_error() const { return law_error_; }

  [[nodiscard]] std::int64_t used() const { return used_; }
  /// Those used results that told of friction.
  [[nodiscard]] std::int64_t used_for_friction() const { return used_for_friction_; }
  /// Those results that no stiffness and friction explains.
  [[nodiscard]] std::int64_t unexplained() const { return unexplained_; }
  /// How often two results in a row were so far off that the estimate became theirs, and how often the materials did.
  [[nodiscard]] std::int64_t surprises() const { return surprises_; }
  [[nodiscard]] std::int64_t resets() const { return resets_; }

  using Vector6 = Eigen::Matrix<double, 6, 1>;

 private:
  using Material = ContactMaterial;
  static constexpr int most_materials = ContactCorrection::most_materials;
  /// Distinct ones of what pushes; further ones are left out.
  struct Materials {
    std::array<Material, most_materials> of{};
    int count = 0;
    [[nodiscard]] bool has(const Material& material) const;
    void add(const Material& material);
    [[nodiscard]] bool any_of(const Materials& others) const;
  };
  /// A contact that pushes, as the model has it.
  struct Push {
    double N = 0;         // N, normal force
    double friction = 0;  // Coulomb coefficient
    bool slides = false;
    Vector6 normal = Vector6::Zero();  // N, wrench of the normal force
    Vector6 rub = Vector6::Zero();     // N, wrench of a friction of coefficient 1
    Vec3 n, lever;
  };
  struct Model;
  struct Difference;
  /// (a, e) and its variance.
  struct Estimate {
    Eigen::Vector2d x = {1, 0};
    Eigen::Matrix2d P = Eigen::Matrix2d::Identity();
  };

  FitOutcome take_gathered(Time valid, const BodyStates& bodies, bool massless, const Wrench& contact_T_W, int touching,
                           const Twist& acceleration);
  FitOutcome learn_from(Time valid, const Vector6& measured, const Materials& materials);
  [[nodiscard]] double left_over(const Vector6& measured) const;
  int collect(const BodyStates& bodies, bool massless, const Twist& acceleration, Materials& materials);
  [[nodiscard]] Eigen::Matrix<double, 6, 6> noise(const Vector6& measured, const Eigen::Vector2d& at,
                                                  double& base) const;
  [[nodiscard]] Model model(const Eigen::Vector2d& at, bool all_slide) const;
  [[nodiscard]] Difference difference(const Vector6& measured, const Eigen::Vector2d& at) const;
  FitOutcome update(const Vector6& measured, const Materials& materials);
  [[nodiscard]] bool learn(const Vector6& measured, const Difference& now, Estimate& estimate) const;
  [[nodiscard]] bool raise_by_sticking(const Vector6& measured, double base, Estimate& estimate) const;
  [[nodiscard]] bool fuse(const Vector6& measured, const Eigen::Matrix<double, 6, 6>& weight, bool all_slide,
                          Estimate& estimate) const;
  [[nodiscard]] bool confirms(const Estimate& alone, const Materials& materials) const;
  void keep_excess_below_use(const Estimate& before, Estimate& estimate) const;

  bool rotates_;
  double stick_velocity_;
  ContactCorrection scales_;
  // Contacts of the tool where the bodies are.
  std::array<Contact, ContactSet::capacity> contacts_;
  std::array<ContactPair, ContactSet::capacity> pairs_;
  std::size_t count_ = 0;
  ContactError error_;
  Eigen::Matrix2d P_ = Estimate{}.P;
  Materials materials_;      // of the last result used; none: nothing is known
  Estimate candidate_;       // what the last result that told of anything alone would have, if it was a surprise
  Materials candidate_for_;  // none: there is none
  bool any_ = false;
  Time last_;
  std::array<Push, ContactSet::capacity> pushes_;
  int push_count_ = 0;
  double lever_ = 1;        // m, root mean square
  double depth_noise_ = 0;  // N, of the distances
  double lowest_ = 0;       // of the excess, with what pushes now
  double law_error_ = 0;    // N
  std::int64_t used_ = 0, used_for_friction_ = 0, surprises_ = 0, resets_ = 0, unexplained_ = 0;
};

}  // namespace tactor
