#include "devices/modbus/claim_names.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace tactor::modbus {

namespace {

using Bytes = std::array<std::uint8_t, 16>;

/// An address of version 6, or of version 4 as one of those.
Bytes bytes_of(const sockaddr& address) {
  Bytes bytes{};
  if (address.sa_family == AF_INET6) {
    std::memcpy(bytes.data(), &reinterpret_cast<const sockaddr_in6&>(address).sin6_addr, bytes.size());
  } else {
    bytes[10] = bytes[11] = 0xff;
    std::memcpy(bytes.data() + 12, &reinterpret_cast<const sockaddr_in&>(address).sin_addr, 4);
  }
  return bytes;
}

/// Those of the network's interfaces of this machine.
std::vector<Bytes> own_addresses() {
  std::vector<Bytes> own;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return own;
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    const sockaddr* address = entry->ifa_addr;
    if (address == nullptr || (address->sa_family != AF_INET && address->sa_family != AF_INET6)) continue;
    own.push_back(bytes_of(*address));
  }
  freeifaddrs(list);
  return own;
}

bool is_this_machine(const Bytes& bytes, const std::vector<Bytes>& own) {
  const Bytes any{}, loopback{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
  const Bytes any_of_4{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};
  const bool is_4 = std::equal(bytes.begin(), bytes.begin() + 12, any_of_4.begin());
  return bytes == any || bytes == loopback || bytes == any_of_4 || (is_4 && bytes[12] == 127) ||
         std::find(own.begin(), own.end(), bytes) != own.end();
}

std::vector<std::string> names_of_host(const Endpoint& endpoint) {
  std::vector<std::string> names;
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* list = nullptr;
  if (getaddrinfo(endpoint.host.c_str(), nullptr, &hints, &list) != 0) return names;
  const std::vector<Bytes> own = own_addresses();
  for (const addrinfo* entry = list; entry != nullptr; entry = entry->ai_next) {
    if (entry->ai_family != AF_INET && entry->ai_family != AF_INET6) continue;
    const Bytes bytes = bytes_of(*entry->ai_addr);
    std::array<char, INET6_ADDRSTRLEN> text{};
    inet_ntop(AF_INET6, bytes.data(), text.data(), text.size());
    const std::string host = is_this_machine(bytes, own) ? "this machine" : text.data();
    names.push_back("modbus tcp " + host + " port " + std::to_string(endpoint.port));
  }
  freeaddrinfo(list);
  // In an order of their own, so that two programs cannot each have half of them.
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

}  // namespace

std::vector<std::string> claim_names(const Endpoint& endpoint) {
  if (!endpoint.serial) return names_of_host(endpoint);
  struct stat status {};
  if (stat(endpoint.path.c_str(), &status) != 0 || !S_ISCHR(status.st_mode)) return {};
  return {"serial port " + std::to_string(major(status.st_rdev)) + ":" + std::to_string(minor(status.st_rdev))};
}

}  // namespace tactor::modbus
