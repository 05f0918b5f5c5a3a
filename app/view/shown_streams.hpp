// Which outputs of a plan a page shows, in which role, and how their messages become rows.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/run/experiment.hpp"
#include "app/view/drawn_scene.hpp"
#include "framework/core/message.hpp"
#include "framework/graph/plan.hpp"

namespace tactor {

struct ShownColumn {
  std::string name;
  std::string unit;
};

/// Rows of values with their times, or the newest set.
struct ShownRows {
  std::vector<double> times;  ///< s
  std::vector<float> values;  ///< rows of the stream's columns
};

/// A stream of the page. docs/reference/view_protocol.md tells the roles.
struct ShownStream {
  std::string role;
  std::string output;  ///< `device.commanded`
  std::vector<ShownColumn> columns;
  bool is_set = false;              ///< a message is a set of rows, of which the newest counts
  bool shares_arrays = false;       ///< its messages hold arrays of a pool, so that few of them may wait
  std::optional<std::size_t> body;  ///< of role body: index into the bodies that are drawn
  std::string method;               ///< the choice of the method that it belongs to, where there are several
  Duration least_gap;               ///< rows that follow one another faster are left out
  /// Adds a message as a row; a set replaces what is there.
  std::function<void(const Stamp& stamp, const void* value, ShownRows& rows)> add;
};

/// The streams of a plan, of what its nodes give. `drawn`: of its graph; where it is left out, the nodes are asked.
std::vector<ShownStream> shown_streams(const Plan& plan, const DrawnScene& drawn);
std::vector<ShownStream> shown_streams(const Plan& plan);
/// The streams that a page may show of an experiment (see experiment_of), without telling which condition is on: the
/// scene, how far the gate is open, what the experiment says, and, where the mouse is the device, the force, which
/// cannot be felt otherwise.
std::vector<ShownStream> blind_streams(const Plan& plan, const DrawnScene& drawn);
/// The true force, as the output `name` of a reference gives it.
ShownStream reference_stream(const std::string& name, bool torque);

/// A parameter that switches between inputs of its node, and what makes the force at each.
struct MethodSwitch {
  struct Choice {
    std::string value;  ///< of the parameter
    std::string label;
    std::vector<std::size_t> nodes;  ///< of the plan, that make it and no other choice
  };
  std::string parameter;  ///< `select.use`
  std::vector<Choice> choices;
};

/// The switch of a plan that holds methods side by side: a tunable choice whose values are inputs of its node.
std::optional<MethodSwitch> method_switch(const Plan& plan);

}  // namespace tactor
