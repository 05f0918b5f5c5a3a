// Seeds for independent random streams; the generators themselves are Boost.Random's, the same on every platform.
#pragma once

#include <cstdint>
#include <string_view>

namespace tactor {

/// A seed for the stream `name` of a run with `seed`: FNV-1a over the name, mixed with the seed by splitmix64.
constexpr std::uint64_t derive_seed(std::uint64_t seed, std::string_view name) {
  std::uint64_t h = 0xcbf29ce484222325ULL;
  for (const char c : name) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  std::uint64_t z = seed + h + 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace tactor
