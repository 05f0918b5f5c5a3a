#include "nodes/physics/mujoco/partial_scene.hpp"

#include <mujoco/mjxmacro.h>

#include <algorithm>
#include <cstring>
#include <span>
#include <string_view>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

/// Kinematics of all bodies needs no room for contacts.
mjModel without_contacts(const mjModel& whole) {
  mjModel small = whole;
  small.njmax = small.nconmax = 1;
  return small;
}

int at(const std::vector<int>& rows, int i) {
  return rows[static_cast<std::size_t>(i)];
}

int count_of(const std::vector<int>& rows) {
  return static_cast<int>(rows.size());
}

int coordinates_of(int joint_type) {
  return joint_type == mjJNT_FREE ? 7 : joint_type == mjJNT_BALL ? 4 : 1;
}

/// An object that an equality or a tendon names; -1 stays that.
int mapped(const std::vector<int>& numbers, int object) {
  return object < 0 ? object : at(numbers, object);
}

void gather(std::span<const double> from, const std::vector<int>& rows, double* to) {
  for (const int row : rows) *to++ = from[static_cast<std::size_t>(row)];
}

void scatter(const double* from, const std::vector<int>& rows, double* to) {
  for (const int row : rows) to[row] = *from++;
}

}  // namespace

PartialScene::PartialScene(const mjModel& whole, int tool, const mjData& begun)
    : whole_(&whole), trees_(whole, tool), control_(begun.ctrl, begun.ctrl + whole.nu) {
  const mjModel small = without_contacts(whole);
  placed_.reset(mj_makeData(&small));
  TACTOR_DEMAND(placed_ != nullptr);
  std::copy_n(begun.mocap_pos, 3 * whole.nmocap, placed_->mocap_pos);
  std::copy_n(begun.mocap_quat, 4 * whole.nmocap, placed_->mocap_quat);
  acceleration_.resize(static_cast<std::size_t>(whole.nv));
  const auto room = [](Rows& rows, Rows* numbers, int count) {
    rows.reserve(static_cast<std::size_t>(count));
    if (numbers != nullptr) numbers->assign(static_cast<std::size_t>(count), -1);
  };
  room(bodies_, &new_body_, whole.nbody);
  room(joints_, &new_joint_, whole.njnt);
  room(dofs_, &new_dof_, whole.nv);
  room(coordinates_, nullptr, whole.nq);
  room(geoms_, &new_geom_, whole.ngeom);
  room(sites_, &new_site_, whole.nsite);
  room(actuators_, nullptr, whole.nu);
  room(activations_, nullptr, whole.na);
  list_columns();
  const auto span = [](const double* from, int count) { return std::span(from, static_cast<std::size_t>(count)); };
  place({span(begun.qpos, whole.nq), span(begun.qvel, whole.nv), span(begun.act, whole.na), acceleration_});
}

/// All arrays whose rows are bodies, joints and so on, from MuJoCo's own list of them.
void PartialScene::list_columns() {
  const auto rows_of = [this](std::string_view size) -> const Rows* {
    return size == "nbody"   ? &bodies_
           : size == "njnt"  ? &joints_
           : size == "nv"    ? &dofs_
           : size == "nq"    ? &coordinates_
           : size == "ngeom" ? &geoms_
           : size == "nsite" ? &sites_
           : size == "nu"    ? &actuators_
                             : nullptr;
  };
  const mjModel* const m = whole_;
  const auto add = [&](const void* pointer, std::size_t bytes, std::string_view size) {
    const auto offset = static_cast<std::size_t>(static_cast<const char*>(pointer) - reinterpret_cast<const char*>(m));
    if (const Rows* rows = rows_of(size); rows != nullptr && bytes > 0) columns_.push_back({offset, bytes, rows});
  };
  MJMODEL_POINTERS_PREAMBLE(m)
#define X(type, name, nr, nc) add(&m->name, sizeof(type) * static_cast<std::size_t>(nc), #nr);
  MJMODEL_POINTERS
#undef X
}

EngineNumbers PartialScene::numbers() const {
  const auto span = [](const double* from, int count) { return std::span(from, static_cast<std::size_t>(count)); };
  return {span(placed_->qpos, whole_->nq), span(placed_->qvel, whole_->nv), span(placed_->act, whole_->na),
          acceleration_};
}

