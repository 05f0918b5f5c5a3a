#include "app/study/cluster/chunk_task.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <optional>
#include <set>
#include <thread>

#include "app/interruption.hpp"
#include "app/output.hpp"
#include "app/run/references.hpp"
#include "app/study/cluster/shard.hpp"
#include "app/study/run/job_fields.hpp"
#include "app/study/run/study_worker.hpp"
#include "app/study/run/worker_pool.hpp"
#include "framework/core/clock.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr double publish_patience_s = 600;

JobKind job_kind(StageKind stage) {
  return stage == StageKind::warm         ? JobKind::warm_up
         : stage == StageKind::references ? JobKind::reference
                                          : JobKind::run;
}

/// A folder on the node's own disk, or where that has no room beside the shards.
class Scratch {
 public:
  explicit Scratch(fs::path shards) : shards_(std::move(shards)) {
    try {
      folder_.emplace();
      is_own_ = has_room(folder_->path() / "room");
    } catch (const RunError&) {
    }
    if (!is_own_) leave_own_disk();
  }
  /// Whether it is on the node's own disk.
  [[nodiscard]] bool is_own() const { return is_own_; }
  /// Makes an empty folder beside the shards in place of that on the node's own disk.
  void leave_own_disk() {
    is_own_ = false;
    std::error_code none;
    const fs::path own = fs::temp_directory_path(none);
    tell_note(fmt::format("{}: no room for a shard of this task; it is written directly below {}",
                          none ? "TMPDIR" : own.string(), shards_.string()));
    folder_.emplace(shards_, "scratch-");
  }
  [[nodiscard]] fs::path file() const { return folder_->path() / "chunk.shard"; }

 private:
  static bool has_room(const fs::path& file) {
    std::ofstream probe(file);
    probe << std::string(1 << 20, '.');
    const bool has = static_cast<bool>(probe.flush());
    std::error_code ignored;
    fs::remove(file, ignored);
    return has;
  }

  fs::path shards_;
  std::optional<TemporaryFolder> folder_;
  bool is_own_ = false;
};

class ChunkTask {
 public:
  ChunkTask(const ClusterPlan& plan, const ClusterFolder& folder, const Stage& stage, std::size_t chunk)
      : plan_(plan),
        planned_(plan.planned),
        folder_(folder),
        stage_(stage),
        chunk_(chunk),
        target_(folder.shard(stage.kind, chunk)),
        registry_(default_node_folders()),
        worker_(registry_),
        pool_([this](const std::string& job, const PoolLink& pool) { return worker_.do_job(job, pool); },
              [] { return interruption.load(); }) {}

  int run() {
    if (is_whole()) return 0;
    scratch_.emplace(target_.parent_path());
    writer_.emplace(scratch_->file(), my_head());
    try {
      take_over();
      if (!make_units()) {
        keep_part("it was asked to end");
        return 1;
      }
      spend();
      write([](ShardWriter& writer) { writer.complete(); });
    } catch (const RunError& error) {
      keep_part(error.what());
      throw;
    }
    publish();
    return 0;
  }

 private:
  [[nodiscard]] ShardHead my_head() const {
    return {plan_.shard_key(stage_.kind), name_of(stage_.kind), chunk_, this_machine()};
  }

  /// Calls `what` with the writer. Where the node's own disk is full, the records that there are move beside the shards
  /// first.
  template <class What>
  void write(const What& what) {
    try {
      return what(*writer_);
    } catch (const RunError& error) {
      if (!scratch_->is_own()) throw;
      tell_note(error.what());
    }
    const Shard made = writer_->written();
    scratch_->leave_own_disk();
    writer_.emplace(scratch_->file(), my_head());
    for (const auto& [unit, answer] : made.records) writer_->add(unit, answer);
    writer_->spent(made.cost, made.depends_on_processor);
    what(*writer_);
  }

  void add(std::size_t unit, const std::string& answer) {
    write([&](ShardWriter& writer) { writer.add(unit, answer); });
  }

  [[nodiscard]] bool belongs(const ShardHead& head) const {
    return head.is_of(plan_.shard_key(stage_.kind), name_of(stage_.kind), chunk_);
  }

  [[nodiscard]] fs::path part() const { return folder_.part(stage_.kind, chunk_); }

  /// Whether another task has made the chunk. A file that is damaged gives way, and what is whole of it is taken over.
  [[nodiscard]] bool is_whole() const {
    const std::optional<Shard> there = read_shard(target_);
    if (!there) return false;
    if (there->complete && belongs(there->head)) return true;
    tell_note(fmt::format("{}: {}; the missing part is made again", target_.string(),
                          there->damage.empty() ? "it is of another study, or not whole" : there->damage));
    std::error_code ignored;
    if (belongs(there->head)) fs::rename(target_, part(), ignored);
    fs::remove(target_, ignored);
    return false;
  }

