#include "python/physics_loop.hpp"

#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/session/physics_loop.hpp"
#include "python/message_arrays.hpp"
#include "python/release_lock.hpp"
#include "python/session.hpp"

namespace tactor::python {

namespace py = pybind11;

namespace {

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

constexpr py::ssize_t row_size = 13;

struct BodyRow {
  Pose X;
  Twist V;
};

Numbers row_of(const Pose& X, const Twist& V) {
  const std::array<double, row_size> row{X.p.x, X.p.y, X.p.z, X.R.w, X.R.x, X.R.y, X.R.z,
                                         V.v.x, V.v.y, V.v.z, V.w.x, V.w.y, V.w.z};
  return Numbers(row_size, row.data());
}

void check_size(const Numbers& numbers, py::ssize_t size, const char* what) {
  if (numbers.size() != size) {
    throw InputError(fmt::format("{}: expected {} numbers, found {}", what, size, numbers.size()));
  }
}

BodyRow body_of(const double* row) {
  return {{{row[0], row[1], row[2]}, {row[3], row[4], row[5], row[6]}},
          {{row[7], row[8], row[9]}, {row[10], row[11], row[12]}}};
}

std::optional<Wrench> wrench_of(const std::optional<Numbers>& numbers, const char* what) {
  if (!numbers) return std::nullopt;
  check_size(*numbers, 6, what);
  const double* w = numbers->data();
  return Wrench{{w[0], w[1], w[2]}, {w[3], w[4], w[5]}};
}

/// An array of contact_dtype; of each contact its two bodies; and whether it tells p_TC.
using ContactArrays = std::tuple<py::array, py::array_t<std::int32_t>, py::array_t<bool>>;
/// Rows of bodies, and whether each tells its rotation.
using BodyArrays = std::pair<Numbers, py::array_t<bool>>;

/// The contacts and pairs, as many as there is room for; the count is that of all, so that too many are refused.
std::unique_ptr<ContactSet> contacts_of(const ContactArrays& arrays, PhysicsResult& result) {
  const auto& [contacts, pairs, has_p_TC] = arrays;
  if (contacts.itemsize() != static_cast<py::ssize_t>(sizeof(Contact)) || contacts.ndim() != 1 || pairs.ndim() != 2 ||
      pairs.shape(0) != contacts.shape(0) || pairs.shape(1) != 2 || has_p_TC.size() != contacts.shape(0)) {
    throw InputError("result: contacts: expected an array of contact_dtype, and two bodies for each");
  }
  auto set = std::make_unique<ContactSet>();
  set->count = static_cast<std::int32_t>(std::min<py::ssize_t>(contacts.shape(0), 1 << 30));
  for (py::ssize_t i = 0; i < std::min<py::ssize_t>(contacts.shape(0), ContactSet::capacity); ++i) {
    const auto k = static_cast<std::size_t>(i);
    std::memcpy(static_cast<void*>(&set->contact[k]), contacts.data(i), sizeof(Contact));
    set->pair[k] = {pairs.at(i, 0), pairs.at(i, 1)};
    result.without_p_TC[k] = !has_p_TC.at(i);
  }
  return set;
}

std::unique_ptr<BodyStates> bodies_of(const BodyArrays& arrays, PhysicsResult& result) {
  const auto& [rows, has_rotation] = arrays;
  if (rows.ndim() != 2 || rows.shape(1) != row_size || has_rotation.size() != rows.shape(0)) {
    throw InputError(fmt::format("result: bodies: expected rows of {} numbers", row_size));
  }
  auto bodies = std::make_unique<BodyStates>();
  bodies->count = static_cast<std::int32_t>(std::min<py::ssize_t>(rows.shape(0), 1 << 30));
  for (py::ssize_t i = 0; i < std::min<py::ssize_t>(rows.shape(0), BodyStates::capacity); ++i) {
    const BodyRow body = body_of(rows.data(i));
    bodies->X_WB[static_cast<std::size_t>(i)] = body.X;
    bodies->V_WB[static_cast<std::size_t>(i)] = body.V;
    if (!has_rotation.at(i)) result.without_rotation.set(static_cast<std::size_t>(i));
  }
  return bodies;
}

/// A loop of Python's. It may outlive its session, and then refuses everything.
class PythonPhysicsLoop {
 public:
  PythonPhysicsLoop(const std::shared_ptr<SessionState>& session, const std::string& node) : session_(session) {
    session->use([&](Session& running) { loop_ = std::make_unique<PhysicsLoop>(running, node); });
  }

  /// The name of the node that a loop would drive.
  static std::string node_of(const std::shared_ptr<SessionState>& session, const std::string& node) {
    return session->use([&](Session& running) {
      if (session->is_finished()) throw RunError("physics: the session has finished");
      return PhysicsLoop::node_of(running.plan(), node);
    });
  }
  [[nodiscard]] std::string node() const {
    return running("node")->use([this](Session&) { return loop_->node().name; });
  }
  [[nodiscard]] bool has_coupling() const { return loop_->has_coupling(); }

