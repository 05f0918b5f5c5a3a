#include "app/view/server/foxglove_text.hpp"

#include <map>
#include <nlohmann/json.hpp>

namespace tactor {

namespace {

using nlohmann::json;
using Kind = FoxgloveRequest::Kind;

const std::map<std::string, Kind, std::less<>> kinds{
    {"subscribe", Kind::subscribe},
    {"unsubscribe", Kind::unsubscribe},
    {"getParameters", Kind::get_parameters},
    {"setParameters", Kind::set_parameters},
    {"subscribeParameterUpdates", Kind::follow_parameters},
    {"unsubscribeParameterUpdates", Kind::unfollow_parameters},
};

std::optional<std::uint32_t> id_in(const json& value) {
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > UINT32_MAX) return std::nullopt;
  return value.get<std::uint32_t>();
}

/// The list of that name; nothing where it is none.
const json* list_in(const json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_array() ? &*found : nullptr;
}

bool read_subscriptions(const json& object, FoxgloveRequest& request) {
  const json* list = list_in(object, "subscriptions");
  if (list == nullptr) return false;
  for (const json& subscription : *list) {
    if (!subscription.is_object() || !subscription.contains("id") || !subscription.contains("channelId")) return false;
    const auto id = id_in(subscription["id"]), channel = id_in(subscription["channelId"]);
    if (!id || !channel) return false;
    request.subscriptions.emplace_back(*id, *channel);
  }
  return true;
}

bool read_ids(const json& object, FoxgloveRequest& request) {
  const json* list = list_in(object, "subscriptionIds");
  if (list == nullptr) return false;
  for (const json& value : *list) {
    const auto id = id_in(value);
    if (!id) return false;
    request.ids.push_back(*id);
  }
  return true;
}

bool read_names(const json& object, FoxgloveRequest& request) {
  const json* list = list_in(object, "parameterNames");
  if (list == nullptr) return false;
  for (const json& name : *list) {
    if (!name.is_string()) return false;
    request.names.push_back(name);
  }
  return true;
}

}  // namespace

std::optional<FoxgloveRequest> read_foxglove_text(std::string_view text) {
  const json object = json::parse(text, nullptr, false);
  if (!object.is_object()) return std::nullopt;
  const auto op = object.find("op");
  if (op == object.end() || !op->is_string()) return std::nullopt;
  FoxgloveRequest request;
  if (const auto kind = kinds.find(op->get_ref<const std::string&>()); kind != kinds.end()) request.kind = kind->second;
  if (const auto id = object.find("id"); id != object.end() && id->is_string()) request.id = *id;
  switch (request.kind) {
    case Kind::subscribe:
      if (!read_subscriptions(object, request)) return std::nullopt;
      break;
    case Kind::unsubscribe:
      if (!read_ids(object, request)) return std::nullopt;
      break;
    case Kind::get_parameters:
    case Kind::follow_parameters:
    case Kind::unfollow_parameters:
      if (!read_names(object, request)) return std::nullopt;
      break;
    case Kind::set_parameters:
    case Kind::other:
      break;
  }
  return request;
}

}  // namespace tactor
