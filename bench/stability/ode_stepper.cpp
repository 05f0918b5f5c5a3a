// ODE's world as a stepper.
#include <ode/ode.h>

#include <array>
#include <cstdarg>
#include <cstdio>

#include "bench/stability/stepper.hpp"
#include "framework/core/check.hpp"
#include "nodes/physics/mesh/body_mesh.hpp"

namespace tactor::bench {

namespace {

/// ODE ends the program where it gives up; a cell is to say so instead.
void give_up(int, const char* message, va_list arguments) {
  char text[256];
  std::vsnprintf(text, sizeof text, message, arguments);
  throw RunError(std::string("ODE: ") + text);
}

/// Started once, for all worlds.
void start_ode() {
  static const bool started = [] {
    dInitODE2(0);
    dSetErrorHandler(give_up);
    dSetDebugHandler(give_up);
    dSetMessageHandler([](int, const char*, va_list) {});
    return true;
  }();
  static_cast<void>(started);
}

/// Error reduction and constraint force mixing of an implicit spring k and damper b at step h.
struct Soft {
  double erp, cfm;
};
Soft soft(double k, double b, double h) {
  const double sum = h * k + b;
  return {h * k / sum, 1 / sum};
}

class OdeStepper final : public Stepper {
 public:
  OdeStepper(const Trial& trial, Duration period, OdeOptions options) : trial_(trial), options_(options) {
    start_ode();
    step_ = options.substeps ? std::min(period, Duration{1'000'000}) : period;
    // The quick step shuffles its rows.
    dRandSetSeed(1);
    world_ = dWorldCreate();
    contacts_ = dJointGroupCreate(0);
    const Vec3& g = trial.scene.gravity_W;
    dWorldSetGravity(world_, g.x, g.y, g.z);
    dWorldSetAutoDisableFlag(world_, 0);
    for (const std::size_t i : trial.scene.moving()) add_body(trial.scene.bodies[i]);
    hand_ = dBodyCreate(world_);
    dBodySetKinematic(hand_);
    const DeviceState start = trial.hand.at(now_, now_);
    place(bodies_[0], start.X_WD);
    place(hand_, start.X_WD);
    if (!options.explicit_spring) add_coupling(start.X_WD.p);
  }
  ~OdeStepper() override {
    dJointGroupDestroy(contacts_);
    dWorldDestroy(world_);
  }
  OdeStepper(const OdeStepper&) = delete;
  OdeStepper& operator=(const OdeStepper&) = delete;

  void advance(const ContactSet& set, Time until, std::vector<Reached>& reached) override {
    while (now_ < until) {
      const Time next = now_ + step_;
      const DeviceState begin = trial_.hand.at(now_, now_), end = trial_.hand.at(next, now_);
      pull(begin.X_WD, end.V_WD);
      dJointGroupEmpty(contacts_);
      touch(set);
      const int done = options_.quick ? dWorldQuickStep(world_, step_.seconds()) : dWorldStep(world_, step_.seconds());
      if (done == 0) throw RunError("ODE: the step found no memory");
      now_ = next;
      reached.push_back({next, end, states()});
    }
  }