void PartialScene::place(const EngineNumbers& numbers) {
  std::copy(numbers.position.begin(), numbers.position.end(), placed_->qpos);
  std::copy(numbers.velocity.begin(), numbers.velocity.end(), placed_->qvel);
  std::copy(numbers.activation.begin(), numbers.activation.end(), placed_->act);
  std::copy(numbers.acceleration.begin(), numbers.acceleration.end(), acceleration_.begin());
  mj_kinematics(whole_, placed_.get());
  mj_comPos(whole_, placed_.get());
  mj_comVel(whole_, placed_.get());
}

void PartialScene::set(Trees moving, mjModel& model, mjData& data) {
  if (moving != moving_) {
    list_rows(moving);
    for (const Column& column : columns_) {
      char* to = *reinterpret_cast<char**>(reinterpret_cast<char*>(&model) + column.offset);
      const char* from = *reinterpret_cast<char* const*>(reinterpret_cast<const char*>(whole_) + column.offset);
      for (const int row : *column.rows) {
        std::memcpy(to, from + static_cast<std::size_t>(row) * column.bytes, column.bytes);
        to += column.bytes;
      }
    }
    number_bodies(model, trees_.any_stands(moving));
    number_joints(model);
    number_joins(model, moving);
    moving_ = moving;
  }
  place_still(model, moving);
  const EngineNumbers whole = numbers();
  gather(whole.position, coordinates_, data.qpos);
  gather(whole.velocity, dofs_, data.qvel);
  gather(whole.activation, activations_, data.act);
  gather(whole.acceleration, dofs_, data.qacc_warmstart);
  gather(control_, actuators_, data.ctrl);
  std::copy_n(placed_->mocap_pos, 3 * whole_->nmocap, data.mocap_pos);
  std::copy_n(placed_->mocap_quat, 4 * whole_->nmocap, data.mocap_quat);
}

void PartialScene::take(const mjData& data) {
  scatter(data.qpos, coordinates_, placed_->qpos);
  scatter(data.qvel, dofs_, placed_->qvel);
  scatter(data.act, activations_, placed_->act);
  scatter(data.qacc_warmstart, dofs_, acceleration_.data());
}

/// A body that stays one: itself, its joints and geoms. `as`: its new number.
void PartialScene::list_body(int body, int as) {
  const mjModel& m = *whole_;
  new_body_[static_cast<std::size_t>(body)] = as;
  for (int j = m.body_jntadr[body]; j < m.body_jntadr[body] + m.body_jntnum[body]; ++j) {
    new_joint_[static_cast<std::size_t>(j)] = count_of(joints_);
    joints_.push_back(j);
    for (int q = 0; q < coordinates_of(m.jnt_type[j]); ++q) coordinates_.push_back(m.jnt_qposadr[j] + q);
  }
  for (int d = m.body_dofadr[body]; d < m.body_dofadr[body] + m.body_dofnum[body]; ++d) {
    new_dof_[static_cast<std::size_t>(d)] = count_of(dofs_);
    dofs_.push_back(d);
  }
}

void PartialScene::list_rows(Trees moving) {
  const mjModel& m = *whole_;
  for (Rows* rows : {&bodies_, &joints_, &dofs_, &coordinates_, &geoms_, &sites_, &actuators_, &activations_}) {
    rows->clear();
  }
  for (Rows* numbers : {&new_joint_, &new_dof_, &new_site_}) std::fill(numbers->begin(), numbers->end(), -1);
  const bool has_carrier = trees_.any_stands(moving);
  const auto stands = [&](int body) { return has_carrier && trees_.stands(body, moving); };
  const auto list_geom = [&](int g) {
    new_geom_[static_cast<std::size_t>(g)] = count_of(geoms_);
    geoms_.push_back(g);
  };
  for (int b = 0; b < m.nbody; ++b) {
    if (stands(b)) {
      new_body_[static_cast<std::size_t>(b)] = MovingTrees::carrier;
      continue;
    }
    list_body(b, count_of(bodies_));
    bodies_.push_back(b);
    for (int g = 0; g < m.body_geomnum[b]; ++g) list_geom(m.body_geomadr[b] + g);
    if (b != 0 || !has_carrier) continue;
    // After the world comes the carrier, whose row is written anew.
    bodies_.push_back(0);
    for (int g = 0; g < m.ngeom; ++g) {
      if (stands(m.geom_bodyid[g])) list_geom(g);
    }
  }
  for (int s = 0; s < m.nsite; ++s) {
    if (stands(m.site_bodyid[s])) continue;
    new_site_[static_cast<std::size_t>(s)] = count_of(sites_);
    sites_.push_back(s);
  }
  for (int a = 0; a < m.nu; ++a) {
    const int type = m.actuator_trntype[a], joint = m.actuator_trnid[2 * a];
    if ((type == mjTRN_JOINT || type == mjTRN_JOINTINPARENT) && at(new_joint_, joint) < 0) continue;
    actuators_.push_back(a);
    // Actuators with a state come last.
    if (a >= m.nu - m.na) activations_.push_back(a - (m.nu - m.na));
  }
}

