#include "nodes/physics/mujoco/mujoco_engine.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/core/random.hpp"
#include "framework/core/value_error.hpp"
#include "nodes/physics/engine/model_files.hpp"
#include "nodes/physics/mujoco/contact_report.hpp"
#include "nodes/physics/mujoco/conversions.hpp"
#include "nodes/physics/mujoco/guarded_call.hpp"
#include "nodes/physics/mujoco/model_file.hpp"
#include "nodes/physics/mujoco/model_shapes.hpp"
#include "nodes/physics/mujoco/partial_scene.hpp"

namespace tactor {

namespace {

/// Of more bodies than these, MuJoCo's broad phase may sort more than 256 pairs, and that sort needs memory of the
/// heap.
constexpr int most_sorted_bodies = 23;

/// The least inertia of a row, kg or kg m^2, of a coupling that is neither stiff nor damped.
constexpr double least_inertia = 1e-12;

/// What MuJoCo's warnings mean to the owner of a model.
const char* meaning(int warning) {
  switch (warning) {
    case mjWARN_INERTIA:
      return "the inertia of a body is nearly singular";
    case mjWARN_CONTACTFULL:
      return "there are more contacts than the model has room for; raise nconmax in <size>";
    case mjWARN_CNSTRFULL:
      return "there are more constraints than the model has room for; raise njmax in <size>";
    case mjWARN_BADQPOS:
      return "a position has become unstable, and MuJoCo resets the scene";
    case mjWARN_BADQVEL:
      return "a velocity has become unstable, and MuJoCo resets the scene";
    case mjWARN_BADQACC:
      return "an acceleration has become unstable, and MuJoCo resets the scene";
    case mjWARN_BADCTRL:
      return "a control is not finite";
    default:
      return "unknown";
  }
}

class MujocoEngine final : public CoupledEngine {
 public:
  explicit MujocoEngine(const EngineModel& model)
      : shared_(read_coupled_model(model)),
        model_(mj_copyModel(nullptr, shared_.get())),
        data_(mj_makeData(model_.get())),
        listed_(body_numbers(*model_, model)),
        shown_(moving_numbers(*model_, listed_.front())),
        identity_(derive_seed(derive_seed(hash_of_files(model.file), model.tool), model.keyframe)) {
    TACTOR_DEMAND(data_ != nullptr);
    const mjModel& m = *model_;
    tool_ = listed_.front();
    is_free_ = m.body_jntnum[tool_] == 1;
    if (!model.keyframe.empty()) {
      keyframe_ = mj_name2id(&m, mjOBJ_KEY, model.keyframe.c_str());
      if (keyframe_ < 0) {
        throw ValueError("keyframe", model.file.string() + ": it has no keyframe '" + model.keyframe + "'");
      }
    }
    jacobian_.resize(6 * static_cast<std::size_t>(m.nv));
    of_tool_.resize(static_cast<std::size_t>(m.nbody));
    mark_tool();
    begin();
    if (model.partial) part_ = std::make_unique<PartialScene>(*shared_, tool_, *data_);
    if (!guarded(&MujocoEngine::forward)) {
      throw ValueError("model", model.file.string() + ": MuJoCo cannot begin with it: " + failure());
    }
    note_tool();
  }

