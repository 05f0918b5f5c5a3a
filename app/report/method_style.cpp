#include "app/report/method_style.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string_view>

#include "app/report/chart.hpp"

namespace tactor {

namespace {

struct MethodColor {
  std::string_view method;
  std::size_t color;  ///< as series_color takes it
};

// Methods that are often compared with each other have different ones.
constexpr std::array<MethodColor, 19> method_colors{{
    {"local", 0}, {"off", 1},    {"hold", 1},    {"direct", 1},  {"refit", 2},     {"blend", 3},     {"rls", 3},
    {"fixed", 4}, {"paper", 4},  {"burg", 4},    {"kalman", 5},  {"lowpass", 5},   {"forcegrid", 5}, {"rbf", 5},
    {"floor", 6}, {"linear", 6}, {"hermite", 6}, {"catmull", 6}, {"multirate", 6},
}};

/// The colour of the last part of the name that is a method's.
std::optional<std::size_t> known_color(std::string_view name) {
  std::optional<std::size_t> found;
  while (!name.empty()) {
    const std::size_t end = std::min(name.find_first_of("_ /"), name.size());
    const auto* one = std::find_if(method_colors.begin(), method_colors.end(),
                                   [&](const MethodColor& m) { return m.method == name.substr(0, end); });
    if (one != method_colors.end()) found = one->color;
    name.remove_prefix(std::min(end + 1, name.size()));
  }
  return found;
}

}  // namespace

std::string MethodStyle::html() const {
  static constexpr std::array<const char*, mark_shapes> marks{"●", "■", "▲", "◆", "▼", "⬟", "✚", "✱"};
  return fmt::format("<i class=\"mark\" style=\"--color:{}\">{}</i>", color, marks[mark % marks.size()]);
}

std::vector<MethodStyle> method_styles(const std::vector<std::string>& names) {
  std::array<std::size_t, series_colors> rows_of{};  // by colour
  std::vector<std::optional<std::size_t>> colors;
  for (const std::string& name : names) {
    colors.push_back(known_color(name));
    // Beyond its marks a colour says nothing.
    if (colors.back() && rows_of[*colors.back()] == mark_shapes) colors.back().reset();
    if (colors.back()) ++rows_of[*colors.back()];
  }
  for (std::optional<std::size_t>& color : colors) {
    if (color) continue;
    color = static_cast<std::size_t>(std::min_element(rows_of.begin(), rows_of.end()) - rows_of.begin());
    ++rows_of[*color];
  }
  std::vector<MethodStyle> styles;
  std::array<std::size_t, series_colors> seen{};
  for (const std::optional<std::size_t>& color : colors) styles.push_back({series_color(*color), seen[*color]++});
  return styles;
}

}  // namespace tactor