void PartialScene::number_bodies(mjModel& model, bool has_carrier) const {
  const mjModel& m = *whole_;
  int joints = 0, dofs = 0, geoms = 0;
  for (int i = 0; i < count_of(bodies_); ++i) {
    model.body_parentid[i] = at(new_body_, m.body_parentid[at(bodies_, i)]);
    model.body_rootid[i] = at(new_body_, m.body_rootid[at(bodies_, i)]);
    model.body_weldid[i] = at(new_body_, m.body_weldid[at(bodies_, i)]);
    if (has_carrier && i == MovingTrees::carrier) {
      model.body_parentid[i] = model.body_weldid[i] = 0;
      model.body_rootid[i] = i;
      model.body_mocapid[i] = -1;
      model.body_jntnum[i] = model.body_dofnum[i] = 0;
      model.body_geomnum[i] = static_cast<int>(
          std::count_if(geoms_.begin(), geoms_.end(), [&](int g) { return at(new_body_, m.geom_bodyid[g]) == i; }));
    }
    model.body_jntadr[i] = model.body_jntnum[i] > 0 ? joints : -1;
    model.body_dofadr[i] = model.body_dofnum[i] > 0 ? dofs : -1;
    model.body_geomadr[i] = model.body_geomnum[i] > 0 ? geoms : -1;
    joints += model.body_jntnum[i];
    dofs += model.body_dofnum[i];
    geoms += model.body_geomnum[i];
  }
  for (int i = 0; i < count_of(geoms_); ++i) model.geom_bodyid[i] = at(new_body_, m.geom_bodyid[at(geoms_, i)]);
  for (int i = 0; i < count_of(sites_); ++i) model.site_bodyid[i] = at(new_body_, m.site_bodyid[at(sites_, i)]);
  model.nbody = count_of(bodies_);
  model.nsite = count_of(sites_);
  model.ncam = model.nlight = model.nsensor = model.nsensordata = model.nkey = 0;
}

void PartialScene::number_joints(mjModel& model) const {
  const mjModel& m = *whole_;
  int coordinates = 0, dofs = 0;
  for (int i = 0; i < count_of(joints_); ++i) {
    model.jnt_qposadr[i] = coordinates;
    model.jnt_dofadr[i] = at(new_dof_, m.jnt_dofadr[at(joints_, i)]);
    model.jnt_bodyid[i] = at(new_body_, m.jnt_bodyid[at(joints_, i)]);
    coordinates += coordinates_of(m.jnt_type[at(joints_, i)]);
  }
  model.nM = 0;
  double inertia = 0;
  for (const int d : dofs_) {
    model.dof_bodyid[dofs] = at(new_body_, m.dof_bodyid[d]);
    model.dof_jntid[dofs] = at(new_joint_, m.dof_jntid[d]);
    model.dof_parentid[dofs] = mapped(new_dof_, m.dof_parentid[d]);
    model.dof_Madr[dofs] = model.nM;
    model.nM += (d + 1 < m.nv ? m.dof_Madr[d + 1] : m.nM) - m.dof_Madr[d];
    inertia += m.dof_M0[d];
    ++dofs;
  }
  int simple = 0;
  for (int i = dofs - 1; i >= 0; --i) {
    simple = model.body_simple[model.dof_bodyid[i]] != 0 ? simple + 1 : 0;
    model.dof_simplenum[i] = simple;
  }
  model.njnt = count_of(joints_);
  model.nq = coordinates;
  model.nv = dofs;
  model.nD = 2 * model.nM - dofs;
  // By these, MuJoCo scales the tolerance of its solver.
  if (dofs > 0) model.stat.meaninertia = inertia / dofs;
}

