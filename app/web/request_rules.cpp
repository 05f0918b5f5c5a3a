#include "app/web/request_rules.hpp"

#include <arpa/inet.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

/// The entries of a list between commas, without the blanks around them.
std::vector<std::string_view> offers_in(std::string_view list) {
  std::vector<std::string_view> offers;
  while (!list.empty()) {
    const std::size_t comma = std::min(list.find(','), list.size());
    std::string_view offer = list.substr(0, comma);
    list.remove_prefix(std::min(comma + 1, list.size()));
    while (!offer.empty() && offer.front() == ' ') offer.remove_prefix(1);
    while (!offer.empty() && offer.back() == ' ') offer.remove_suffix(1);
    offers.push_back(offer);
  }
  return offers;
}

/// The host without its port. Nothing if the port is no number.
std::optional<std::string_view> name_of_host(std::string_view host) {
  const std::size_t colon = host.find(':');
  if (colon == std::string_view::npos) return host;
  const std::string_view port = host.substr(colon + 1);
  const bool is_port = !port.empty() && port.size() <= 5 &&
                       std::all_of(port.begin(), port.end(), [](char c) { return c >= '0' && c <= '9'; });
  return is_port ? std::optional(host.substr(0, colon)) : std::nullopt;
}

}  // namespace

bool is_own_host(std::string_view host) {
  const std::optional<std::string_view> name = name_of_host(host);
  return name == "localhost" || name == "127.0.0.1";
}

bool is_numeric_host(std::string_view host) {
  const std::optional<std::string_view> name = name_of_host(host);
  in_addr address{};
  return name && inet_pton(AF_INET, std::string(*name).c_str(), &address) == 1;
}

bool is_same_origin(std::string_view origin, std::string_view host) {
  constexpr std::string_view scheme = "http://";
  return origin.substr(0, scheme.size()) == scheme && origin.substr(scheme.size()) == host;
}

std::optional<std::string_view> offered_protocol(std::string_view subprotocols,
                                                 std::span<const std::string_view> known) {
  const std::vector<std::string_view> offers = offers_in(subprotocols);
  for (const std::string_view protocol : known) {
    if (std::find(offers.begin(), offers.end(), protocol) != offers.end()) return protocol;
  }
  return std::nullopt;
}

std::optional<std::string_view> offered_token(std::string_view subprotocols, std::string_view protocol) {
  constexpr std::string_view prefix = "token.";
  std::optional<std::string_view> token;
  bool is_known = false;
  for (const std::string_view offer : offers_in(subprotocols)) {
    if (offer == protocol) is_known = true;
    if (offer.substr(0, prefix.size()) == prefix && !token) token = offer.substr(prefix.size());
  }
  return is_known ? token : std::nullopt;
}

bool same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned different = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    different |= static_cast<unsigned>(static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]));
  }
  return different == 0;
}

std::string make_token() {
  std::array<unsigned char, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw RunError("the system gives no random numbers for a token");
  }
  constexpr std::string_view digits = "0123456789abcdef";
  std::string token;
  for (const unsigned char byte : bytes) {
    token += digits[byte >> 4U];
    token += digits[byte & 15U];
  }
  return token;
}

}  // namespace tactor
