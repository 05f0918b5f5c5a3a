// Reference runs: what sinks see of them, and a cache that never hands out what does not check out.
#include "framework/engine/reference.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <vector>

#include "framework/engine/virtual_engine.hpp"
#include "tests/framework/engine/sample_nodes.hpp"

BOOST_AUTO_TEST_SUITE(reference_test)

using namespace tactor;
using namespace tactor::sample;
namespace fs = std::filesystem;

namespace {

struct TemporaryFolder {
  fs::path path = fs::temp_directory_path() / ("tactor-reference-" + std::to_string(getpid()));
  TemporaryFolder() { fs::create_directories(path); }
  ~TemporaryFolder() { fs::remove_all(path); }
};

CostModel five_milliseconds() {
  CostModel cost;
  cost.kind = CostModel::Kind::constant;
  cost.base = {5'000'000};
  return cost;
}

/// What make_reference_plan makes of the sample: no costs, the counter at 10 kHz.
Plan reference_of(const SamplePlan& sample) {
  Plan plan = sample.plan;
  for (NodeSpec& node : plan.nodes) node.cost = {};
  plan.nodes[0].params[0] = 10000.0;
  return plan;
}

std::string bytes(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The files that a file of this kind names, one a line, beside it.
std::vector<fs::path> named_in(const fs::path& file) {
  std::vector<fs::path> names;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) names.push_back(file.parent_path() / line);
  return names;
}

/// Reads a file that pulls in others.
class Reader final : public Node {
 public:
  struct Params {
    fs::path list, plain;
  };
  Reader(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Reader>("sample.reader", "Reads.")
        .file("list", &Params::list, true, "a file that names others")
        .file("plain", &Params::plain, true, "a file")
        .includes("list", named_in)
        .info();
  }
  void step(StepContext&) override {}
};

}  // namespace

BOOST_AUTO_TEST_CASE(a_sink_gets_what_arrived_in_the_reference_run) {
  const SamplePlan sample(five_milliseconds(), 0.1);
  const Plan plan = reference_of(sample);
  const Reference reference = run_reference(plan, nullptr);
  BOOST_REQUIRE(reference.contains("keep.in"));
  BOOST_TEST(reference.at("keep.in").stamps.size() == 1000U);

  VirtualEngine engine(sample.plan);
  engine.run();
  set_reference(engine.nodes(), reference);
  const auto truth = dynamic_cast<const Keep&>(engine.nodes()[2]).in.reference();
  BOOST_REQUIRE(truth.size() == 1000U);
  BOOST_TEST(truth[517].stamp.valid.ns == 51'700'000);
  BOOST_TEST(truth[517].value.force.x == 517.0);
}

BOOST_AUTO_TEST_CASE(a_node_steps_at_the_reference_s_rate_whatever_gives_its_own_and_never_slower_than_in_the_run) {
  constexpr double none = std::numeric_limits<double>::infinity();
  struct Member {
    double own, most;
    std::optional<double> declared;
    double expected;
  };
  const std::vector<Member> members{
      {60, none, {}, 10000},        {60, none, 10000.0, 10000}, {4000, none, {}, 10000},    {20000, none, {}, 20000},
      {20000, none, 10000., 20000}, {60, 600, {}, 600},         {60, 60, {}, 60},           {60, 600, 10000.0, 600},
      {60, none, 0.0, 60},          {60, none, 2000.0, 2000},   {3000, none, 2000.0, 3000},
  };
  for (const auto& [own, most, declared, expected] : members) {
    SamplePlan sample({}, 0.1);
    ParamInfo& rate = sample.counter.params[0];
    rate.max = most;
    rate.in_reference.reset();
    if (declared) rate.in_reference = *declared;
    sample.plan.nodes[0].params[0] = own;
    const Plan reference = make_reference_plan(sample.plan);
    BOOST_REQUIRE(reference.nodes.size() == 3U);
    const auto counter = std::find_if(reference.nodes.begin(), reference.nodes.end(),
                                      [](const NodeSpec& node) { return node.name == "counter"; });
    BOOST_TEST(std::get<double>(counter->params[0]) == expected);
    // The run, which takes no time in its steps, has as many results as its counter steps.
    const ReferenceRate found =
        rate_of(run_reference(reference, nullptr), &reference, sample.plan, sample.plan.graph.duration,
                [&](std::size_t) { return static_cast<std::uint64_t>(own / 10); });
    BOOST_TEST(std::abs(found.hz - expected) <= 20);
    BOOST_TEST(found.too_coarse.empty() == (expected >= 1.5 * own), found.too_coarse);
    if (found.too_coarse.empty()) continue;
    const bool is_held = expected == own && own < reference_rate;
    BOOST_TEST(found.too_coarse.find(is_held ? "node counter steps at " : "relay.out comes at ") != std::string::npos,
               found.too_coarse);
  }
}