  std::optional<PhysicsStep> next() {
    const auto session = running("next");
    std::optional<PhysicsStep> step;
    if (session->is_finished()) return step;
    session->advance_while("next", [&](Session&) {
      step = loop_->next_within(session->slice());
      return !step && loop_->is_running();
    });
    return step;
  }

  void result(const PhysicsStep& step, const py::object& time, const std::optional<std::pair<Numbers, bool>>& tool,
              const std::optional<Numbers>& felt, const std::optional<Numbers>& contact,
              const std::optional<ContactArrays>& contacts, const std::optional<BodyArrays>& bodies) {
    const auto session = running("result");
    PhysicsResult result;
    if (!time.is_none()) result.time = Time{} + duration_of(time, "result: time");
    if (tool) {
      check_size(tool->first, row_size, "result: tool");
      const BodyRow body = body_of(tool->first.data());
      result.X_WT = body.X;
      result.V_WT = body.V;
      result.without_rotation[0] = !tool->second;
    }
    result.felt_D_W = wrench_of(felt, "result: felt");
    result.contact_T_W = wrench_of(contact, "result: contact");
    const auto set = contacts ? contacts_of(*contacts, result) : nullptr;
    const auto states = bodies ? bodies_of(*bodies, result) : nullptr;
    result.contacts = set.get();
    result.bodies = states.get();
    session->use([&](Session&) {
      session->demand_running("result");
      loop_->result(step, result);
    });
  }

 private:
  [[nodiscard]] std::shared_ptr<SessionState> running(const char* what) const {
    auto session = session_.lock();
    if (!session) throw RunError(std::string(what) + ": the session of this loop is gone");
    return session;
  }

  std::weak_ptr<SessionState> session_;
  std::unique_ptr<PhysicsLoop> loop_;
};

py::tuple handle_at(const PhysicsStep& step, const py::object& time) {
  const DeviceState handle = time.is_none() ? step.handle : step.handle_at(Time{} + duration_of(time, "handle: time"));
  return py::make_tuple(row_of(handle.X_WD, handle.V_WD), handle.buttons);
}

Numbers wrench_on_tool(const PhysicsStep& step, const Numbers& tool, double mass, double inertia, double h,
                       const py::object& time) {
  check_size(tool, row_size, "wrench: tool");
  const BodyRow body = body_of(tool.data());
  const DeviceState handle = time.is_none() ? step.handle : step.handle_at(Time{} + duration_of(time, "wrench: time"));
  const Wrench w =
      explicit_wrench(step.coupling, handle, {.X_WT = body.X, .V_WT = body.V, .mass = mass, .inertia = inertia}, h);
  const std::array<double, 6> numbers{w.force.x, w.force.y, w.force.z, w.torque.x, w.torque.y, w.torque.z};
  return Numbers(6, numbers.data());
}

}  // namespace

void bind_physics_loop(py::module_& module) {
  module.def("contact_dtype", [] { return MessageArrays(message_type<Contact>()).value_dtype(); });
  py::class_<PhysicsStep>(module, "PhysicsStep")
      .def_property_readonly("begin", [](const PhysicsStep& step) { return step.begin.seconds(); })
      .def_property_readonly("end", [](const PhysicsStep& step) { return step.end.seconds(); })
      .def_property_readonly("h", &PhysicsStep::h)
      .def("handle_at", handle_at, py::arg("time") = py::none())
      .def(
          "implicit_spring",
          [](const PhysicsStep& step, double h) {
            const ImplicitSpring spring = implicit_spring(step.coupling, h);
            return py::make_tuple(spring.k_t, spring.b_t, spring.k_r, spring.b_r);
          },
          py::arg("h") = 0.0)
      .def(
          "erp_cfm",
          [](const PhysicsStep& step, double h) {
            const ErpCfm soft = erp_cfm(step.coupling, h);
            return py::make_tuple(soft.erp_t, soft.cfm_t, soft.erp_r, soft.cfm_r);
          },
          py::arg("h"))
      .def("wrench", wrench_on_tool, py::arg("tool"), py::arg("mass"), py::arg("inertia"), py::arg("h"),
           py::arg("time") = py::none());
  py::class_<PythonPhysicsLoop>(module, "PhysicsLoop")
      .def(py::init<const std::shared_ptr<SessionState>&, const std::string&>(), py::arg("session"),
           py::arg("node") = "")
      .def_static("node_of", &PythonPhysicsLoop::node_of, py::arg("session"), py::arg("node") = "")
      .def_property_readonly("node", &PythonPhysicsLoop::node)
      .def_property_readonly("has_coupling", &PythonPhysicsLoop::has_coupling)
      .def("next", &PythonPhysicsLoop::next)
      .def("result", &PythonPhysicsLoop::result, py::arg("step"), py::arg("time") = py::none(),
           py::arg("tool") = py::none(), py::arg("felt") = py::none(), py::arg("contact") = py::none(),
           py::arg("contacts") = py::none(), py::arg("bodies") = py::none());
}

}  // namespace tactor::python
