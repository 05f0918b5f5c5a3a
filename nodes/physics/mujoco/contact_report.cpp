#include "nodes/physics/mujoco/contact_report.hpp"

#include <algorithm>

#include "nodes/physics/mujoco/conversions.hpp"

namespace tactor {

namespace {

/// Which of the listed bodies it is, hangs on (the tool alone) or is welded to; `count` where it is none.
int place_of(const mjModel& m, const char* of_tool, const int* listed, int count, int body) {
  if (of_tool[body] != 0) return 0;
  return static_cast<int>(
      std::find_if(listed, listed + count, [&](int b) { return m.body_weldid[b] == m.body_weldid[body]; }) - listed);
}

/// The law of a contact along its normal, and of an elliptic cone across it too.
Contact law_of_rows(const mjData& d, const mjContact& c) {
  const int type = d.efc_type[c.efc_address];
  // The edges of a pyramid push together, each with a row of its own.
  const double edges = type == mjCNSTR_CONTACT_PYRAMIDAL ? 2 * (c.dim - 1) : 1;
  const double* row = d.efc_KBIP + 4 * c.efc_address;
  const double inertia = edges * d.efc_D[c.efc_address];
  Contact law{.distance = c.dist - c.includemargin,
              .weight = 1,
              .stiffness = inertia * row[0] * row[2],
              .damping = inertia * row[1],
              .friction = c.dim > 1 ? c.friction[0] : 0,
              .inertia = inertia};
  if (type == mjCNSTR_CONTACT_ELLIPTIC) {
    // Of the row of friction, whose inertia is impratio times that of the normal.
    const double across = d.efc_D[c.efc_address + 1] * d.efc_KBIP[4 * (c.efc_address + 1) + 1];
    law.creep = across > 0 ? 1 / across : 0;
    law.lift = 1;
  }
  return law;
}

}  // namespace

void sum_contacts(const mjModel& m, const mjData& d, const char* of_tool, int tool, EngineTool& sum) {
  sum.contact_T_W = {};
  sum.contacts = 0;
  const Vec3 origin = vec3_at(d.xipos + 3 * tool);
  for (int i = 0; i < d.ncon; ++i) {
    const mjContact& c = d.contact[i];
    const bool first = of_tool[m.geom_bodyid[c.geom1]] != 0, second = of_tool[m.geom_bodyid[c.geom2]] != 0;
    if (first == second || c.efc_address < 0) continue;
    double in_contact[6];
    mj_contactForce(&m, &d, i, in_contact);
    if (in_contact[0] == 0) continue;
    const auto in_W = [&](const double* v) {
      return v[0] * vec3_at(c.frame) + v[1] * vec3_at(c.frame + 3) + v[2] * vec3_at(c.frame + 6);
    };
    // On the second body; the normal leads from the first to it.
    const double sign = second ? 1 : -1;
    const Vec3 force = sign * in_W(in_contact);
    sum.contact_T_W.force += force;
    sum.contact_T_W.torque += cross(vec3_at(c.pos) - origin, force) + sign * in_W(in_contact + 3);
    ++sum.contacts;
  }
}

void list_contacts(const mjModel& m, const mjData& d, const char* of_tool, const int* listed, int count,
                   ContactSet& found) {
  found.count = found.penetrating = found.truncated = 0;
  found.bodies = {};
  found.bodies.count = count;
  for (int i = 0; i < count; ++i) found.bodies.X_WB[static_cast<std::size_t>(i)] = centre_pose(d, listed[i]);
  for (int i = 0; i < d.ncon; ++i) {
    const mjContact& c = d.contact[i];
    const int first = place_of(m, of_tool, listed, count, m.geom_bodyid[c.geom1]);
    const int second = place_of(m, of_tool, listed, count, m.geom_bodyid[c.geom2]);
    if (first == second || c.efc_address < 0) continue;
    if (found.count == ContactSet::capacity) {
      ++found.truncated;
      continue;
    }
    const auto k = static_cast<std::size_t>(found.count++);
    const int body = std::min(first, second), other = std::max(first, second);
    Contact& contact = found.contact[k] = law_of_rows(d, c);
    contact.n_W = (body == second ? 1.0 : -1.0) * vec3_at(c.frame);
    const Vec3 middle = vec3_at(c.pos), half = 0.5 * contact.distance * contact.n_W;
    contact.p_TC = transform(inverse(found.bodies.X_WB[static_cast<std::size_t>(body)]), middle + half);
    contact.p_WC = middle - half;
    found.pair[k] = {.body = body, .other = other < count ? other : ContactPair::fixed};
    if (contact.distance < 0) ++found.penetrating;
  }
}

}  // namespace tactor