BOOST_AUTO_TEST_CASE(a_truth_with_as_few_results_as_the_run_is_too_coarse_and_is_named_with_its_rate) {
  const SamplePlan sample(five_milliseconds(), 0.1);
  const Plan plan = reference_of(sample);
  Reference reference = run_reference(plan, nullptr);  // 1000 messages
  const auto found = [&](std::uint64_t of_run, const Plan* of) {
    return rate_of(reference, of, sample.plan, sample.plan.graph.duration, [&](std::size_t) { return of_run; });
  };
  BOOST_TEST(found(20, &plan).too_coarse == "");
  BOOST_TEST(found(660, &plan).too_coarse == "");
  BOOST_TEST(found(20, &plan).hz == 10000.0);
  BOOST_TEST(
      found(1000, &plan).too_coarse ==
      "the reference run is no finer than the run: relay.out comes at 10000 Hz in it, and at 10000 Hz in the run");
  BOOST_TEST(found(1000, nullptr).too_coarse ==
             "the recording is no finer than the run: relay.out comes at 10000 Hz in it, and at 10000 Hz in the run");
  // What comes after the end of a shorter run is not counted.
  BOOST_TEST(rate_of(reference, &plan, sample.plan, {50'000'000}, [](std::size_t) { return 400; }).too_coarse != "");
  // A node that is held in one of several ways is named before the count, even where the count is finer.
  const Plan held = sample.plan;
  BOOST_TEST(
      found(20, &held).too_coarse ==
      "the reference run is no finer than the run: node counter steps at 1000 Hz in both, because it can step no "
      "faster");
}

BOOST_AUTO_TEST_CASE(the_cache_gives_back_what_it_was_given) {
  const TemporaryFolder folder;
  const SamplePlan sample(five_milliseconds(), 0.1);
  const Plan plan = reference_of(sample);
  const Reference reference = run_reference(plan, nullptr);
  const ReferenceCache cache(folder.path);
  const std::string key = reference_key(plan, {});
  BOOST_TEST(!cache.load(key, plan).reference);
  BOOST_TEST(cache.store(key, reference) == "");
  const std::optional<Reference> loaded = cache.load(key, plan).reference;
  BOOST_REQUIRE(loaded);
  BOOST_TEST((*loaded == reference));
}

BOOST_AUTO_TEST_CASE(a_damaged_cache_file_is_not_used) {
  const TemporaryFolder folder;
  const SamplePlan sample(five_milliseconds(), 0.01);
  const Plan plan = reference_of(sample);
  const ReferenceCache cache(folder.path);
  BOOST_TEST(cache.store("e", run_reference(plan, nullptr)) == "");
  const fs::path file = folder.path / "e.ref";
  const std::string good = bytes(file);
  for (std::size_t at = 0; at < good.size(); at += 97) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 0x10);
    std::ofstream(file, std::ios::binary) << bad;
    BOOST_TEST(!cache.load("e", plan).reference);
    std::ofstream(file, std::ios::binary) << good.substr(0, at);
    BOOST_TEST(!cache.load("e", plan).reference);
    BOOST_TEST(cache.load("e", plan).note.find("damaged") != std::string::npos);
  }
}

