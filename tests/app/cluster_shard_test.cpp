// Shards of a study on a cluster: what is whole counts, whatever became of the rest, and the merge does not see cuts.
#include "app/study/cluster/shard.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <numeric>
#include <random>

#include "app/study/cluster/cluster_plan.hpp"
#include "app/study/cluster/merge.hpp"
#include "app/study/cluster/submit.hpp"
#include "framework/core/bytes.hpp"
#include "framework/core/temporary_folder.hpp"

BOOST_AUTO_TEST_SUITE(cluster_shard_test)

using namespace tactor;
namespace fs = std::filesystem;

namespace {

constexpr std::size_t seeds = 5;
const RanOn here{"n1", "a processor", "glibc 2.36"}, there{"n2", "another processor", "glibc 2.36"};

std::string bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write_bytes(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

/// Cases without graphs, of which the merge reads nothing, cut into chunks of so many runs. The second one is refused.
ClusterPlan plan_of(std::size_t cases, std::size_t runs_of_chunk) {
  ClusterPlan plan;
  PlannedCases& planned = plan.planned;
  planned.judged.resize(1);
  planned.settings.identity = {"a study", "study", "options", "program"};
  for (std::size_t s = 0; s < seeds; ++s) planned.settings.seeds.push_back(100 + s);
  for (std::size_t c = 0; c < cases; ++c) {
    planned.cases.push_back({.graph = "duck.yaml", .configuration = "k=" + std::to_string(c)});
    planned.checks.push_back({.title = "a duck", .content = "content " + std::to_string(c)});
    planned.obstacles.emplace_back();
    planned.reference_case.push_back(c);
  }
  planned.obstacles[1] = Obstacle{RunStatus::refused, "it may not be"};
  plan.chunk_s = static_cast<double>(runs_of_chunk);
  plan.costs.runs.assign(cases, 1);
  plan.costs.references.assign(cases, 1);
  cut_into_stages(plan);
  return plan;
}

RunRecord record_of(std::size_t run) {
  RunRecord record;
  record.status = run % 7 == 3 ? RunStatus::failed : RunStatus::done;
  record.message = record.status == RunStatus::failed ? "it broke" : "";
  record.cpu_s = {0.5};
  record.ran_on = here;
  record.finished = "2026-01-01 00:00:00";
  record.result.title = "a duck";
  for (int m = 0; m < 4; ++m) {
    const std::string name = "m" + std::to_string(m);
    record.result.metrics.emplace_back(name, 1.0 / static_cast<double>(run + 1 + static_cast<std::size_t>(m)));
    record.result.declared.emplace(name, MetricInfo{name, "N", "of a run", Better::lower});
  }
  return record;
}

/// A shard of a chunk of runs, as its task would write it, with the records that `change` leaves.
fs::path write_shard(const ClusterPlan& plan, const ClusterFolder& folder, std::size_t chunk,
                     const std::function<bool(std::size_t run, RunRecord&)>& change = {},
                     const std::vector<std::string>& depends = {}, const std::string& ending = "") {
  const Stage& stage = *plan.stage(StageKind::runs);
  fs::create_directories(folder.shards(StageKind::runs));
  const fs::path file = folder.shard(StageKind::runs, chunk).string() + ending;
  fs::remove(file);
  ShardWriter writer(file, {plan.shard_key(StageKind::runs), "runs", chunk, here});
  bool is_whole = true;
  for (std::size_t unit = stage.chunk_begin[chunk]; unit < stage.chunk_begin[chunk + 1]; ++unit) {
    RunAnswer answer;
    answer.record = record_of(plan.run_of(stage, unit));
    if (change && !change(plan.run_of(stage, unit), *answer.record)) {
      is_whole = false;
      continue;
    }
    writer.add(unit, to_message(answer));
  }
  writer.spent({2, 3, 1}, depends);
  if (is_whole) writer.complete();
  return file;
}

struct Fixture {
  TemporaryFolder temporary;
  ClusterFolder folder{temporary.path()};
  fs::path table = temporary.path() / "study.sqlite";

  ClusterPlan plan(std::size_t cases, std::size_t runs_of_chunk) {
    fs::create_directories(folder.path());
    ClusterPlan made = plan_of(cases, runs_of_chunk);
    write_plan(made, folder);
    return made;
  }
};

}  // namespace

BOOST_FIXTURE_TEST_CASE(a_shard_holds_what_was_written_up_to_where_its_bytes_end, Fixture) {
  const fs::path file = temporary.path() / "a.shard";
  const std::vector<std::string> answers{"first", std::string("with\0zero", 9), std::string(10'000, 'x')};
  {
    ShardWriter writer(file, {"key", "runs", 7, here});
    for (std::size_t i = 0; i < answers.size(); ++i) writer.add(10 + i, answers[i]);
    writer.spent({2, 3, 1.5}, {"a BLAS"});
    writer.complete();
  }
  const std::optional<Shard> whole = read_shard(file);
  BOOST_REQUIRE(whole.has_value());
  BOOST_TEST(whole->complete);
  BOOST_TEST(whole->damage.empty());
  BOOST_TEST((whole->head == ShardHead{"key", "runs", 7, here}));
  BOOST_REQUIRE(whole->records.size() == 3U);
  for (std::size_t i = 0; i < answers.size(); ++i) BOOST_TEST((whole->records[i] == std::pair(10 + i, answers[i])));
  BOOST_TEST(whole->cost.run_cpu_s == 1.5);
  BOOST_TEST(whole->depends_on_processor == std::vector<std::string>{"a BLAS"}, boost::test_tools::per_element());
  // Cut anywhere, it has the records before the cut, and is not whole.
  const std::string bytes = bytes_of(file);
  const fs::path cut = temporary.path() / "cut.shard";
  std::size_t most = 0;
  for (std::size_t size = 0; size < bytes.size(); size += 1 + size % 13) {
    write_bytes(cut, bytes.substr(0, size));
    const std::optional<Shard> found = read_shard(cut);
    BOOST_REQUIRE(found.has_value());
    BOOST_TEST(!found->complete);
    BOOST_REQUIRE(found->records.size() <= 3U);
    BOOST_TEST(found->records.size() >= most);
    most = found->records.size();
    for (std::size_t i = 0; i < found->records.size(); ++i) BOOST_TEST(found->records[i].second == answers[i]);
  }
  BOOST_TEST(most == 3U);
  BOOST_TEST(!read_shard(temporary.path() / "none").has_value());
}

BOOST_FIXTURE_TEST_CASE(a_shard_with_a_changed_bit_is_told_and_not_believed, Fixture) {
  const fs::path file = temporary.path() / "a.shard";
  {
    ShardWriter writer(file, {"key", "runs", 7, here});
    writer.add(1, "first");
    writer.add(2, "second");
    writer.complete();
  }
  const std::string bytes = bytes_of(file);
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ 4);
    write_bytes(file, changed);
    const std::optional<Shard> found = read_shard(file);
    BOOST_REQUIRE(found.has_value());
    BOOST_TEST(!found->damage.empty());
    BOOST_TEST(!found->complete);
    for (const auto& [unit, answer] : found->records) BOOST_TEST(answer == (unit == 1 ? "first" : "second"));
  }
}

BOOST_FIXTURE_TEST_CASE(of_two_shards_of_one_chunk_the_first_wins, Fixture) {
  const fs::path a = temporary.path() / "a", b = temporary.path() / "b", to = temporary.path() / "to";
  write_bytes(a, "a");
  write_bytes(b, "b");
  BOOST_TEST(publish_first(a, to));
  BOOST_TEST(!publish_first(b, to));
  BOOST_TEST(bytes_of(to) == "a");
  publish_last(b, to);
  BOOST_TEST(bytes_of(to) == "b");
  // Nothing is left beside.
  BOOST_TEST(std::distance(fs::directory_iterator(temporary.path()), {}) == 3);
  BOOST_CHECK_THROW(publish_first(a, temporary.path() / "no/folder"), RunError);
}

BOOST_FIXTURE_TEST_CASE(merged_tables_are_the_same_bytes_for_every_cut, Fixture) {
  std::string first;
  for (const std::size_t runs_of_chunk : {1UL, 3UL, 7UL, 1000UL}) {
    const ClusterPlan cut = plan(12, runs_of_chunk);
    std::vector<std::size_t> order(cut.stage(StageKind::runs)->chunks());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::shuffle(order.begin(), order.end(), std::mt19937(runs_of_chunk));
    for (const std::size_t chunk : order) write_shard(cut, folder, chunk);
    const MergedShards merged = merge_shards(cut, folder, table);
    BOOST_TEST(merged.missing_runs == 0U);
    BOOST_TEST(merged.damaged.empty());
    BOOST_REQUIRE(merged.records.size() == 60U);
    for (std::size_t run = 0; run < 60; ++run) BOOST_TEST(merged.records[run].number == run);
    BOOST_TEST((merged.records[5].status == RunStatus::refused));
    BOOST_TEST(merged.records[5].message == "it may not be");
    BOOST_TEST((merged.records[10].status == RunStatus::failed));
    BOOST_TEST(merged.declared.size() == 4U);
    if (first.empty()) first = bytes_of(table);
    BOOST_TEST(bytes_of(table) == first);
    fs::remove_all(folder.path());
  }
  BOOST_TEST(first.size() > 10'000U);
}

BOOST_FIXTURE_TEST_CASE(what_is_missing_or_damaged_is_told_and_the_rest_is_there, Fixture) {
  const ClusterPlan cut = plan(6, 5);  // a chunk a case that runs: five
  for (std::size_t chunk = 0; chunk < 5; ++chunk) write_shard(cut, folder, chunk);
  fs::remove(folder.shard(StageKind::runs, 1));
  const fs::path damaged = folder.shard(StageKind::runs, 2);
  const std::string bytes = bytes_of(damaged);
  write_bytes(damaged, bytes.substr(0, bytes.size() * 9 / 10));
  // A task that was told to end.
  fs::remove(folder.shard(StageKind::runs, 3));
  write_shard(
      cut, folder, 3, [](std::size_t run, RunRecord&) { return run % seeds < 2; }, {}, ".part");
  // A shard of another study.
  ClusterPlan other = cut;
  other.key = "another";
  write_shard(other, folder, 4);
  const MergedShards merged = merge_shards(cut, folder, table);
  BOOST_TEST(merged.missing_chunks == (std::vector<std::size_t>{1, 2, 3, 4}), boost::test_tools::per_element());
  BOOST_REQUIRE(merged.damaged.size() == 2U);
  BOOST_TEST(merged.damaged.back().starts_with(folder.shard(StageKind::runs, 4).string()));
  BOOST_TEST(merged.damaged.front().starts_with(damaged.string() + ": it ends in the middle"));
  BOOST_TEST(merged.records.size() + merged.missing_runs == 30U);
  BOOST_TEST(merged.missing_runs >= 5U + 1U + 3U + 5U);
  BOOST_TEST(missing_chunks(cut, folder, *cut.stage(StageKind::runs)) == (std::vector<std::size_t>{1, 2, 3, 4}),
             boost::test_tools::per_element());
}

BOOST_FIXTURE_TEST_CASE(runs_made_twice_count_once_and_are_compared, Fixture) {
  const ClusterPlan cut = plan(3, 5);
  for (std::size_t chunk = 0; chunk < 2; ++chunk) write_shard(cut, folder, chunk);
  write_shard(cut, folder, 0, {}, {}, ".twin-n2-1");
  const MergedShards equal = merge_shards(cut, folder, table);
  BOOST_TEST(equal.records.size() == 15U);
  BOOST_TEST(equal.twice == 5U);
  BOOST_TEST(equal.unlike_twice.empty());
  BOOST_TEST(equal.core_s == 9);
  const std::string bytes = bytes_of(table);
  const auto last_bit = [](std::size_t run, RunRecord& record) {
    if (run == 2) record.result.metrics[1].second = std::nextafter(record.result.metrics[1].second, 2.0);
    return true;
  };
  write_shard(cut, folder, 0, last_bit, {}, ".twin-n2-2");
  const MergedShards unlike = merge_shards(cut, folder, table);
  BOOST_TEST(unlike.twice == 10U);
  BOOST_TEST(unlike.unlike_twice == std::vector<std::string>{"duck k=0, seed 102"}, boost::test_tools::per_element());
  BOOST_TEST(bytes_of(table) == bytes);
}

BOOST_FIXTURE_TEST_CASE(processors_are_mixed_where_nothing_depends_on_them_and_else_one_counts, Fixture) {
  const ClusterPlan cut = plan(4, 5);
  const auto on_other = [](std::size_t, RunRecord& record) {
    record.ran_on = there;
    return true;
  };
  write_shard(cut, folder, 0);
  write_shard(cut, folder, 1, on_other);
  write_shard(cut, folder, 2);
  const MergedShards mixed = merge_shards(cut, folder, table);
  BOOST_TEST(mixed.left_out == 0U);
  BOOST_TEST(mixed.missing_runs == 0U);
  // Shards tell what their records depend on.
  for (const std::size_t chunk : {0UL, 2UL}) write_shard(cut, folder, chunk, {}, {"a BLAS"});
  const Stage& stage = *cut.stage(StageKind::runs);
  fs::remove(folder.shard(StageKind::runs, 1));
  {
    ShardWriter writer(folder.shard(StageKind::runs, 1), {cut.shard_key(StageKind::runs), "runs", 1, there});
    for (std::size_t unit = stage.chunk_begin[1]; unit < stage.chunk_begin[2]; ++unit) {
      RunAnswer answer;
      answer.record = record_of(cut.run_of(stage, unit));
      answer.record->ran_on = there;
      writer.add(unit, to_message(answer));
    }
    writer.spent({2, 3, 1}, {"a BLAS"});
    writer.complete();
  }
  const MergedShards refused = merge_shards(cut, folder, table);
  BOOST_TEST(refused.left_out == 5U);
  BOOST_TEST(refused.missing_runs == 5U);
  BOOST_TEST(refused.depends_because == "a BLAS");
  BOOST_TEST(refused.missing_chunks == std::vector<std::size_t>{1}, boost::test_tools::per_element());
  // They are made anew.
  forget_what_does_not_count(cut, folder);
  BOOST_TEST(missing_chunks(cut, folder, *cut.stage(StageKind::runs)) == std::vector<std::size_t>{1},
             boost::test_tools::per_element());
}

BOOST_FIXTURE_TEST_CASE(runs_that_the_machine_ended_are_made_anew, Fixture) {
  const ClusterPlan cut = plan(3, 5);
  fs::create_directories(folder.lost_reference(0).parent_path());
  publish_checked(to_bytes(std::pair(std::string("killed"), true)), folder.lost_reference(3));
  publish_checked(to_bytes(std::pair(std::string("ended by SIGABRT"), false)), folder.lost_reference(4));
  write_shard(cut, folder, 0, [](std::size_t run, RunRecord& record) {
    record.may_differ = run == 4;
    return true;
  });
  write_shard(cut, folder, 1);
  forget_what_does_not_count(cut, folder);
  BOOST_TEST(!fs::exists(folder.lost_reference(3)));
  BOOST_TEST(fs::exists(folder.lost_reference(4)));
  BOOST_TEST(!fs::exists(folder.shard(StageKind::runs, 0)));
  BOOST_TEST(fs::exists(folder.shard(StageKind::runs, 1)));
  const MergedShards merged = merge_shards(cut, folder, table);
  BOOST_TEST(merged.records.size() == 14U);
  BOOST_TEST(merged.missing_runs == 1U);
}

BOOST_FIXTURE_TEST_CASE(shards_of_other_judged_intervals_do_not_count, Fixture) {
  ClusterPlan cut = plan(3, 5);
  for (std::size_t chunk = 0; chunk < 2; ++chunk) write_shard(cut, folder, chunk);
  BOOST_TEST(merge_shards(cut, folder, table).missing_runs == 0U);
  cut.planned.judged[0].from = Time{100'000'000};
  BOOST_TEST(merge_shards(cut, folder, table).missing_runs == 10U);
  BOOST_TEST(missing_chunks(cut, folder, *cut.stage(StageKind::runs)).size() == 2U);
}

BOOST_FIXTURE_TEST_CASE(a_checked_file_with_a_changed_bit_is_none, Fixture) {
  const fs::path file = temporary.path() / "a.bin";
  publish_checked("what it holds", file);
  BOOST_TEST(read_checked(file).value_or("") == "what it holds");
  const std::string bytes = bytes_of(file);
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ 1);
    write_bytes(file, changed);
    BOOST_TEST(!read_checked(file).has_value());
  }
  write_bytes(file, "");
  BOOST_TEST(!read_checked(file).has_value());
}