  [[nodiscard]] std::uint64_t identity() const override { return identity_; }
  [[nodiscard]] Vec3 tool_principal_inertia() const override { return vec3_at(model_->body_inertia + 3 * tool_); }
  [[nodiscard]] std::vector<std::string> untold_bodies() const override {
    std::vector<std::string> names;
    for (int b = 1; b < model_->nbody; ++b) {
      const bool is_told = of_tool_[static_cast<std::size_t>(b)] != 0 ||
                           std::any_of(listed_.begin(), listed_.end(),
                                       [&](int told) { return model_->body_weldid[told] == model_->body_weldid[b]; });
      if (is_told || model_->body_weldid[b] != b) continue;
      const char* name = mj_id2name(model_.get(), mjOBJ_BODY, b);
      names.push_back(name != nullptr && *name != '\0' ? name : "number " + std::to_string(b));
    }
    return names;
  }
  [[nodiscard]] double tool_mass() const override { return model_->body_subtreemass[tool_]; }
  [[nodiscard]] Vec3 gravity_W() const override {
    return (model_->opt.disableflags & mjDSBL_GRAVITY) != 0 ? Vec3{} : vec3_at(model_->opt.gravity);
  }
  [[nodiscard]] bool tool_rotates() const override { return is_free_; }
  [[nodiscard]] bool may_allocate(Trees moving) const override { return bodies_with(moving) > most_sorted_bodies; }
  [[nodiscard]] std::string allocates(Trees moving) const override {
    if (!may_allocate(moving)) return {};
    const std::string why = part_ != nullptr ? part_->trees().why_whole() : "";
    return "MuJoCo allocates memory in the steps of a model with more than " + std::to_string(most_sorted_bodies) +
           " bodies, and this one has " + std::to_string(bodies_with(moving)) + (why.empty() ? "" : "; " + why);
  }
  [[nodiscard]] bool is_whole(Trees moving) const override {
    return part_ == nullptr || !part_->trees().any_stands(moving | 1);
  }
  [[nodiscard]] int moving_bodies() const override {
    int count = 0;
    for (int b = 1; b < model_->nbody; ++b) {
      if (model_->body_parentid[b] == 0 && model_->body_subtreemass[b] > 0 && moves(b)) ++count;
    }
    return count;
  }

  [[nodiscard]] Trees near_trees(const EngineNumbers& numbers, const TreeSearch& search) override {
    if (part_ == nullptr || !fits(numbers)) return all_trees;
    part_->place(numbers);
    return part_->trees().near(part_->placed(), search, most_sorted_bodies);
  }
  [[nodiscard]] double step_cost(Trees moving) const override {
    return part_ != nullptr ? part_->trees().step_cost(part_->placed(), moving | 1) : 0;
  }
  void let_move(Trees moving) override { moving_ = moving | 1; }

  [[nodiscard]] OwnScene own_scene() const override { return scene_of_model(*model_, *data_, shown_); }
  [[nodiscard]] std::size_t shown_bodies() const override { return shown_.size(); }
  void show(std::span<ShownPose> poses) const override {
    for (std::size_t i = 0; i < shown_.size(); ++i) poses[i] = shown_pose(centre_pose(*data_, shown_[i]));
  }
  bool touches_at(const Pose& X_WT) override {
    place_tool(X_WT);
    if (!guarded(&MujocoEngine::find_contacts)) return false;
    const auto is_tool = [this](int geom) {
      return of_tool_[static_cast<std::size_t>(model_->geom_bodyid[geom])] != 0;
    };
    return std::any_of(data_->contact, data_->contact + data_->ncon, [&](const mjContact& contact) {
      return contact.dist <= 0 && is_tool(contact.geom1) != is_tool(contact.geom2);
    });
  }

  void place_tool(const Pose& X_WT) override {
    const mjModel& m = *model_;
    double* q = data_->qpos + m.jnt_qposadr[m.body_jntadr[tool_]];
    double* v = data_->qvel + m.jnt_dofadr[m.body_jntadr[tool_]];
    if (is_free_) {
      const Vec3 p = X_WT.p - rotate(X_WT.R, vec3_at(m.body_ipos + 3 * tool_));
      const double pose[] = {p.x, p.y, p.z, X_WT.R.w, X_WT.R.x, X_WT.R.y, X_WT.R.z};
      std::copy(std::begin(pose), std::end(pose), q);
      std::fill_n(v, 6, 0.0);
    } else {
      const Vec3 move = X_WT.p - tool_state_.X_WT.p;
      const Vec3 a = axis(0), b = axis(1), c = axis(2);
      const double volume = dot(a, cross(b, c));
      q[0] += dot(move, cross(b, c)) / volume;
      q[1] += dot(move, cross(c, a)) / volume;
      q[2] += dot(move, cross(a, b)) / volume;
      std::fill_n(v, 3, 0.0);
    }
    std::fill_n(data_->qacc_warmstart, m.nv, 0.0);
    mj_kinematics(&m, data_.get());
    note_tool();
  }

