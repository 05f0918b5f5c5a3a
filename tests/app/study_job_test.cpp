// Jobs and answers as messages: what comes out is what went in, to the bit.
#include "app/study/run/job.hpp"

#include <boost/test/unit_test.hpp>
#include <cstring>
#include <limits>
#include <optional>

#include "framework/core/bytes.hpp"
#include "framework/core/check.hpp"

BOOST_AUTO_TEST_SUITE(study_job_test)

using namespace tactor;

namespace {

bool same_bits(double a, double b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_job_holds_files_values_and_maps_with_their_places) {
  Diagnostics diagnostics;
  const auto tree = parse_yaml("nodes: {coupling: {k_0: 200 N/m, list: [1, '2']}}", "study.yaml", diagnostics);
  BOOST_REQUIRE(tree.has_value());
  Job job;
  job.kind = JobKind::reference;
  job.graph = "graphs/duck.yaml";
  job.overrides = {set_patch("device.rate=2 kHz"), over_patch("burg.yaml"), Patch{{"study.yaml", 3, 7}, *tree}};
  job.reference = Overrides{option_patch("--seed", "seed", "7")};
  job.seed = std::numeric_limits<std::uint64_t>::max();
  job.libraries = {"coupling", "mine"};
  job.repeats = 3;
  job.warm_up = 1;
  job.time_limit_s = 0.1;
  job.cache_folder = "/cache";
  const auto got = from_message<Job>(to_message(job));
  BOOST_TEST((got.kind == JobKind::reference));
  BOOST_TEST(got.graph == job.graph);
  BOOST_REQUIRE(got.overrides.size() == 3U);
  BOOST_TEST(got.overrides[0].assignment()->path == "device.rate");
  BOOST_TEST(got.overrides[0].assignment()->value == "2 kHz");
  BOOST_TEST(*got.overrides[1].file() == *job.overrides[1].file());
  BOOST_TEST(got.overrides[2].place.text() == "study.yaml:3:7");
  const Tree& map = std::get<Tree>(got.overrides[2].change);
  const TreeEntry* coupling = map.value("nodes")->find("coupling");
  BOOST_TEST(coupling->value.value("k_0")->text == "200 N/m");
  BOOST_TEST(coupling->value.value("k_0")->place.text() ==
             tree->value("nodes")->value("coupling")->value("k_0")->place.text());
  BOOST_TEST(coupling->value.value("list")->items[1].quoted);
  BOOST_REQUIRE((got.reference && got.reference->size() == 1U));
  BOOST_TEST(got.reference->front().assignment()->value == "7");
  BOOST_TEST(got.seed == job.seed);
  BOOST_TEST((got.libraries == job.libraries));
  BOOST_TEST(got.repeats == 3);
  BOOST_TEST(got.warm_up == 1);
  BOOST_TEST(*got.time_limit_s == 0.1);
  BOOST_TEST(got.cache_folder == job.cache_folder);
}

BOOST_AUTO_TEST_CASE(metrics_of_a_run_keep_every_bit) {
  using Limits = std::numeric_limits<double>;
  const std::vector<double> values{
      0.1, -0.0, 1e-310, Limits::denorm_min(), Limits::max(), Limits::infinity(), -Limits::quiet_NaN()};
  RunAnswer answer;
  answer.cost = {0.25, 0.5};
  RunRecord& record = answer.record.emplace();
  record.status = RunStatus::failed;
  record.message = std::string("why\0not", 7);
  record.may_differ = true;
  record.cpu_s = values;
  for (const double value : values) record.result.metrics.emplace_back("metric", value);
  record.result.series.push_back({"curve", "N", values, values});
  record.result.declared["a"] = {.name = "a", .unit = "N", .doc = "one", .better = Better::lower};
  record.result.nodes.push_back({"node", "type", Role::collision, 5, 6, 0.1, 0.2, 0.3});
  record.result.chosen.push_back({"a", "b", "c", "d"});
  record.result.left_out.push_back({"what", "why"});
  record.result.reference.too_coarse = "too slow";
  record.result.devices = 2;
  record.result.no_force.push_back({"device", NoForceReason::line, 7, 8, "none"});
  const auto got = from_message<RunAnswer>(to_message(answer));
  BOOST_REQUIRE(got.record.has_value());
  const RunResult& result = got.record->result;
  BOOST_TEST((got.record->status == RunStatus::failed));
  BOOST_TEST(got.record->message == record.message);
  BOOST_TEST(got.record->may_differ);
  BOOST_TEST(std::isnan(got.record->control_us));
  BOOST_REQUIRE(result.metrics.size() == values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    BOOST_TEST(same_bits(result.metrics[i].second, values[i]));
    BOOST_TEST(same_bits(got.record->cpu_s[i], values[i]));
    BOOST_TEST(same_bits(result.series[0].time[i], values[i]));
    BOOST_TEST(same_bits(result.series[0].value[i], values[i]));
  }
  BOOST_TEST(result.declared.at("a").unit == "N");
  BOOST_TEST((result.declared.at("a").better == Better::lower));
  BOOST_TEST((result.nodes[0].role == Role::collision));
  BOOST_TEST(result.nodes[0].missed_ticks == 6U);
  BOOST_TEST(result.chosen[0].why == "d");
  BOOST_TEST(result.left_out[0].what == "what");
  BOOST_TEST(result.reference.too_coarse == "too slow");
  BOOST_TEST(result.devices == 2U);
  BOOST_TEST((result.no_force[0].reason == NoForceReason::line));
  BOOST_TEST(result.no_force[0].text == "none");
  BOOST_TEST(got.cost.waited_for_core_s == 0.5);
  BOOST_TEST(!from_message<RunAnswer>(to_message(RunAnswer{})).record.has_value());
}

BOOST_AUTO_TEST_CASE(a_message_that_is_cut_off_is_refused) {
  Job job;
  job.graph = "graphs/duck.yaml";
  const std::string whole = to_message(job);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    BOOST_CHECK_THROW(from_message<Job>(whole.substr(0, size)), RunError);
  }
}

BOOST_AUTO_TEST_CASE(a_byte_that_is_neither_true_nor_false_is_refused) {
  for (int byte = 0; byte < 256; ++byte) {
    const std::string bytes(1, static_cast<char>(byte));
    if (byte < 2) {
      BOOST_TEST(from_bytes<bool>(bytes) == (byte == 1));
    } else {
      BOOST_CHECK_THROW(from_bytes<bool>(bytes), RunError);
      BOOST_CHECK_THROW(from_bytes<std::optional<bool>>(bytes + '\1'), RunError);
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