  /// Takes over what an earlier try has left.
  void take_over() {
    const std::optional<Shard> left = read_shard(part());
    if (!left || !belongs(left->head)) return;
    for (const auto& [unit, answer] : left->records) {
      if (unit < stage_.chunk_begin[chunk_] || unit >= stage_.chunk_begin[chunk_ + 1]) continue;
      if (done_.insert(unit).second) add(unit, answer);
    }
    earlier_ = left->cost;
    depends_.insert(left->depends_on_processor.begin(), left->depends_on_processor.end());
  }

  /// False where it was interrupted.
  bool make_units() {
    for (std::size_t unit = stage_.chunk_begin[chunk_]; unit < stage_.chunk_begin[chunk_ + 1];) {
      const std::size_t c = plan_.run_of(stage_, unit) / planned_.seeds();
      std::vector<std::size_t> units;
      for (; unit < stage_.chunk_begin[chunk_ + 1] && plan_.run_of(stage_, unit) / planned_.seeds() == c; ++unit) {
        if (done_.count(unit) == 0) units.push_back(unit);
      }
      if (!units.empty() && (!check_case(c) || !make_units_of_case(units))) return false;
    }
    return true;
  }

  /// Reads the graph of a case here. Throws InputError where it is not what it was when the study was submitted.
  bool check_case(std::size_t c) {
    JobBatch batch = batch_of(1);
    batch.job = [&](std::size_t) {
      Job job = planned_.job(JobKind::plan, c * planned_.seeds(), folder_.cache_of(plan_));
      job.seeds.clear();  // recordings that judge are compared run by run
      return to_message(job);
    };
    const std::string name = case_name(planned_.graph_of(c), planned_.cases[c].configuration);
    batch.done = [&](std::size_t, const std::string& answer) {
      const auto found = from_message<CaseCheck>(answer);
      for (const auto& [file, hash] : code_hashes({found.code_files.begin(), found.code_files.end()})) {
        const auto expected = plan_.code.find(file);
        if (expected == plan_.code.end() || expected->second == hash) continue;
        throw InputError(
            fmt::format("{}: the program has changed since the study was submitted; restore the old one, or start anew "
                        "with --overwrite",
                        file));
      }
      if (found.result == CheckResult::planned && found.content == planned_.checks[c].content) return true;
      throw InputError(fmt::format(
          "{}: the graph, or a file that it names, has changed since the study was submitted, or is not on this node{}",
          name, found.message.empty() ? "" : ": " + found.message));
    };
    // It crashes here alone: its runs tell.
    batch.lost = [&](std::size_t, const Ending& ending) {
      tell_note(fmt::format("the planning of {}: {}", name, ending.text));
    };
    return pool_.run(batch);
  }

  [[nodiscard]] JobBatch batch_of(std::size_t jobs) const {
    JobBatch batch;
    batch.jobs = jobs;
    batch.at_once = 1;
    batch.note = once([](const std::string& text) { tell_note(text); });
    return batch;
  }

  bool make_units_of_case(std::vector<std::size_t> units) {
    if (stage_.kind == StageKind::runs) {
      for (const std::size_t unit : units) check_recording(plan_.run_of(stage_, unit));
      std::erase_if(units, [this](std::size_t unit) { return is_hopeless(unit); });
    }
    JobBatch batch = batch_of(units.size());
    batch.time_limit_s = planned_.settings.run_timeout_s;
    batch.job = [&](std::size_t i) {
      return to_message(planned_.job(job_kind(stage_.kind), plan_.run_of(stage_, units[i]), folder_.cache_of(plan_)));
    };
    batch.done = [&](std::size_t i, const std::string& answer) {
      take(units[i], answer);
      return true;
    };
    batch.lost = [&](std::size_t i, const Ending& ending) { take_loss(units[i], ending); };
    return pool_.run(batch);
  }

  void check_recording(std::size_t run) const {
    if (plan_.recordings.empty() || plan_.recordings[run] == planned_.recording_hash(run)) return;
    throw InputError(fmt::format("{}: the recording used as the reference has changed since the study was submitted",
                                 planned_.name_of(run)));
  }

  /// Adds the run of a unit whose reference run could not be made.
  bool is_hopeless(std::size_t unit) {
    const std::size_t run = plan_.run_of(stage_, unit);
    const std::size_t c = run / planned_.seeds();
    if (!planned_.needs_reference(c)) return false;
    const std::size_t reference = planned_.reference_case[c] * planned_.seeds() + run % planned_.seeds();
    const std::optional<std::string> bytes = read_checked(folder_.lost_reference(reference));
    if (!bytes) return false;
    const auto [text, may_differ] = from_bytes<std::pair<std::string, bool>>(*bytes);
    add_record(unit, planned_.hopeless(run, lost_reference({text, may_differ})));
    return true;
  }