  [[nodiscard]] EngineNumbers numbers() const override {
    if (part_ != nullptr) return part_->numbers();
    const mjModel& m = *model_;
    const auto span = [](const double* from, int count) { return std::span(from, static_cast<std::size_t>(count)); };
    return {span(data_->qpos, m.nq), span(data_->qvel, m.nv), span(data_->act, m.na),
            span(data_->qacc_warmstart, m.nv)};
  }

  bool restore(const EngineNumbers& numbers) override {
    if (!fits(numbers)) return false;
    if (failed_) begin();
    if (part_ != nullptr) {
      part_->place(numbers);
      part_->set(moving_, *model_, *data_);
      tool_ = part_->body(listed_.front());
      mark_tool();
    } else {
      std::copy(numbers.position.begin(), numbers.position.end(), data_->qpos);
      std::copy(numbers.velocity.begin(), numbers.velocity.end(), data_->qvel);
      std::copy(numbers.activation.begin(), numbers.activation.end(), data_->act);
      std::copy(numbers.acceleration.begin(), numbers.acceleration.end(), data_->qacc_warmstart);
    }
    mj_kinematics(model_.get(), data_.get());
    note_tool();
    return true;
  }

  bool step(const CouplingParameters& coupling, const DeviceState& to, double h, ContactSet* found) override {
    coupling_ = coupling;
    handle_ = to;
    found_ = found;
    model_->opt.timestep = h;
    failed_ = !guarded(&MujocoEngine::make_step) || has_warned() || !is_coupled_;
    if (failed_) return false;
    if (part_ != nullptr) part_->take(*data_);
    note_tool();
    if (!is_finite(tool_state_.X_WT.p) || !is_finite(tool_state_.V_WT.v) || !is_finite(tool_state_.V_WT.w)) {
      fail("the tool's motion is not finite");
      return false;
    }
    return true;
  }

  [[nodiscard]] const char* failure() const override { return text_.data(); }
  [[nodiscard]] const EngineTool& tool() const override { return tool_state_; }

  [[nodiscard]] BodyStates bodies() override {
    mj_comPos(model_.get(), data_.get());
    mj_comVel(model_.get(), data_.get());
    BodyStates states;
    for (const int body : listed_) {
      const auto i = static_cast<std::size_t>(states.count++);
      states.X_WB[i] = centre_pose(*data_, body);
      double turn_and_move[6];
      mj_objectVelocity(model_.get(), data_.get(), mjOBJ_BODY, body, turn_and_move, 0);
      states.V_WB[i] = {vec3_at(turn_and_move + 3), vec3_at(turn_and_move)};
    }
    states.V_WB[0] = tool_state_.V_WT;
    return states;
  }

 private:
  /// The tool, then the others that the engine tells of.
  static std::vector<int> body_numbers(const mjModel& m, const EngineModel& model) {
    std::vector<int> numbers{mj_name2id(&m, mjOBJ_BODY, model.tool.c_str())};
    for (const std::string& name : model.bodies) {
      const int body = mj_name2id(&m, mjOBJ_BODY, name.c_str());
      if (body < 0) {
        throw ValueError("scene.bodies." + name, model.file.string() + ": it has no body '" + name +
                                                     "', and the scene has one that moves; name it as the model does");
      }
      if (m.body_weldid[body] == 0) {
        throw ValueError("scene.bodies." + name + ".motion",
                         model.file.string() + ": body '" + name + "' has no joint there; expected motion: fixed");
      }
      numbers.push_back(body);
    }
    return numbers;
  }

  /// The bodies that move, the tool first; one that is welded to another moves with that.
  static std::vector<int> moving_numbers(const mjModel& m, int tool) {
    std::vector<int> numbers{tool};
    for (int b = 1; b < m.nbody; ++b) {
      if (m.body_weldid[b] == b && b != tool) numbers.push_back(b);
    }
    return numbers;
  }

