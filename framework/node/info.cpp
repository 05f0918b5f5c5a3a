#include "framework/node/info.hpp"

#include <algorithm>
#include <deque>
#include <mutex>

namespace tactor {

namespace {

template <class Item>
const Item* find_named(const std::vector<Item>& items, std::string_view name) {
  for (const Item& item : items) {
    if (item.name == name) return &item;
  }
  return nullptr;
}

/// The number that a value of a real or an integer parameter is; none for other kinds.
std::optional<double> number_of(const ParamValue& value) {
  if (const auto* real = std::get_if<double>(&value)) return *real;
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return static_cast<double>(*integer);
  return std::nullopt;
}

constexpr std::array<std::string_view, role_count> role_names{"other",       "source",   "device",     "collision",
                                                              "dynamics",    "coupling", "prediction", "interpolation",
                                                              "force_field", "sink"};

}  // namespace

std::vector<std::filesystem::path> files_of(const ParamInfo& info, const ParamValue& value) {
  const auto* file = std::get_if<std::string>(&value);
  if (info.kind != ParamKind::file || file == nullptr || file->empty()) return {};
  std::vector<std::filesystem::path> files{*file};
  if (!info.includes) return files;
  const std::vector<std::filesystem::path> more = info.includes(*file);
  files.insert(files.end(), more.begin(), more.end());
  return files;
}

std::string_view name_of(Better better) {
  constexpr std::array<std::string_view, 4> names{"lower", "higher", "near zero", "neither"};
  return names[static_cast<std::size_t>(better)];
}

std::string_view name_of(Role role) {
  return role_names[static_cast<std::size_t>(role)];
}

Role role_of(std::string_view name) {
  const auto* const found = std::find(role_names.begin(), role_names.end(), name);
  return found == role_names.end() ? Role::other : static_cast<Role>(found - role_names.begin());
}

std::optional<ParamValue> next_coarser(const ParamInfo& info, const ParamValue& value) {
  const std::vector<ParamValue>& ladder = info.coarser;
  if (ladder.empty()) return std::nullopt;
  if (const std::optional<double> x = number_of(value)) {
    const double first = number_of(ladder.front()).value(), last = number_of(ladder.back()).value();
    for (const ParamValue& step : ladder) {
      const double y = number_of(step).value();
      if (last > first ? y > *x : y < *x) return step;
    }
    return std::nullopt;
  }
  const auto at = std::find(ladder.begin(), ladder.end(), value);
  if (at == ladder.end()) return ladder.front();
  if (at + 1 == ladder.end()) return std::nullopt;
  return *(at + 1);
}

const NodeInfo& with_output_types(const NodeInfo& info, const std::vector<ParamValue>& values) {
  const auto open = [](const OutputInfo& output) { return output.type_of != nullptr; };
  if (std::none_of(info.outputs.begin(), info.outputs.end(), open)) return info;
  static std::mutex mutex;
  static std::deque<NodeInfo> kept;
  NodeInfo typed = info;
  for (OutputInfo& output : typed.outputs) {
    if (output.type_of) output.type = &output.type_of(values);
  }
  const auto same = [&](const NodeInfo& one) {
    if (one.type != info.type) return false;
    return std::equal(one.outputs.begin(), one.outputs.end(), typed.outputs.begin(), typed.outputs.end(),
                      [](const OutputInfo& a, const OutputInfo& b) { return a.type == b.type; });
  };
  const std::scoped_lock lock(mutex);
  const auto known = std::find_if(kept.begin(), kept.end(), same);
  return known != kept.end() ? *known : kept.emplace_back(std::move(typed));
}

const InputInfo* NodeInfo::input(std::string_view name) const {
  return find_named(inputs, name);
}
const OutputInfo* NodeInfo::output(std::string_view name) const {
  return find_named(outputs, name);
}
std::optional<std::size_t> NodeInfo::param(std::string_view name) const {
  const ParamInfo* found = find_named(params, name);
  if (found == nullptr) return std::nullopt;
  return static_cast<std::size_t>(found - params.data());
}

std::optional<std::size_t> NodeInfo::param(ParamMeaning meaning) const {
  for (std::size_t i = 0; i < params.size(); ++i) {
    if (params[i].meaning == meaning) return i;
  }
  return std::nullopt;
}

}  // namespace tactor
