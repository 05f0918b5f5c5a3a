#include "nodes/physics/mechanics/energy.hpp"

#include "nodes/physics/mechanics/eigen.hpp"

namespace tactor {

double contact_energy(const SystemModel& model, const ContactPlanes& contacts, const BodyStates& bodies,
                      bool massless) {
  double energy = 0;
  for (std::size_t i = 0; i < contacts.planes.size(); ++i) {
    if (!usable(contacts, i, model.count)) continue;
    const Contact& c = contacts.planes[i];
    const PlaneNow now = plane_now(contacts, i, bodies.X_WB);
    if (!(now.distance < 0)) continue;
    energy += 0.5 * c.stiffness * c.weight * now.distance * now.distance;
    if (c.inertia == 0 || massless) continue;
    const double speed = dot(now.n_W, relative_velocity(bodies, contacts.pairs[i], now.p_W));
    energy += 0.5 * c.inertia * c.weight * speed * speed;
  }
  return energy;
}

Energy system_energy(const SystemModel& model, const CouplingParameters& coupling, const DeviceState& device,
                     const ContactPlanes& contacts, const BodyStates& bodies) {
  Energy e;
  for (int i = coupling.massless != 0 ? 1 : 0; i < model.count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const BodyModel& body = model.body[at];
    const Twist& V = bodies.V_WB[at];
    e.kinetic += 0.5 * body.mass * dot(V.v, V.v);
    e.gravity -= body.mass * dot(model.gravity_W, bodies.X_WB[at].p);
    if (body.rotates) {
      const Eigen::Vector3d w = eigen(rotate(inverse(bodies.X_WB[at].R), V.w));
      e.kinetic += 0.5 * w.dot(body.inertia_B * w);
    }
  }
  const Vec3 stretch = device.X_WD.p - bodies.X_WB[0].p;
  e.spring = 0.5 * coupling.k_t * dot(stretch, stretch);
  if (model.body[0].rotates) {
    const Vec3 turn = to_rotation_vector(device.X_WD.R * inverse(bodies.X_WB[0].R));
    e.spring += 0.5 * coupling.k_r * dot(turn, turn);
  }
  e.contact = contact_energy(model, contacts, bodies, coupling.massless != 0);
  return e;
}

double handle_work(const SystemModel& model, const CouplingParameters& coupling, const DeviceState& before,
                   const DeviceState& after, const BodyStates& bodies) {
  const Pose& X_WT = bodies.X_WB[0];
  const Twist& V_WT = bodies.V_WB[0];
  double work = dot(coupling.k_t * (after.X_WD.p - X_WT.p) + coupling.b_t * (after.V_WD.v - V_WT.v),
                    after.X_WD.p - before.X_WD.p);
  if (model.body[0].rotates) {
    const Vec3 turn = to_rotation_vector(after.X_WD.R * inverse(X_WT.R));
    work += dot(coupling.k_r * turn + coupling.b_r * (after.V_WD.w - V_WT.w),
                to_rotation_vector(after.X_WD.R * inverse(before.X_WD.R)));
  }
  return work;
}

}  // namespace tactor