  /// Marks the tool and all that hangs on it.
  void mark_tool() {
    // Parents come before their children.
    for (int b = 1; b < model_->nbody; ++b) {
      of_tool_[static_cast<std::size_t>(b)] =
          b == tool_ || of_tool_[static_cast<std::size_t>(model_->body_parentid[b])] != 0;
    }
  }

  /// Bodies of the model in which these trees move.
  [[nodiscard]] int bodies_with(Trees moving) const {
    return part_ != nullptr ? part_->trees().bodies(moving | 1) : shared_->nbody;
  }

  [[nodiscard]] bool fits(const EngineNumbers& numbers) const {
    const auto fit = [](std::span<const double> from, int count) {
      return from.size() == static_cast<std::size_t>(count) &&
             std::all_of(from.begin(), from.end(), [](double x) { return std::isfinite(x); });
    };
    return fit(numbers.position, shared_->nq) && fit(numbers.velocity, shared_->nv) &&
           fit(numbers.activation, shared_->na) && fit(numbers.acceleration, shared_->nv);
  }

  /// Whether something moves of a child of the world.
  [[nodiscard]] bool moves(int root) const {
    for (int b = root; b < model_->nbody; ++b) {
      if (model_->body_rootid[b] == root && model_->body_dofnum[b] > 0) return true;
    }
    return false;
  }

  /// Goes to where the model begins, with the controls that its actuators keep.
  void begin() {
    if (keyframe_ >= 0) {
      mj_resetDataKeyframe(model_.get(), data_.get(), keyframe_);
    } else {
      mj_resetData(model_.get(), data_.get());
    }
  }

  void fail(std::string_view why) {
    failed_ = true;
    std::snprintf(text_.data(), text_.size(), "%.*s", static_cast<int>(why.size()), why.data());
  }

  bool guarded(void (MujocoEngine::*work)()) {
    struct Call {
      MujocoEngine* engine;
      void (MujocoEngine::*work)();
    } call{this, work};
    return call_guarded(
        text_,
        [](void* argument) {
          const Call& c = *static_cast<const Call*>(argument);
          (c.engine->*c.work)();
        },
        &call);
  }

  bool has_warned() {
    for (int i = 0; i < mjNWARNING; ++i) {
      if (data_->warning[i].number == 0) continue;
      std::snprintf(text_.data(), text_.size(), "%s (number %d)", meaning(i), data_->warning[i].lastinfo);
      return true;
    }
    return false;
  }

  void forward() { mj_forward(model_.get(), data_.get()); }
  void find_contacts() { mj_fwdPosition(model_.get(), data_.get()); }

  /// In a guarded call: no object here has a destructor.
  void make_step() {
    mj_step1(model_.get(), data_.get());
    couple();
    if (!is_coupled_) return;
    if (mj_isDual(model_.get()) != 0) mj_projectConstraint(model_.get(), data_.get());
    mj_step2(model_.get(), data_.get());
    sum_contacts(*model_, *data_, of_tool_.data(), tool_, tool_state_);
    if (found_ != nullptr) {
      list_contacts(*model_, *data_, of_tool_.data(), listed_.data(), static_cast<int>(listed_.size()), *found_);
    }
    mj_kinematics(model_.get(), data_.get());
  }

  void couple() {
    const mjModel& m = *model_;
    const mjData& d = *data_;
    // Equalities come first, in their order.
    int row = 0;
    while (row < d.ne && d.efc_id[row] != m.neq - 1) ++row;
    is_coupled_ = row + 6 <= d.ne;
    if (!is_coupled_) return fail("the rows of the coupling are missing; raise njmax in <size>");
    double* const moves = jacobian_.data();
    double* const turns = moves + 3 * m.nv;
    mj_jacBodyCom(&m, &d, moves, turns, tool_);
    const Pose X = centre_pose(*data_, tool_);
    const Vec3 apart = handle_.X_WD.p - X.p;
    const Vec3 turn = is_free_ ? to_rotation_vector(handle_.X_WD.R * inverse(X.R)) : Vec3{};
    for (int i = 0; i < 3; ++i) {
      set_row(row + i, moves + i * m.nv, coupling_.k_t, coupling_.b_t, apart[i], handle_.V_WD.v[i]);
      if (is_free_) {
        set_row(row + 3 + i, turns + i * m.nv, coupling_.k_r, coupling_.b_r, turn[i], handle_.V_WD.w[i]);
      } else {
        set_row(row + 3 + i, turns + i * m.nv, 0, 0, 0, 0);
      }
    }
  }

