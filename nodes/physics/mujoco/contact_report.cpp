#include "nodes/physics/mujoco/contact_report.hpp"

#include <algorithm>

#include "nodes/physics/mujoco/conversions.hpp"

namespace tactor {

namespace {

/// Which of the listed bodies it is, or is welded to; `count` where it is none.
int place_of(const mjModel& m, const int* listed, int count, int body) {
  return static_cast<int>(
      std::find_if(listed, listed + count, [&](int b) { return m.body_weldid[b] == m.body_weldid[body]; }) - listed);
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

void list_contacts(const mjModel& m, const mjData& d, const int* listed, int count, ContactSet& found) {
  found.count = found.penetrating = found.truncated = 0;
  found.bodies = {};
  found.bodies.count = count;
  for (int i = 0; i < count; ++i) found.bodies.X_WB[static_cast<std::size_t>(i)] = centre_pose(d, listed[i]);
  for (int i = 0; i < d.ncon; ++i) {
    const mjContact& c = d.contact[i];
    const int first = place_of(m, listed, count, m.geom_bodyid[c.geom1]);
    const int second = place_of(m, listed, count, m.geom_bodyid[c.geom2]);
    if (first == second || c.efc_address < 0) continue;
    if (found.count == ContactSet::capacity) {
      ++found.truncated;
      continue;
    }
    const auto k = static_cast<std::size_t>(found.count++);
    const int body = std::min(first, second), other = std::max(first, second);
    const Vec3 n = (body == second ? 1.0 : -1.0) * vec3_at(c.frame);
    const Vec3 middle = vec3_at(c.pos);
    const double* row = d.efc_KBIP + 4 * c.efc_address;
    const double inertia = d.efc_D[c.efc_address];
    found.contact[k] = {
        .p_TC = transform(inverse(found.bodies.X_WB[static_cast<std::size_t>(body)]), middle + 0.5 * c.dist * n),
        .p_WC = middle - 0.5 * c.dist * n,
        .n_W = n,
        .distance = c.dist,
        .weight = 1,
        .stiffness = inertia * row[0] * row[2],
        .damping = inertia * row[1],
        .friction = c.friction[0]};
    found.pair[k] = {.body = body, .other = other < count ? other : ContactPair::fixed};
    if (c.dist < 0) ++found.penetrating;
  }
}

}  // namespace tactor
