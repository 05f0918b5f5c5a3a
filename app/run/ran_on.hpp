// Where a run was made: what its run times, and in some cases its last digits, depend on.
#pragma once

#include <string>

namespace tactor {

/// A machine, as far as numbers can tell it from others.
struct RanOn {
  std::string node;       ///< name of the machine: of a Slurm node what Slurm calls it, else the host name
  std::string processor;  ///< `Intel(R) Xeon(R) CPU @ 2.20GHz (x86-64-v3)`: brand and level of instructions
  std::string c_library;  ///< `glibc 2.36`

  bool operator==(const RanOn&) const = default;
  /// Whether the same program gives the same numbers on both, also where its code asks for the processor.
  [[nodiscard]] bool computes_as(const RanOn& other) const {
    return processor == other.processor && c_library == other.c_library;
  }
};

/// This machine. Found once; cheap from then on.
const RanOn& this_machine();

}  // namespace tactor