 private:
  void add_body(const Body& body) {
    const dBodyID b = dBodyCreate(world_);
    dMass mass;
    if (body.motion == Motion::rigid) {
      const Eigen::Matrix3d I = body_inertia(body);
      dMassSetParameters(&mass, body.mass, 0, 0, 0, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
    } else {
      // So heavy to turn that it only translates.
      dMassSetParameters(&mass, body.mass, 0, 0, 0, 1e9, 1e9, 1e9, 0, 0, 0);
    }
    dBodySetMass(b, &mass);
    place(b, body.X_WB);
    bodies_.push_back(b);
  }

  void add_coupling(const Vec3& p) {
    const CouplingParameters& coupling = trial_.coupling;
    const double h = step_.seconds();
    const Soft pull = soft(coupling.k_t, coupling.b_t, h);
    const dJointID ball = dJointCreateBall(world_, nullptr);
    dJointAttach(ball, bodies_[0], hand_);
    dJointSetBallAnchor(ball, p.x, p.y, p.z);
    dJointSetBallParam(ball, dParamERP, pull.erp);
    dJointSetBallParam(ball, dParamCFM, pull.cfm);
    if (!trial_.scene.rotates()) return;
    const Soft turn = soft(coupling.k_r, coupling.b_r, h);
    torsion_ = dJointCreateAMotor(world_, nullptr);
    dJointAttach(torsion_, bodies_[0], hand_);
    dJointSetAMotorMode(torsion_, dAMotorUser);
    dJointSetAMotorNumAxes(torsion_, 3);
    for (int i = 0; i < 3; ++i) {
      dJointSetAMotorAxis(torsion_, i, 0, i == 0, i == 1, i == 2);
      const int group = dParamGroup * i;
      dJointSetAMotorParam(torsion_, group + dParamLoStop, 0);
      dJointSetAMotorParam(torsion_, group + dParamHiStop, 0);
      dJointSetAMotorParam(torsion_, group + dParamStopERP, turn.erp);
      dJointSetAMotorParam(torsion_, group + dParamStopCFM, turn.cfm);
    }
  }

  /// Puts the hand where the step begins, moving as it will, with the spring between it and the tool.
  void pull(const Pose& X_WD, const Twist& V_WD) {
    place(hand_, X_WD);
    dBodySetLinearVel(hand_, V_WD.v.x, V_WD.v.y, V_WD.v.z);
    dBodySetAngularVel(hand_, V_WD.w.x, V_WD.w.y, V_WD.w.z);
    const CouplingParameters& coupling = trial_.coupling;
    const Pose X_WT = pose(bodies_[0]);
    const Vec3 turn = to_rotation_vector(X_WD.R * inverse(X_WT.R));
    if (torsion_ != nullptr) {
      for (int i = 0; i < 3; ++i) dJointSetAMotorAngle(torsion_, i, -turn[i]);
    }
    if (!options_.explicit_spring) return;
    const Twist V_WT = twist(bodies_[0]);
    const Vec3 f = coupling.k_t * (X_WD.p - X_WT.p) + coupling.b_t * (V_WD.v - V_WT.v);
    dBodyAddForce(bodies_[0], f.x, f.y, f.z);
    if (!trial_.scene.rotates()) return;
    const Vec3 t = coupling.k_r * turn + coupling.b_r * (V_WD.w - V_WT.w);
    dBodyAddTorque(bodies_[0], t.x, t.y, t.z);
  }

  void touch(const ContactSet& set) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(set.count); ++i) {
      const Contact& c = set.contact[i];
      const ContactPair pair = set.pair[i];
      const auto body = static_cast<std::size_t>(pair.body);
      const Vec3 p = transform(pose(bodies_[body]), c.p_TC);
      Vec3 moved = p - transform(set.bodies.X_WB[body], c.p_TC);
      dBodyID other = nullptr;
      if (pair.other != ContactPair::fixed) {
        const auto o = static_cast<std::size_t>(pair.other);
        other = bodies_[o];
        moved -= transform(pose(other) * inverse(set.bodies.X_WB[o]), c.p_WC) - c.p_WC;
      }
      const double distance = c.distance + dot(c.n_W, moved);
      if (distance >= 0) continue;
      const Soft s = soft(c.stiffness * c.weight, c.damping * c.weight, step_.seconds());
      dContact contact{};
      contact.surface.mode = dContactSoftERP | dContactSoftCFM | dContactApprox1;
      contact.surface.mu = c.friction;
      contact.surface.soft_erp = s.erp;
      contact.surface.soft_cfm = s.cfm;
      for (int k = 0; k < 3; ++k) {
        contact.geom.pos[k] = p[k];
        contact.geom.normal[k] = c.n_W[k];
      }
      contact.geom.depth = -distance;
      dJointAttach(dJointCreateContact(world_, contacts_, &contact), bodies_[body], other);
    }
  }

  static void place(dBodyID body, const Pose& X) {
    dBodySetPosition(body, X.p.x, X.p.y, X.p.z);
    const dQuaternion q = {X.R.w, X.R.x, X.R.y, X.R.z};
    dBodySetQuaternion(body, q);
  }
  static Pose pose(dBodyID body) {
    const dReal* p = dBodyGetPosition(body);
    const dReal* q = dBodyGetQuaternion(body);
    return {{p[0], p[1], p[2]}, {q[0], q[1], q[2], q[3]}};
  }
  static Twist twist(dBodyID body) {
    const dReal* v = dBodyGetLinearVel(body);
    const dReal* w = dBodyGetAngularVel(body);
    return {{v[0], v[1], v[2]}, {w[0], w[1], w[2]}};
  }
  [[nodiscard]] BodyStates states() const {
    BodyStates states;
    for (const dBodyID body : bodies_) {
      const auto i = static_cast<std::size_t>(states.count++);
      states.X_WB[i] = pose(body);
      states.V_WB[i] = twist(body);
    }
    return states;
  }

  const Trial& trial_;
  OdeOptions options_;
  Duration step_;
  Time now_;
  dWorldID world_ = nullptr;
  dJointGroupID contacts_ = nullptr;
  dJointID torsion_ = nullptr;
  dBodyID hand_ = nullptr;
  std::vector<dBodyID> bodies_;
};

}  // namespace

std::unique_ptr<Stepper> make_ode(const Trial& trial, Duration period, OdeOptions options) {
  return std::make_unique<OdeStepper>(trial, period, options);
}

}  // namespace tactor::bench