  void take(std::size_t unit, const std::string& answer) {
    if (stage_.kind == StageKind::runs) {
      auto made = from_message<RunAnswer>(answer);
      take_cost(made.cost);
      if (made.record) add_record(unit, std::move(*made.record));
      return;
    }
    const JobCost cost =
        stage_.kind == StageKind::warm ? from_message<WarmUp>(answer).cost : from_message<JobCost>(answer);
    take_cost(cost);
    if (!cost.interrupted) add(unit, answer);
  }

  void take_cost(const JobCost& cost) {
    run_cpu_s_ += cost.cpu_s;
    depends_.insert(cost.depends_on_processor.begin(), cost.depends_on_processor.end());
  }

  void take_loss(std::size_t unit, const Ending& ending) {
    const std::size_t run = plan_.run_of(stage_, unit);
    tell_note(fmt::format("{}: {}; the others go on", planned_.name_of(run), ending.text));
    if (stage_.kind == StageKind::runs) {
      add_record(unit, planned_.hopeless(run, {RunStatus::failed, ending.text, ending.may_differ}));
    } else if (stage_.kind == StageKind::warm) {
      add(unit, to_message(WarmUp{{}, ending.text, ending.may_differ, {}}));
    } else {
      publish_checked(to_bytes(std::pair(ending.text, ending.may_differ)), folder_.lost_reference(run));
      add(unit, to_message(JobCost{}));
    }
  }

  /// A shard declares each metric once.
  void add_record(std::size_t unit, RunRecord record) {
    std::erase_if(record.result.declared,
                  [this](const auto& metric) { return !declared_.insert(metric.first).second; });
    RunAnswer answer;
    answer.record = std::move(record);
    add(unit, to_message(answer));
  }

  void spend() {
    ShardCost cost = earlier_;
    cost.cpu_s += clock_seconds(CLOCK_PROCESS_CPUTIME_ID) + pool_.cpu_s();
    cost.wall_s += clock_seconds(CLOCK_MONOTONIC) - began_;
    cost.run_cpu_s += run_cpu_s_;
    write([&](ShardWriter& writer) { writer.spent(cost, {depends_.begin(), depends_.end()}); });
  }

  /// Keeps what there is for the next try, unless that of another task is more.
  void keep_part(const std::string& why) {
    try {
      spend();
    } catch (const RunError&) {
      // The disk that the records are on is full: they count without what they cost.
    }
    const std::optional<Shard> other = read_shard(part());
    std::size_t kept = writer_->written().records.size();
    const std::size_t there = other && belongs(other->head) ? other->records.size() : 0;
    if (kept > there) {
      try {
        publish_last(writer_->file(), part());
      } catch (const RunError& error) {
        tell_note(error.what());
        kept = there;
      }
    }
    tell_note(fmt::format("{} task {}: {}; {} of {} are kept", name_of(stage_.kind), chunk_, why, kept,
                          stage_.chunk_begin[chunk_ + 1] - stage_.chunk_begin[chunk_]));
  }

  /// The disk that all share may be full or away for a moment, and the runs of a chunk are not to be lost for that.
  void publish() {
    const double until = clock_seconds(CLOCK_MONOTONIC) + publish_patience_s;
    bool told = false;
    for (;;) {
      try {
        return publish_once();
      } catch (const RunError& error) {
        if (is_interrupted() || clock_seconds(CLOCK_MONOTONIC) > until) throw;
        if (!told) tell_note(fmt::format("{}; it is tried again for {} s", error.what(), publish_patience_s));
        told = true;
      }
      for (int i = 0; i < 20 && !is_interrupted(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }

  void publish_once() {
    if (!publish_first(writer_->file(), target_)) {
      // The same task ran twice at once. Both are kept, so that the merge can compare them.
      publish_last(writer_->file(), folder_.my_twin(stage_.kind, chunk_));
    }
    std::error_code ignored;
    fs::remove(part(), ignored);
  }

  const ClusterPlan& plan_;
  const PlannedCases& planned_;
  const ClusterFolder& folder_;
  const Stage& stage_;
  std::size_t chunk_;
  fs::path target_;
  Registry registry_;
  StudyWorker worker_;
  WorkerPool pool_;
  std::optional<Scratch> scratch_;
  std::optional<ShardWriter> writer_;
  std::set<std::size_t> done_;      // units of earlier tries
  std::set<std::string> declared_;  // metrics
  std::set<std::string> depends_;   // as processor_dependence()
  ShardCost earlier_;
  double run_cpu_s_ = 0;
  double began_ = clock_seconds(CLOCK_MONOTONIC);
};

}  // namespace

int run_chunk(const ClusterPlan& plan, const ClusterFolder& folder, StageKind stage, std::size_t chunk) {
  const Stage* found = plan.stage(stage);
  if (found == nullptr || chunk >= found->chunks()) {
    throw InputError(
        fmt::format("{}: expected a chunk of the stage {}, found {}", folder.path().string(), name_of(stage), chunk));
  }
  return ChunkTask(plan, folder, *found, chunk).run();
}

}  // namespace tactor