  /// `gap`: m or rad from the tool to the handle; `speed`: the handle's.
  void set_row(int row, const double* jacobian, double k, double b, double gap, double speed) {
    const mjModel& m = *model_;
    mjData& d = *data_;
    const double h = m.opt.timestep;
    double own = 0;
    for (int i = 0; i < m.nv; ++i) own += jacobian[i] * d.qvel[i];
    const double inertia = std::max(h * b + h * h * k, least_inertia);
    d.efc_D[row] = inertia;
    d.efc_R[row] = 1 / inertia;
    d.efc_vel[row] = own;
    d.efc_aref[row] = (k * gap + b * speed - (b + h * k) * own) / inertia;
    if (mj_isSparse(&m) == 0) {
      std::copy_n(jacobian, m.nv, d.efc_J + row * m.nv);
      return;
    }
    double* const sparse = d.efc_J + d.efc_J_rowadr[row];
    const int* const columns = d.efc_J_colind + d.efc_J_rowadr[row];
    for (int i = 0; i < d.efc_J_rownnz[row]; ++i) {
      const int column = columns[i];
      sparse[i] = jacobian[column];
      // The transposed matrix holds the same.
      const int begin = d.efc_JT_rowadr[column], end = begin + d.efc_JT_rownnz[column];
      const int* const place = std::find(d.efc_JT_colind + begin, d.efc_JT_colind + end, row);
      if (place != d.efc_JT_colind + end) d.efc_JT[place - d.efc_JT_colind] = jacobian[column];
    }
  }

  /// Of a tool on slides, in W.
  [[nodiscard]] Vec3 axis(int i) const { return vec3_at(data_->xaxis + 3 * (model_->body_jntadr[tool_] + i)); }

  void note_tool() {
    const double* v = data_->qvel + model_->jnt_dofadr[model_->body_jntadr[tool_]];
    tool_state_.X_WT = centre_pose(*data_, tool_);
    if (is_free_) {
      const Vec3 w = rotate(tool_state_.X_WT.R, vec3_at(v + 3));
      const Vec3 to_centre = rotate(tool_state_.X_WT.R, vec3_at(model_->body_ipos + 3 * tool_));
      tool_state_.V_WT = {vec3_at(v) + cross(w, to_centre), w};
    } else {
      tool_state_.V_WT = {v[0] * axis(0) + v[1] * axis(1) + v[2] * axis(2), {}};
    }
  }

  std::shared_ptr<const mjModel> shared_;  // kept, so that the next engine need not read it anew
  ModelPointer model_;                     // its own, whose time step changes
  DataPointer data_;
  std::unique_ptr<PartialScene> part_;  // null: all trees move
  Trees moving_ = all_trees;            // from the next restore on
  std::vector<int> listed_;             // numbers of the bodies that it tells of, the tool first
  std::vector<int> shown_;              // numbers of all that move, the tool first
  std::uint64_t identity_;
  std::vector<char> of_tool_;
  int tool_ = 0;
  bool is_free_ = false;
  int keyframe_ = -1;
  std::vector<double> jacobian_;  // translation and rotation of the tool, 3 rows each
  CouplingParameters coupling_;   // of the step under way
  DeviceState handle_;
  ContactSet* found_ = nullptr;
  EngineTool tool_state_;
  bool is_coupled_ = false;
  bool failed_ = false;
  MujocoText text_{};
};

}  // namespace

std::unique_ptr<CoupledEngine> make_mujoco_engine(const EngineModel& model) {
  return std::make_unique<MujocoEngine>(model);
}

}  // namespace tactor
