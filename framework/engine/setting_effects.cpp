#include "framework/engine/setting_effects.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "framework/engine/plan_nodes.hpp"

namespace tactor {

namespace {

class EffectCheck {
 public:
  EffectCheck(const Plan& plan, const NodeSpec& setter) : plan_(plan), setter_(setter) {}

  void check(Diagnostics& diagnostics) {
    for (const Setting& setting : setter_.info->sets(setter_.params)) {
      const std::string name = setting.text.substr(0, setting.text.find('='));
      if (setting.path != path_ || names_.contains(name)) end_group(diagnostics);
      path_ = setting.path;
      names_.insert(name);
      texts_ += (texts_.empty() ? "" : "; ") + setting.text;
      make(name, setting.text.substr(std::min(name.size() + 1, setting.text.size())));
    }
    end_group(diagnostics);
  }

 private:
  /// Changes the node that has the parameter. What cannot be set is refused elsewhere.
  void make(const std::string& name, const std::string& value) {
    const std::size_t dot = std::min(name.find('.'), name.size());
    for (const NodeSpec& node : plan_.nodes) {
      if (node.name != std::string_view(name).substr(0, dot)) continue;
      const auto param = node.info->param(std::string_view(name).substr(std::min(dot + 1, name.size())));
      if (!param) return;
      NodeSpec& changed = changed_.try_emplace(node.name, node).first->second;
      changed.params[*param] = parse_parameter(changed, *param, value, name);
    }
  }

  /// What the node says of its parameters.
  [[nodiscard]] std::vector<std::string> notes_of(const NodeSpec& node) const {
    std::vector<std::string> notes;
    check_node(plan_.graph, node, &notes);
    return notes;
  }

  [[nodiscard]] std::string why_not(const NodeSpec& changed) const {
    try {
      const NodeSpec& node = *std::find_if(plan_.nodes.begin(), plan_.nodes.end(),
                                           [&](const NodeSpec& spec) { return spec.name == changed.name; });
      const std::vector<std::string> before = notes_of(node);
      for (const std::string& note : notes_of(changed)) {
        if (std::find(before.begin(), before.end(), note) == before.end()) {
          return note + "; other settings would feel alike";
        }
      }
    } catch (const InputError& error) {
      return error.what();
    }
    return {};
  }

  void end_group(Diagnostics& diagnostics) {
    const std::string path = "nodes." + setter_.name + "." + path_;
    for (const auto& [name, changed] : changed_) {
      const std::string why = why_not(changed);
      if (!why.empty()) diagnostics.error(plan_.graph.place_of(path), path + ": " + texts_ + ": " + why);
    }
    changed_.clear();
    names_.clear();
    texts_.clear();
  }

  const Plan& plan_;
  const NodeSpec& setter_;
  std::string path_, texts_;  // of the settings that are made together
  std::set<std::string> names_;
  std::map<std::string, NodeSpec> changed_;
};

}  // namespace

void check_effects(const Plan& plan) {
  Diagnostics diagnostics;
  for (const NodeSpec& node : plan.nodes) {
    if (node.info->sets) EffectCheck(plan, node).check(diagnostics);
  }
  diagnostics.throw_if_any();
}

}  // namespace tactor
