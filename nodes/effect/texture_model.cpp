#include "nodes/effect/texture_model.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "framework/yaml/yaml_values.hpp"

namespace tactor {

namespace {

const YamlFileKind texture_file{"a texture model", "title, rate, models"};
constexpr double largest_number = 1e9;
constexpr double largest_deviation = 1e6;  // m/s^2

/// Where x lies among rising values: the lower neighbour and the share of the way to the next, at the ends theirs.
std::pair<std::size_t, double> place_in(const std::vector<double>& values, double x) {
  if (values.size() < 2 || x <= values.front()) return {0, 0};
  if (x >= values.back()) return {values.size() - 2, 1};
  const auto above = std::upper_bound(values.begin(), values.end(), x);
  const auto i = static_cast<std::size_t>(above - values.begin()) - 1;
  return {i, (x - values[i]) / (values[i + 1] - values[i])};
}

}  // namespace

/// One reading; errors go to the diagnostics.
class TextureReader {
 public:
  explicit TextureReader(Diagnostics& diagnostics) : d_(diagnostics) {}

  TextureModel read(const Tree& tree) {
    TextureModel model;
    check_keys(tree, "the model", "key", {"title", "rate", "models"}, d_);
    if (const Tree* t = need(tree, "the model", "title")) read_text(*t, "title", d_);
    if (const Tree* t = need(tree, "the model", "rate")) {
      const NumberRule rule{.unit = "Hz", .min = 0, .max = 1e5, .above_min = true};
      model.rate_ = read_number(*t, "rate", rule, d_).value_or(1);
    }
    const Tree* list = need(tree, "the model", "models");
    if (list == nullptr) return model;
    if (!list->is_sequence() || list->items.empty()) {
      d_.error(list->place,
               "models: expected a list of models, one for each speed with each force, found " + describe(*list));
      return model;
    }
    for (std::size_t i = 0; i < list->items.size(); ++i) one(list->items[i], "models[" + std::to_string(i) + "]");
    if (!d_.any()) arrange(*list, model);
    return model;
  }

 private:
  const Tree* need(const Tree& map, const std::string& path, const std::string& key) {
    const Tree* value = map.value(key);
    if (value == nullptr) d_.error(map.place, path + ": expected the key " + key + ", found none");
    return value;
  }
  std::optional<double> number(const Tree& map, const std::string& path, const std::string& key,
                               const std::string& unit) {
    const Tree* value = need(map, path, key);
    const NumberRule rule{.unit = unit, .min = 0, .max = largest_number, .above_min = true};
    return value == nullptr ? std::nullopt : read_number(*value, path + "." + key, rule, d_);
  }

  void one(const Tree& tree, const std::string& path) {
    if (!expect_map(tree, path, "a map of speed, force, variance, coefficients", d_)) return;
    check_keys(tree, path, "key", {"speed", "force", "variance", "coefficients"}, d_);
    const auto speed = number(tree, path, "speed", "m/s"), force = number(tree, path, "force", "N");
    const auto variance = number(tree, path, "variance", "1");
    const Tree* list = need(tree, path, "coefficients");
    if (list == nullptr) return;
    const NumberRule any{.min = -largest_number, .max = largest_number};
    const auto phi = read_numbers(*list, path + ".coefficients", 0, any, d_);
    if (!phi || !speed || !force || !variance) return;
    const std::optional<Reflection> reflection = Reflection::of(*phi);
    if (!reflection) {
      d_.error(list->place, path + ".coefficients: expected at most " + std::to_string(Reflection::most_order) +
                                " coefficients of a stable filter, all roots of z^p - phi_1 z^(p-1) - ... inside the "
                                "unit circle; these " +
                                std::to_string(phi->size()) + " are none");
      return;
    }
    const double deviation = std::sqrt(*variance * reflection->gain());
    if (!(deviation <= largest_deviation)) {
      d_.error(tree.place, path + ": expected a vibration of at most " + number_text(largest_deviation) +
                               " m/s^2, found one of " + number_text(deviation) + " m/s^2 (the root of its variance)");
      return;
    }
    const bool added = found_.try_emplace({*force, *speed}, TextureState{*reflection, deviation}).second;
    if (!added) d_.error(tree.place, path + ": expected each speed and force once, found them again");
  }

  void arrange(const Tree& list, TextureModel& model) {
    for (const auto& [key, state] : found_) {
      model.forces_.push_back(key.first);
      model.speeds_.push_back(key.second);
    }
    for (std::vector<double>* values : {&model.forces_, &model.speeds_}) {
      std::sort(values->begin(), values->end());
      values->erase(std::unique(values->begin(), values->end()), values->end());
    }
    for (const double force : model.forces_) {
      for (const double speed : model.speeds_) {
        const auto at = found_.find({force, speed});
        if (at == found_.end()) {
          d_.error(list.place, "models: expected one for each speed with each force, found none for " +
                                   number_text(speed) + " m/s with " + number_text(force) + " N");
          return;
        }
        model.nodes_.push_back(at->second);
      }
    }
  }

  Diagnostics& d_;
  std::map<std::pair<double, double>, TextureState> found_;  // by force and speed
};

namespace {

TextureModel checked_model(const std::optional<Tree>& tree, Diagnostics& diagnostics) {
  TextureModel model;
  if (tree && expect_map(*tree, "the model", "a map of title, rate, models", diagnostics)) {
    model = TextureReader(diagnostics).read(*tree);
  }
  diagnostics.throw_if_any();
  return model;
}

}  // namespace

TextureModel TextureModel::read(const std::filesystem::path& file) {
  Diagnostics diagnostics;
  return checked_model(read_yaml(file, file.string(), texture_file, diagnostics), diagnostics);
}

TextureModel TextureModel::parse(const std::string& text, const std::string& name) {
  Diagnostics diagnostics;
  return checked_model(parse_yaml(text, name, diagnostics), diagnostics);
}

TextureState TextureModel::at(double speed, double force) const {
  const auto [i, across] = place_in(forces_, force);
  const auto [j, along] = place_in(speeds_, speed);
  const std::size_t i_2 = std::min(i + 1, forces_.size() - 1), j_2 = std::min(j + 1, speeds_.size() - 1);
  const std::array<std::pair<const TextureState*, double>, 4> parts{{{&node(i, j), (1 - across) * (1 - along)},
                                                                     {&node(i, j_2), (1 - across) * along},
                                                                     {&node(i_2, j), across * (1 - along)},
                                                                     {&node(i_2, j_2), across * along}}};
  TextureState state;
  for (const auto& [part, weight] : parts) {
    for (std::size_t m = 0; m < Reflection::most_order; ++m) state.reflection.k[m] += weight * part->reflection.k[m];
    state.deviation += weight * part->deviation;
  }
  state.deviation *= std::clamp(speed / speeds_.front(), 0.0, 1.0) * std::clamp(force / forces_.front(), 0.0, 1.0);
  return state;
}

}  // namespace tactor