BOOST_AUTO_TEST_CASE(whole_bytes_that_are_no_reference_are_not_used_and_noted) {
  const TemporaryFolder folder;
  const DiskCache disk("ref", ReferenceCache::layout, folder.path);
  BOOST_TEST(disk.store("e", "no reference run") == "");
  BOOST_TEST(disk.load("e").bytes.has_value());
  const ReferenceCache::Found found = ReferenceCache(folder.path).load("e", SamplePlan({}, 0.1).plan);
  BOOST_TEST(!found.reference);
  BOOST_TEST(found.note.find((folder.path / "e.ref").string()) != std::string::npos);
  BOOST_TEST(found.note.find("no reference run") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(a_count_that_does_not_fit_the_plan_is_not_used_and_noted) {
  const TemporaryFolder folder;
  const SamplePlan sample(five_milliseconds(), 0.01);
  const Plan plan = reference_of(sample);
  const Reference good = run_reference(plan, nullptr);
  const ReferenceCache cache(folder.path);
  std::vector<Reference> bad(5, good);
  bad[0].at("keep.in").payloads.pop_back();
  bad[1].at("keep.in").stamps.pop_back();
  bad[2].at("keep.in").payloads.clear();
  bad[3]["keep.none"] = good.at("keep.in");
  bad[4]["nobody.in"] = good.at("keep.in");
  for (const Reference& reference : bad) {
    BOOST_TEST(cache.store("e", reference) == "");
    const ReferenceCache::Found found = cache.load("e", plan);
    BOOST_TEST(!found.reference);
    BOOST_TEST(found.note.find("holds no reference run of this graph; computed again") != std::string::npos);
  }
  // Counts beyond what the entry holds, up to those whose products overflow.
  const DiskCache disk("ref", ReferenceCache::layout, folder.path);
  const std::string bytes = to_bytes(good);
  for (std::size_t at = 0; at + 8 <= bytes.size() && at < 64; at += 1) {
    for (const char byte : {'\x7f', '\xff'}) {
      std::string changed = bytes;
      changed.replace(at, 8, 8, byte);
      BOOST_TEST(disk.store("e", changed) == "");
      static_cast<void>(cache.load("e", plan));
    }
  }
}

BOOST_AUTO_TEST_CASE(a_folder_that_cannot_be_written_is_a_note) {
  const ReferenceCache cache("/proc/no/such/place");
  const Plan plan = SamplePlan({}, 0.1).plan;
  BOOST_TEST(cache.store("e", {}).find("cannot be written") != std::string::npos);
  BOOST_TEST(!cache.load("e", plan).reference);
}

BOOST_AUTO_TEST_CASE(the_key_changes_with_everything_that_changes_the_outcome) {
  const TemporaryFolder folder;
  const SamplePlan sample({}, 0.1);
  Plan plan = sample.plan;
  plan.graph.scene.bodies.push_back({});
  const std::string key = reference_key(plan, {});
  BOOST_TEST(reference_key(plan, {}) == key);

  const auto differs = [&](auto change) {
    Plan other = plan;
    change(other);
    return reference_key(other, {}) != key;
  };
  BOOST_TEST(differs([](Plan& p) { p.graph.seed = 2; }));
  BOOST_TEST(differs([](Plan& p) { p.graph.duration.ns += 1; }));
  BOOST_TEST(differs([](Plan& p) { p.graph.scene.gravity_W.z = 0; }));
  BOOST_TEST(differs([](Plan& p) { p.graph.scene.bodies[0].material.friction += 1e-12; }));
  BOOST_TEST(differs([](Plan& p) { p.nodes[0].params[0] = 2000.0; }));
  BOOST_TEST(differs([](Plan& p) { p.edges[0].spec.queue = {QueuePolicy::drop_oldest, 3}; }));
  BOOST_TEST(differs([](Plan& p) { p.edges.pop_back(); }));

  // What deforms.
  plan.graph.scene.bodies[0].motion = Motion::deformable;
  Deformable& soft = plan.graph.scene.bodies[0].deformable;
  soft.fixed = {BoxRegion{}, HalfSpaceRegion{}, NamedFaces{"base"}};
  soft.inclusions = {{}};
  const std::string of_soft = reference_key(plan, {});
  const auto changes = [&](auto change) {
    Plan other = plan;
    change(other.graph.scene.bodies[0].deformable);
    return reference_key(other, {}) != of_soft;
  };
  for (double Deformable::*member : {&Deformable::young, &Deformable::poisson, &Deformable::density,
                                     &Deformable::damping, &Deformable::drag, &Deformable::cell_size}) {
    BOOST_TEST(changes([member](Deformable& d) { d.*member += 1e-3; }));
  }
  BOOST_TEST(changes([](Deformable& d) { ++d.tetrahedra; }));
  BOOST_TEST(changes([](Deformable& d) { std::get<BoxRegion>(d.fixed[0]).high.x = 1; }));
  BOOST_TEST(changes([](Deformable& d) { std::get<HalfSpaceRegion>(d.fixed[1]).n.x = 1; }));
  BOOST_TEST(changes([](Deformable& d) { std::get<NamedFaces>(d.fixed[2]).name = "side"; }));
  BOOST_TEST(changes([](Deformable& d) { d.fixed.pop_back(); }));
  BOOST_TEST(changes([](Deformable& d) { d.inclusions[0].young = 1; }));
  BOOST_TEST(changes([](Deformable& d) { d.inclusions[0].radius = 1; }));
  BOOST_TEST(changes([](Deformable& d) { d.inclusions.push_back({}); }));

  // A mesh counts by its bytes, not by its name.
  const fs::path mesh = folder.path / "mesh.off";
  std::ofstream(mesh) << "one";
  plan.graph.scene.bodies[0].shape = MeshShape{mesh};
  const std::string one = reference_key(plan, {});
  std::ofstream(mesh) << "two";
  BOOST_TEST(reference_key(plan, {}) != one);
}

BOOST_AUTO_TEST_CASE(the_key_covers_the_files_that_a_file_pulls_in) {
  const TemporaryFolder folder;
  const auto put = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder.path / name) << text;
    return (folder.path / name).string();
  };
  const SamplePlan sample(five_milliseconds(), 0.1);
  const NodeInfo reader = Reader::declare();
  Plan plan = reference_of(sample);
  plan.nodes.push_back({.name = "reader", .info = &reader});
  plan.nodes.back().params = {put("list", "part\nother\n"), put("plain", "alone\n")};
  put("part", "one");
  put("other", "two");
  put("alone", "three");
  const std::string key = reference_key(plan, {});
  BOOST_TEST(reference_key(plan, {}) == key);
  put("part", "changed");
  BOOST_TEST(reference_key(plan, {}) != key);
  put("part", "one");
  BOOST_TEST(reference_key(plan, {}) == key);
  // One that is gone differs from one that is there, and the order counts.
  fs::remove(folder.path / "other");
  BOOST_TEST(reference_key(plan, {}) != key);
  put("part", "two");
  put("other", "one");
  BOOST_TEST(reference_key(plan, {}) != key);
  put("part", "one");
  put("other", "two");
  // A file of a parameter that declares nothing pulls in nothing.
  put("alone", "changed");
  BOOST_TEST(reference_key(plan, {}) == key);
}

BOOST_AUTO_TEST_SUITE_END()
