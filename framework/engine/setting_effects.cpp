#include "framework/engine/setting_effects.hpp"

#include <algorithm>
#include <deque>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "framework/engine/plan_nodes.hpp"
#include "framework/engine/run_events.hpp"

namespace tactor {

namespace {

using Values = std::vector<ParamValue>;

/// A parameter of the node in question that is set.
struct Step {
  std::size_t param = 0;
  ParamValue value;
  std::string text;
};

/// Settings that are made together, one after the other.
struct Group {
  std::string path;         // of the setter's parameter that says so
  std::string text;         // of all of them
  std::vector<Step> steps;  // of those that concern the node
};

/// Groups that set the same parameters of the node, so that one takes the place of another.
using Turns = std::vector<Group>;

/// What the node's parameters are after these groups.
struct State {
  Values params;
  std::vector<const Group*> made;  // of each of the turns its newest; null before the first
};

/// The settings of a path in their order, cut where a parameter comes up again: `mute=0` and `mute=1` are two groups.
std::vector<std::vector<Setting>> groups_of(const NodeSpec& setter) {
  std::vector<std::vector<Setting>> groups;
  std::set<std::string> names;
  for (const Setting& setting : setter.info->sets(setter.params)) {
    if (groups.empty() || groups.back().front().path != setting.path || names.contains(setting.parameter)) {
      groups.emplace_back();
      names.clear();
    }
    names.insert(setting.parameter);
    groups.back().push_back(setting);
  }
  return groups;
}

/// What one setter does to one node.
class EffectCheck {
 public:
  EffectCheck(const Plan& plan, const NodeSpec& setter, const NodeSpec& node, Diagnostics& diagnostics)
      : plan_(plan), setter_(setter), node_(node), diagnostics_(diagnostics) {
    for (const std::vector<Setting>& settings : groups_of(setter)) add(settings);
  }

  void check() {
    if (turns_.empty()) return;
    // As the run comes to them first: from the values of the graph, in the order of the list.
    std::vector<State> states{{node_.params, std::vector<const Group*>(turns_.size())}};
    for (std::size_t turn = 0; turn < turns_.size(); ++turn) {
      std::vector<State> next;
      for (const State& state : states) {
        for (const Group& group : turns_[turn]) {
          if (auto made = make(state, turn, group)) next.push_back(std::move(*made));
        }
      }
      states = std::move(next);
    }
    // And from each to each.
    for (const State& state : states) {
      check_notes(state);
      for (std::size_t turn = 0; turn < turns_.size(); ++turn) {
        for (const Group& group : turns_[turn]) static_cast<void>(make(state, turn, group));
      }
    }
  }

 private:
  void add(const std::vector<Setting>& settings) {
    Group group{settings.front().path, {}, {}};
    std::set<std::size_t> params;
    for (const Setting& setting : settings) {
      group.text += (group.text.empty() ? "" : "; ") + setting.text();
      const std::size_t dot = setting.parameter.find('.');
      if (dot == std::string::npos || setting.parameter.substr(0, dot) != node_.name) continue;
      const auto param = node_.info->param(setting.parameter.substr(dot + 1));
      // A plan refuses a parameter that does not exist.
      if (!param) continue;
      group.steps.push_back({*param, parse_parameter(node_, *param, setting.value, setting.path), setting.text()});
      params.insert(*param);
    }
    if (group.steps.empty()) return;
    for (std::size_t i = 0; i < turns_.size(); ++i) {
      if (set_by_[i] == params) return turns_[i].push_back(std::move(group));
    }
    turns_.push_back({std::move(group)});
    set_by_.push_back(std::move(params));
  }