/// Equalities, excluded pairs, tendons and actuators.
void PartialScene::number_joins(mjModel& model, Trees moving) const {
  const mjModel& m = *whole_;
  const bool has_carrier = trees_.any_stands(moving);
  const auto stands = [&](int body) { return has_carrier && trees_.stands(body, moving); };
  for (int i = 0; i < m.neq; ++i) {
    const int first = m.eq_obj1id[i], second = m.eq_obj2id[i];
    const bool of_bodies = m.eq_type[i] == mjEQ_CONNECT || m.eq_type[i] == mjEQ_WELD;
    const bool of_joints = m.eq_type[i] == mjEQ_JOINT;
    const auto stands_there = [&](int object) {
      return object >= 0 && ((of_bodies && stands(object)) || (of_joints && stands(m.jnt_bodyid[object])));
    };
    const bool left_out = stands_there(first) || stands_there(second);
    model.eq_active[i] = left_out ? mjtByte{0} : m.eq_active[i];
    if (left_out) continue;
    const auto as_mapped = [&](int object) {
      return of_bodies ? mapped(new_body_, object) : of_joints ? mapped(new_joint_, object) : object;
    };
    model.eq_obj1id[i] = as_mapped(first);
    model.eq_obj2id[i] = as_mapped(second);
  }
  model.nexclude = 0;
  for (int i = 0; i < m.nexclude; ++i) {
    // MuJoCo counts the bodies of a pair from 1.
    const int first = (m.exclude_signature[i] >> 16) - 1, second = (m.exclude_signature[i] & 0xFFFF) - 1;
    if (stands(first) || stands(second)) continue;
    model.exclude_signature[model.nexclude++] = ((at(new_body_, first) + 1) << 16) + at(new_body_, second) + 1;
  }
  for (int i = 0; i < m.nwrap; ++i) {
    const int type = m.wrap_type[i], object = m.wrap_objid[i];
    const bool round = type == mjWRAP_SPHERE || type == mjWRAP_CYLINDER;
    if (type == mjWRAP_JOINT) model.wrap_objid[i] = mapped(new_joint_, object);
    if (type == mjWRAP_SITE) model.wrap_objid[i] = mapped(new_site_, object);
    if (!round) continue;
    model.wrap_objid[i] = mapped(new_geom_, object);
    // The site that tells on which side the tendon passes.
    if (m.wrap_prm[i] >= 0) model.wrap_prm[i] = mapped(new_site_, static_cast<int>(m.wrap_prm[i] + 0.5));
  }
  for (int i = 0; i < count_of(actuators_); ++i) {
    const int type = model.actuator_trntype[i];
    const Rows* const numbers = type == mjTRN_JOINT || type == mjTRN_JOINTINPARENT ? &new_joint_
                                : type == mjTRN_SITE || type == mjTRN_SLIDERCRANK  ? &new_site_
                                : type == mjTRN_BODY                               ? &new_body_
                                                                                   : nullptr;
    if (numbers == nullptr) continue;
    int* const objects = model.actuator_trnid + 2 * i;
    objects[0] = mapped(*numbers, objects[0]);
    if (numbers == &new_site_) objects[1] = mapped(*numbers, objects[1]);
  }
  model.nu = count_of(actuators_);
  model.na = count_of(activations_);
}

/// Puts the geoms of the carrier, and the carrier itself, where the state has them.
void PartialScene::place_still(mjModel& model, Trees moving) const {
  if (!trees_.any_stands(moving)) return;
  constexpr int carrier = MovingTrees::carrier;
  std::fill_n(model.body_pos + 3 * carrier, 3, 0.0);
  std::fill_n(model.body_ipos + 3 * carrier, 3, 0.0);
  std::fill_n(model.body_inertia + 3 * carrier, 3, 0.0);
  std::fill_n(model.body_invweight0 + 2 * carrier, 2, 0.0);
  model.body_mass[carrier] = model.body_subtreemass[carrier] = 0;
  model.body_simple[carrier] = 0;
  model.body_sameframe[carrier] = 1;
  constexpr double unturned[] = {1, 0, 0, 0};
  std::copy_n(unturned, 4, model.body_quat + 4 * carrier);
  std::copy_n(unturned, 4, model.body_iquat + 4 * carrier);
  const int first = model.body_geomadr[carrier];
  for (int i = first; i < first + model.body_geomnum[carrier]; ++i) {
    const int g = at(geoms_, i);
    std::copy_n(placed_->geom_xpos + 3 * g, 3, model.geom_pos + 3 * i);
    mju_mulQuat(model.geom_quat + 4 * i, placed_->xquat + 4 * whole_->geom_bodyid[g], whole_->geom_quat + 4 * g);
    model.geom_sameframe[i] = 0;
  }
}

}  // namespace tactor
