#include "framework/node/info.hpp"

namespace tactor {

namespace {

template <class Item>
const Item* find_named(const std::vector<Item>& items, std::string_view name) {
  for (const Item& item : items) {
    if (item.name == name) return &item;
  }
  return nullptr;
}

}  // namespace

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

}  // namespace tactor