  /// Why the node refuses these values, and what it notes of them.
  struct Said {
    std::string refusal;
    NodeNotes told;
  };
  const Said& said_of(const Values& params) {
    const auto known = std::find_if(said_.begin(), said_.end(), [&](const auto& one) { return one.first == params; });
    if (known != said_.end()) return known->second;
    NodeSpec changed = node_;
    changed.params = params;
    Said& said = said_.emplace_back(params, Said{}).second;
    try {
      said.told = check_node(plan_.graph, changed);
    } catch (const InputError& error) {
      said.refusal = error.what();
    }
    return said;
  }

  void refuse(const std::string& where, const std::string& text, const std::string& why) {
    // One error a place.
    if (!refused_.insert(where).second) return;
    const std::string path = "nodes." + setter_.name + "." + where;
    diagnostics_.error(plan_.graph.place_of(path), path + ": " + text + ": " + why);
  }

  /// Sets the group's parameters one after the other, as the run does; none where the node refuses one.
  std::optional<State> make(const State& from, std::size_t turn, const Group& group) {
    State state = from;
    for (const Step& step : group.steps) {
      state.params[step.param] = step.value;
      const std::string& why = said_of(state.params).refusal;
      if (why.empty()) continue;
      for (const Step& other : group.steps) state.params[other.param] = other.value;
      const bool order = said_of(state.params).refusal.empty();
      refuse(group.path, group.text,
             why + (order ? "; so it is when " + step.text + " is set after " + after(from) +
                                ", because settings are applied one by one; give them in another order"
                          : ""));
      return std::nullopt;
    }
    state.made[turn] = &group;
    return state;
  }

  static std::string after(const State& state) {
    std::string text;
    for (const Group* group : state.made) {
      if (group != nullptr) text += (text.empty() ? "" : " and ") + group->path;
    }
    return text.empty() ? "the values of the graph" : text;
  }

  /// Refuses a state in which other values would feel alike.
  void check_notes(const State& state) {
    std::string text;
    for (const Group* group : state.made) text += (text.empty() ? "" : "; ") + group->text;
    for (const std::string& note : said_of(state.params).told.notes) {
      if (is_felt_alike(note, said_of(state.params).told.limits)) {
        refuse(state.made.front()->path, text, note + "; other settings would feel alike");
      }
    }
  }

  [[nodiscard]] bool is_set(const std::string& parameter) const {
    const auto index = node_.info->param(parameter);
    return index && std::any_of(set_by_.begin(), set_by_.end(),
                                [&](const std::set<std::size_t>& params) { return params.contains(*index); });
  }

  /// True where the note tells that a setting is not felt (see setting_effects.hpp).
  bool is_felt_alike(const std::string& note, const std::vector<LimitedParameter>& limits) {
    const auto limit =
        std::find_if(limits.begin(), limits.end(), [&](const LimitedParameter& one) { return one.note == note; });
    if (limit != limits.end()) {
      if (is_set(limit->parameter)) return true;
      if (is_set(limit->by)) return false;
    }
    const std::vector<std::string>& before = said_of(node_.params).told.notes;
    return std::find(before.begin(), before.end(), note) == before.end();
  }

  const Plan& plan_;
  const NodeSpec& setter_;
  const NodeSpec& node_;
  Diagnostics& diagnostics_;
  std::vector<Turns> turns_;
  std::vector<std::set<std::size_t>> set_by_;  // what each of turns_ sets
  std::deque<std::pair<Values, Said>> said_;
  std::set<std::string> refused_;
};

}  // namespace

void check_effects(const Plan& plan) {
  Diagnostics diagnostics;
  for (const NodeSpec& setter : plan.nodes) {
    if (!setter.info->sets) continue;
    for (const Setting& setting : setter.info->sets(setter.params)) {
      if (setting.text().size() <= SetEvent::most_text) continue;
      const std::string path = "nodes." + setter.name + "." + setting.path;
      diagnostics.error(plan.graph.place_of(path), path + ": the value of " + setting.parameter + " is too long");
    }
    for (const NodeSpec& node : plan.nodes) EffectCheck(plan, setter, node, diagnostics).check();
  }
  diagnostics.throw_if_any();
}

}  // namespace tactor