BOOST_FIXTURE_TEST_CASE(chunks_follow_the_expected_times, Fixture) {
  ClusterPlan cut = plan_of(3, 1);
  cut.planned.obstacles[1].reset();
  cut.costs.runs = {10, 1, 300};
  cut.chunk_s = 20;
  cut_into_stages(cut);
  const Stage* stage = cut.stage(StageKind::runs);
  BOOST_REQUIRE(stage != nullptr);
  // Two of the first case a chunk; the last of them with those of the second; what is longer than a chunk is one.
  BOOST_TEST(stage->chunk_begin == (std::vector<std::size_t>{0, 2, 4, 10, 11, 12, 13, 14, 15}),
             boost::test_tools::per_element());
  BOOST_TEST(cut.stage(StageKind::warm) == nullptr);
  BOOST_TEST(cut.stage(StageKind::references) == nullptr);
}

BOOST_FIXTURE_TEST_CASE(a_plan_is_read_as_it_was_written_or_refused, Fixture) {
  const ClusterPlan written = plan(4, 2);
  const ClusterPlan read = read_plan(folder);
  BOOST_TEST(read.key == written.key);
  BOOST_TEST(read.planned.runs() == written.planned.runs());
  BOOST_TEST(read.stage(StageKind::runs)->chunk_begin == written.stage(StageKind::runs)->chunk_begin,
             boost::test_tools::per_element());
  BOOST_TEST(read.planned.obstacles[1]->message == "it may not be");
  const std::string bytes = bytes_of(folder.plan());
  const auto refusal = [&] {
    try {
      static_cast<void>(read_plan(folder));
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ 16);
    write_bytes(folder.plan(), changed);
    BOOST_TEST(refusal().starts_with(folder.plan().string() + ": "));
  }
  write_bytes(folder.plan(), bytes.substr(0, 100));
  BOOST_TEST(refusal().find("damaged") != std::string::npos);
  fs::remove(folder.plan());
  BOOST_TEST(refusal().find("found no file") != std::string::npos);
}

BOOST_AUTO_TEST_SUITE_END()
