// What a client of the bridge may send, as text and as bytes.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "app/bridge/bridge_json.hpp"
#include "app/bridge/bridge_packed.hpp"
#include "require.hpp"

namespace {

using namespace tactor;

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
    }
  } catch (const BridgeRefusal& refusal) {
    fuzz::require(refusal.what()[0] != 0, "a refusal says why");
    const std::string told = to_text(BridgeError{refusal.what(), refusal.field()});
    fuzz::require(told.starts_with("{") && told.ends_with("}"), "a refusal can be told");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  look(read_client_message, input);
  look(read_client_bytes, input);
  return 0;
}
