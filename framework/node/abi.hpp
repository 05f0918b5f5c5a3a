// The hash of headers that a library states in its file, read and compared before the library is loaded.
#pragma once

#include <filesystem>
#include <string>

#if !defined(__GLIBCXX__) || defined(_GLIBCXX_DEBUG) || !_GLIBCXX_USE_CXX11_ABI
#error \
    "Tactor's libraries hand strings and vectors to each other: build with libstdc++, its new ABI, and without _GLIBCXX_DEBUG"
#endif

/// Put once into a source of such a library: the hash of Tactor's headers that it is built with, as a text in its file.
/// The source includes tactor_abi.hpp before.
#define TACTOR_STATES_ABI                                                          \
  extern "C" {                                                                     \
  extern __attribute__((visibility("default"))) const char tactor_stated_abi[];    \
  __attribute__((used)) const char tactor_stated_abi[] = "tactor abi " TACTOR_ABI; \
  }                                                                                \
  static_assert(sizeof(tactor_stated_abi) == sizeof("tactor abi ") + 16)

namespace tactor {

/// The hash of this libtactor: 16 hexadecimal digits over the headers that libraries share, and the compiler (see
/// cmake/TactorAbi.cmake).
std::string framework_abi();

/// The hash that a library states; empty where it states none. Reads its file, and runs nothing of it.
std::string stated_abi(const std::filesystem::path& file);

/// Throws InputError, with both hashes and what to do, if the library states a hash other than this libtactor's, or
/// none.
void check_abi(const std::filesystem::path& file);

}  // namespace tactor
