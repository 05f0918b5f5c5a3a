#include "framework/graph/deformable_reader.hpp"

#include <algorithm>

#include "framework/graph/values.hpp"

namespace tactor {

namespace {

std::optional<Vec3> read_point(const Tree& map, const char* key, const std::string& path, const NumberRule& rule,
                               Diagnostics& diagnostics) {
  const Tree* tree = map.value(key);
  if (tree == nullptr) {
    diagnostics.error(map.place, path + ": expected the key " + key + ", found none");
    return std::nullopt;
  }
  const auto numbers = read_numbers(*tree, path + "." + key, 3, rule, diagnostics);
  if (!numbers) return std::nullopt;
  return Vec3{(*numbers)[0], (*numbers)[1], (*numbers)[2]};
}

std::optional<FixedRegion> read_box(const Tree& tree, const std::string& path, Diagnostics& diagnostics) {
  if (!expect_map(tree, path, "a map with low and high", diagnostics)) return std::nullopt;
  check_keys(tree, path, "key", {"low", "high"}, diagnostics);
  const auto low = read_point(tree, "low", path, {.unit = "m"}, diagnostics);
  const auto high = read_point(tree, "high", path, {.unit = "m"}, diagnostics);
  if (!low || !high) return std::nullopt;
  for (int i = 0; i < 3; ++i) {
    if ((*low)[i] <= (*high)[i]) continue;
    diagnostics.error(tree.place, path + ": expected low at or below high along every axis");
    return std::nullopt;
  }
  return BoxRegion{*low, *high};
}

std::optional<FixedRegion> read_half_space(const Tree& tree, const std::string& path, Diagnostics& diagnostics) {
  if (!expect_map(tree, path, "a map with p and n", diagnostics)) return std::nullopt;
  check_keys(tree, path, "key", {"p", "n"}, diagnostics);
  const auto p = read_point(tree, "p", path, {.unit = "m"}, diagnostics);
  const auto n = read_point(tree, "n", path, {.unit = "1"}, diagnostics);
  if (!p || !n) return std::nullopt;
  if (!(norm(*n) > 0)) {
    diagnostics.error(tree.place, path + ".n: expected a normal above zero length");
    return std::nullopt;
  }
  return HalfSpaceRegion{*p, *n};
}

std::optional<FixedRegion> read_region(const Tree& tree, const std::string& path, Diagnostics& diagnostics) {
  static const std::vector<std::string> kinds{"box", "behind", "faces"};
  if (!expect_map(tree, path, "a map with one of box, behind, faces", diagnostics)) return std::nullopt;
  check_keys(tree, path, "key", kinds, diagnostics);
  if (tree.entries.size() != 1) {
    diagnostics.error(tree.place, path + ": expected one of " + list_of(kinds) + ", found " +
                                      (tree.entries.empty() ? "none" : std::to_string(tree.entries.size()) + " keys"));
    return std::nullopt;
  }
  const TreeEntry& entry = tree.entries.front();
  const std::string at = path + "." + entry.key;
  if (entry.key == "box") return read_box(entry.value, at, diagnostics);
  if (entry.key == "behind") return read_half_space(entry.value, at, diagnostics);
  if (entry.key != "faces") return std::nullopt;
  const auto name = read_text(entry.value, at, diagnostics);
  return name ? std::optional<FixedRegion>(NamedFaces{*name}) : std::nullopt;
}

std::vector<FixedRegion> read_fixed(const Tree& tree, const std::string& path, Diagnostics& diagnostics) {
  std::vector<FixedRegion> regions;
  const auto add = [&](const Tree& one, const std::string& at) {
    if (const auto region = read_region(one, at, diagnostics)) regions.push_back(*region);
  };
  if (tree.items.empty()) {
    add(tree, path);
  } else {
    for (std::size_t i = 0; i < tree.items.size(); ++i) add(tree.items[i], path + "[" + std::to_string(i) + "]");
  }
  return regions;
}

std::vector<Inclusion> read_inclusions(const Tree& tree, const std::string& path, Diagnostics& diagnostics) {
  std::vector<Inclusion> inclusions;
  if (!expect_map(tree, path, "a map of inclusions", diagnostics)) return inclusions;
  for (const TreeEntry& entry : tree.entries) {
    const std::string at = path + "." + entry.key;
    // A file that extends another takes one out by ~.
    if (entry.value.is_null()) continue;
    if (!expect_map(entry.value, at, "a map with p, radius and young", diagnostics)) continue;
    check_keys(entry.value, at, "key", {"p", "radius", "young"}, diagnostics);
    Inclusion inclusion;
    const auto p = read_point(entry.value, "p", at, {.unit = "m"}, diagnostics);
    const auto number = [&](const char* key, const char* unit) {
      const Tree* value = entry.value.value(key);
      if (value == nullptr) diagnostics.error(entry.value.place, at + ": expected the key " + key + ", found none");
      const NumberRule rule{.unit = unit, .min = 0, .above_min = true};
      return value == nullptr ? std::nullopt : read_number(*value, at + "." + key, rule, diagnostics);
    };
    const auto radius = number("radius", "m");
    const auto young = number("young", "Pa");
    if (p && radius && young) inclusions.push_back({*p, *radius, *young});
  }
  return inclusions;
}

}  // namespace

const std::vector<std::string>& deformable_keys() {
  static const std::vector<std::string> keys{"young",      "poisson",   "density", "damping",   "drag",
                                             "tetrahedra", "cell_size", "fixed",   "inclusions"};
  return keys;
}

Deformable read_deformable(const Tree& body, const std::string& path, Diagnostics& diagnostics) {
  Deformable d;
  const auto number = [&](double& target, const char* key, const NumberRule& rule) {
    if (const Tree* tree = body.value(key)) {
      target = read_number(*tree, path + "." + key, rule, diagnostics).value_or(target);
    }
  };
  number(d.young, "young", {.unit = "Pa", .min = 0, .above_min = true});
  number(d.poisson, "poisson", {.unit = "1", .min = 0});
  if (d.poisson > 0.495) {
    diagnostics.error(body.value("poisson")->place,
                      path + ".poisson: expected at most 0.495, found " + number_text(d.poisson) +
                          "; at 0.5 a solid keeps its volume exactly, which these elements cannot compute");
  }
  number(d.density, "density", {.unit = "kg/m^3", .min = 0, .above_min = true});
  number(d.damping, "damping", {.unit = "s", .min = 0});
  number(d.drag, "drag", {.unit = "1/s", .min = 0});
  number(d.cell_size, "cell_size", {.unit = "m", .min = 0, .above_min = true});
  if (const Tree* tree = body.value("tetrahedra")) {
    d.tetrahedra =
        static_cast<int>(read_integer(*tree, path + ".tetrahedra", 6, 2'000'000, diagnostics).value_or(d.tetrahedra));
    if (const Tree* size = body.value("cell_size")) {
      diagnostics.error(size->place, path + ": expected either tetrahedra or cell_size, found both");
    }
  }
  if (const Tree* tree = body.value("fixed")) d.fixed = read_fixed(*tree, path + ".fixed", diagnostics);
  if (const Tree* tree = body.value("inclusions")) {
    d.inclusions = read_inclusions(*tree, path + ".inclusions", diagnostics);
  }
  return d;
}

}  // namespace tactor
