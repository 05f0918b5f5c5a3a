#include "app/view/server/client_text.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace tactor {

namespace {

using nlohmann::json;

constexpr std::size_t longest_word = 256;
constexpr double farthest = 1e3;  // m

std::optional<std::string> word(const json& object, const char* key) {
  const auto at = object.find(key);
  if (at == object.end() || !at->is_string()) return std::nullopt;
  auto text = at->get<std::string>();
  if (text.empty() || text.size() > longest_word) return std::nullopt;
  return text;
}

template <std::size_t n>
std::optional<std::array<double, n>> numbers(const json& object, const char* key) {
  const auto at = object.find(key);
  if (at == object.end() || !at->is_array() || at->size() != n) return std::nullopt;
  std::array<double, n> values{};
  for (std::size_t i = 0; i < n; ++i) {
    if (!(*at)[i].is_number()) return std::nullopt;
    values[i] = (*at)[i].get<double>();
    if (!(std::abs(values[i]) <= farthest)) return std::nullopt;
  }
  return values;
}

std::optional<ClientMessage> read_input(const json& object) {
  const auto p = numbers<3>(object, "p");
  const auto q = numbers<4>(object, "q");
  const auto held = object.find("held");
  if (!p || !q || held == object.end() || !held->is_boolean()) return std::nullopt;
  const auto& [w, x, y, z] = *q;
  // A page computes in double too: what is farther from 1 is no rotation.
  if (std::abs(w * w + x * x + y * y + z * z - 1.0) > 1e-3) return std::nullopt;
  ClientMessage message;
  message.kind = ClientMessage::Kind::input;
  message.X_WC = {{(*p)[0], (*p)[1], (*p)[2]}, normalized({w, x, y, z})};
  message.held = held->get<bool>();
  return message;
}

}  // namespace

std::optional<ClientMessage> read_client_text(std::string_view text) {
  const json object = json::parse(text, nullptr, false);
  if (!object.is_object()) return std::nullopt;
  const auto type = word(object, "type");
  if (!type) return std::nullopt;
  ClientMessage message;
  if (*type == "input") return read_input(object);
  if (*type == "ack") {
    const auto frame = object.find("frame");
    if (frame == object.end() || !frame->is_number_unsigned()) return std::nullopt;
    message.frame = frame->get<std::uint64_t>();
    return message;
  }
  if (*type == "set") {
    const auto parameter = word(object, "parameter");
    const auto value = word(object, "value");
    if (!parameter || !value) return std::nullopt;
    message.kind = ClientMessage::Kind::set;
    message.parameter = *parameter;
    message.value = *value;
    return message;
  }
  if (*type == "stop" || *type == "control") {
    message.kind = *type == "stop" ? ClientMessage::Kind::stop : ClientMessage::Kind::control;
    return message;
  }
  return std::nullopt;
}

}  // namespace tactor
