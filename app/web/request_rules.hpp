// Who may connect: the rules for the headers of a request, and the token.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace tactor {

/// `localhost` and `127.0.0.1`, with a port or without one. Another name in Host means that a foreign name was made to
/// point here (DNS rebinding).
bool is_own_host(std::string_view host);
/// An IPv4 address, with a port or without one: no name, so that no foreign name was made to point here.
bool is_numeric_host(std::string_view host);
/// True where a page of that origin came from that host and port, by http.
bool is_same_origin(std::string_view origin, std::string_view host);
/// The first of `known` that is among the subprotocols that a client offers.
std::optional<std::string_view> offered_protocol(std::string_view subprotocols,
                                                 std::span<const std::string_view> known);
/// The token among the subprotocols that a client offers (`tactor.view, token.TOKEN`); nothing where `protocol` or the
/// token is not among them.
std::optional<std::string_view> offered_token(std::string_view subprotocols, std::string_view protocol);
/// Takes the same time wherever two texts of one length differ.
bool same_secret(std::string_view a, std::string_view b);
/// 128 bits from the system, as 32 hexadecimal digits. Throws RunError where it gives none.
std::string make_token();

}  // namespace tactor
