// The reference run: what the sinks of a run are compared with, made on demand and cached by content.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/disk_cache.hpp"
#include "framework/engine/plan_nodes.hpp"

namespace tactor {

/// What arrived at one reference input.
struct ReferenceStream {
  std::vector<Stamp> stamps;
  std::vector<std::byte> payloads;
  bool operator==(const ReferenceStream& other) const;
};

/// By `node.input`.
using Reference = std::map<std::string, ReferenceStream>;

/// A key over everything that the outcome of a reference plan depends on: node types, parameters, edges, scene, the
/// bytes of its files, seed, duration and the code (`libraries`: files whose bytes count). 32 hexadecimal digits.
std::string reference_key(const Plan& reference_plan, const std::vector<std::filesystem::path>& libraries);

/// Runs a reference plan. `tested`: the finished run for the nodes that must follow it, or null. `go_on` is asked with
/// the share done every 10 ms of virtual time; where it says no, RunError("interrupted") is thrown.
Reference run_reference(const Plan& reference_plan, const PlanNodes* tested,
                        const std::function<bool(double share)>& go_on = {});

/// True where one of the nodes asks the reference run to follow it, so that it can't be made beforehand or cached.
bool must_be_followed(const PlanNodes& nodes);

/// How often the truth is known.
struct ReferenceRate {
  double hz = 0;  ///< messages a second at the input of a sink; of several inputs the lowest
  /// Why it is no finer than the run that it should judge, with the node and its rate; empty where it is finer. A truth
  /// that is no finer than the run consists of the run's own results, with straight lines between them. It would call
  /// the method best that draws the same lines.
  std::string too_coarse;
};
/// Of a reference beside the run of `tested`, which took `run` and delivered so many messages on each of its edges. It
/// is finer where no node of it is held at the rate that it has in the run, and 1.5 times as many messages arrive.
/// `reference_plan`: the plan that made it; null for a recording.
ReferenceRate rate_of(const Reference& reference, const Plan* reference_plan, const Plan& tested, Duration run,
                      const std::function<std::uint64_t(std::size_t edge)>& delivered);

/// Hands the reference to the sinks of a finished run.
void set_reference(PlanNodes& tested, const Reference& reference);

/// A reference as bytes of this machine, and back; nothing where the bytes have another layout.
std::string to_bytes(const Reference& reference);
std::optional<Reference> reference_from_bytes(std::string_view bytes);

/// Reference runs in the disk cache, whose notes it passes on; a note, too, where bytes that are whole are no reference
/// run of the plan.
class ReferenceCache {
 public:
  static constexpr std::uint32_t layout = 2;  ///< version of the bytes; the code that makes a reference is in its key

  explicit ReferenceCache(std::filesystem::path folder);

  struct Found {
    std::optional<Reference> reference;
    std::string note;
  };
  [[nodiscard]] Found load(const std::string& key, const Plan& reference_plan) const;
  [[nodiscard]] std::string store(const std::string& key, const Reference& reference) const;

 private:
  DiskCache cache_;
};

}  // namespace tactor
