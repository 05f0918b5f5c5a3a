// Cache entries of reference runs. What is believed takes no more memory than its bytes.
#include <cstddef>
#include <cstdint>
#include <string>

#include "framework/engine/reference.hpp"
#include "patched.hpp"
#include "require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactor;
  static const std::string good =
      to_bytes(Reference{{"metrics.force", {std::vector<Stamp>(3), std::vector<std::byte>(144)}},
                         {"metrics.state", {std::vector<Stamp>(1), std::vector<std::byte>(8)}}});
  const std::string bytes = fuzz::patched(good, data, size);
  const auto reference = reference_from_bytes(bytes);
  if (!reference) return 0;
  std::size_t held = 0;
  for (const auto& [name, stream] : *reference) {
    held += name.size() + stream.stamps.size() * sizeof(Stamp) + stream.payloads.size();
  }
  fuzz::require(held <= bytes.size(), "no more is held than was read");
  return 0;
}
