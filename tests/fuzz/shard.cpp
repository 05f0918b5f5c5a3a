// Shards of studies on a cluster, and the answers in them. What is believed takes no more memory than its bytes.
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>

#include "app/study/cluster/shard.hpp"
#include "app/study/run/job.hpp"
#include "framework/core/check.hpp"
#include "framework/core/temporary_folder.hpp"
#include "patched.hpp"
#include "require.hpp"

namespace {

using namespace tactor;

std::string good_answer() {
  RunAnswer answer;
  answer.record.emplace();
  answer.record->result.metrics = {{"a", 1}, {"b", 2}};
  answer.record->result.series = {{"one_step_error", "N", {0, 1}, {2, 3}}};
  return to_message(answer);
}

std::string good_shard() {
  const TemporaryFolder folder;
  {
    ShardWriter writer(folder.path() / "a.shard", {"key", "runs", 1, {"n", "p", "c"}});
    writer.add(1, good_answer());
    writer.spent({1, 2, 3}, {"a BLAS"});
    writer.complete();
  }
  std::ifstream stream(folder.path() / "a.shard", std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string shard = good_shard(), answer = good_answer();
  const std::string bytes = fuzz::patched(shard, data, size);
  const Shard found = shard_of(bytes);
  std::size_t held = 0;
  for (const auto& [unit, record] : found.records) held += record.size();
  fuzz::require(held <= bytes.size(), "no more is held than was read");
  fuzz::require(!found.complete || found.damage.empty(), "a damaged shard is not whole");
  try {
    const std::string message = fuzz::patched(answer, data, size);
    const auto read = from_message<RunAnswer>(message);
    fuzz::require(!read.record || read.record->result.metrics.size() <= message.size(),
                  "no more is held than was read");
  } catch (const RunError&) {
    // It is damaged.
  }
  return 0;
}
