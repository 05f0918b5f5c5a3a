// What moves the bodies of a trial: the project's node, or ODE's world.
#pragma once

#include <memory>
#include <vector>

#include "bench/stability/trial.hpp"

namespace tactor::bench {

/// A state that a stepper has reached.
struct Reached {
  Time t;
  DeviceState device;
  BodyStates bodies;
};

class Stepper {
 public:
  virtual ~Stepper() = default;
  /// Moves the bodies from where they are to `until`, one physics period on, with the contacts of a query made where
  /// they are. Puts the states on the way into `reached`, the last one at `until`. Throws RunError where it gives up.
  virtual void advance(const ContactSet& set, Time until, std::vector<Reached>& reached) = 0;
  /// Adds what it counted.
  virtual void report(Finding& finding) const { static_cast<void>(finding); }
};

/// A way to step, by name.
struct Contender {
  std::string name;
  std::function<std::unique_ptr<Stepper>(const Trial& trial, Duration period)> make;
};

/// The project's dynamics node (dynamics.translation where nothing turns, else dynamics.rigid) with its default
/// parameters, except that energy made out of nothing stays in the motion where `as_made`, fed with a device of 1 kHz
/// (of the physics rate, where that is higher).
std::unique_ptr<Stepper> make_tactor(const Trial& trial, Duration period, bool as_made);

/// How ODE steps.
struct OdeOptions {
  bool quick = false;            ///< dWorldQuickStep, with its default of 20 iterations, instead of dWorldStep
  bool explicit_spring = false;  ///< the coupling as a force at the beginning of the step instead of a joint
  bool substeps = false;         ///< steps of 1 ms at most, with the contact planes followed in between
};
/// ODE's world with the coupling as a soft ball joint to a kinematic body, whose ERP = h k / (h k + b) and
/// CFM = 1 / (h k + b) make it an implicit spring and damper (ODE manual, 3.8.2), torsion likewise by an angular motor
/// with closed stops; contacts as soft contact joints with the same formula, a friction pyramid in proportion to the
/// normal force, and no restitution. Contact joints are made for contacts that penetrate.
std::unique_ptr<Stepper> make_ode(const Trial& trial, Duration period, OdeOptions options);

/// All of them, ours first.
std::vector<Contender> contenders();

}  // namespace tactor::bench
