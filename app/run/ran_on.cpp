#include "app/run/ran_on.hpp"

#include <gnu/libc-version.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>

#if defined(__x86_64__)
#include <cpuid.h>
#endif

#include "framework/core/text.hpp"

namespace tactor {

namespace {

std::string node_name() {
  // Several virtual nodes of Slurm may share a host.
  if (const char* slurm = std::getenv("SLURMD_NODENAME"); slurm != nullptr && *slurm != '\0') return slurm;
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? std::string(name.data()) : std::string("unknown");
}

#if defined(__x86_64__)
/// The brand that the processor itself tells; a kernel or an emulator in between may show another one elsewhere.
std::string brand() {
  std::array<unsigned, 12> words{};
  unsigned most = 0, ignored = 0;
  if (__get_cpuid(0x80000000U, &most, &ignored, &ignored, &ignored) == 0 || most < 0x80000004U) return "x86-64";
  for (unsigned i = 0; i < 3; ++i) {
    unsigned* four = words.data() + std::size_t{4} * i;
    __get_cpuid(0x80000002U + i, four, four + 1, four + 2, four + 3);
  }
  std::array<char, sizeof words + 1> text{};
  std::memcpy(text.data(), words.data(), sizeof words);
  return std::string(trimmed(text.data()));
}

/// The levels of the x86-64 psABI.
const char* level() {
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl")) {
    return "x86-64-v4";
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return "x86-64-v3";
  return __builtin_cpu_supports("sse4.2") ? "x86-64-v2" : "x86-64";
}

std::string processor_name() {
  return brand() + " (" + level() + ")";
}
#else
std::string processor_name() {
  return "not x86-64";
}
#endif

}  // namespace

const RanOn& this_machine() {
  static const RanOn machine{node_name(), processor_name(), std::string("glibc ") + gnu_get_libc_version()};
  return machine;
}

}  // namespace tactor
