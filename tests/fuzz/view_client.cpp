// What a page of the view may send, and the headers that let it in.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "app/view/server/client_text.hpp"
#include "app/web/request_rules.hpp"
#include "require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactor;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (const auto message = read_client_text(text)) {
    const Pose& X = message->X_WC;
    const double square = X.R.w * X.R.w + X.R.x * X.R.x + X.R.y * X.R.y + X.R.z * X.R.z;
    fuzz::require(is_finite(X.p) && norm(X.p) < 2e3, "a cursor is somewhere");
    fuzz::require(std::abs(square - 1) < 1e-12, "its orientation is a rotation");
    fuzz::require(message->parameter.size() <= 256 && message->value.size() <= 256, "texts are short");
  }
  if (is_own_host(text)) fuzz::require(text.size() <= 15, "a host of this machine is short");
  if (const auto token = offered_token(text, "tactor.view")) {
    fuzz::require(
        text.find(*token) != std::string_view::npos && !same_secret(*token, "0123456789abcdef0123456789abcdef"),
        "a token is what was offered");
  }
  static_cast<void>(is_same_origin(text, "localhost:8080"));
  return 0;
}
