// What a client of the bridge may send, as text and as bytes.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string_view>

#include "app/bridge/bridge_json.hpp"
#include "app/bridge/bridge_packed.hpp"
#include "app/bridge/bridge_result.hpp"
#include "require.hpp"

namespace {

using namespace tactor;

/// What the run would make of a result, in a scene of a tool that turns and a body that does not.
void give(const BridgeResult& message) {
  static const auto contacts = std::make_unique<ContactSet>();
  static BodyStates bodies;
  const std::array moving{Motion::rigid, Motion::translation};
  try {
    const PhysicsMessages made =
        physics_messages(physics_result(message, *contacts, bodies), message.time.value_or(Time{}), {}, moving);
    if (made.state) fuzz::require(is_finite(made.state->X_WT.p) && is_finite(made.state->V_WT.w), "a tool is finite");
    if (made.bodies) fuzz::require(made.bodies->count == 2, "all bodies are told");
    for (std::int32_t i = 0; made.contacts && i < made.contacts->count; ++i) {
      const Contact& contact = made.contacts->contact[static_cast<std::size_t>(i)];
      fuzz::require(std::abs(norm(contact.n_W) - 1) < 1e-9, "a normal is of unit length");
    }
  } catch (const ResultError& error) {
    fuzz::require(!error.field().empty() && !error.reason().empty(), "a refusal names its field");
  }
}

template <class Read>
void look(const Read& read, std::string_view input) {
  try {
    const auto message = read(input);
    if (const auto* result = std::get_if<BridgeResult>(&message)) {
      fuzz::require(!result->contacts || result->contacts->size() <= ContactSet::capacity, "contacts have a bound");
      fuzz::require(!result->bodies || result->bodies->size() <= BodyStates::capacity, "bodies have a bound");
      const std::string bytes = to_bytes(*result);
      fuzz::require(to_bytes(std::get<BridgeResult>(read_client_bytes(bytes))) == bytes,
                    "a result can be written and read");
      give(*result);
    }
  } catch (const BridgeRefusal& refusal) {
    fuzz::require(refusal.what()[0] != 0, "a refusal says why");
    const std::string told = to_text(BridgeError{refusal.what(), refusal.field()});
    const auto again = nlohmann::json::parse(told, nullptr, false);
    fuzz::require(
        again.is_object() && again["type"] == "error" && again["message"].is_string() && again["field"].is_string(),
        "a refusal can be told and read");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  look(read_client_message, input);
  look(read_client_bytes, input);
  return 0;
}
