// The JSON Schema, judged by a validator that is not ours: good graphs pass, graphs with errors of form do not.
#include <boost/test/unit_test.hpp>
#include <cstdlib>
#include <fstream>

#include "framework/graph/plan.hpp"
#include "test_nodes.hpp"

BOOST_AUTO_TEST_SUITE(graph_schema_test)

using namespace tactor;
using namespace tactor::testing;
namespace fs = std::filesystem;

namespace {

const fs::path here = fs::path(TACTOR_SOURCE_DIR) / "tests/framework/graph";

struct Fixture {
  Folder folder;
  fs::path schema;

  Fixture() {
    Registry registry = test_registry();
    schema = folder.write("schema.json", graph_schema(registry));
  }

  // How many of the files are not valid.
  int validate(const std::vector<fs::path>& files) const {
    std::string command = "/usr/bin/python3 '" + (here / "validate.py").string() + "' '" + schema.string() + "'";
    for (const fs::path& file : files) command += " '" + file.string() + "'";
    const int status = std::system((command + " >/dev/null 2>&1").c_str());
    return status / 256;
  }
};

boost::test_tools::assertion_result has_validator(boost::unit_test::test_unit_id) {
  const int status = std::system("/usr/bin/python3 -c 'import jsonschema, yaml' >/dev/null 2>&1");
  boost::test_tools::assertion_result result(status == 0);
  result.message() << "python3-jsonschema or python3-yaml is not installed";
  return result;
}

}  // namespace

BOOST_TEST_DECORATOR(*boost::unit_test::precondition(has_validator))
BOOST_FIXTURE_TEST_CASE(good_graphs_validate, Fixture) {
  const fs::path part = folder.write("part.yaml",
                                     "extends: other.yaml\nnodes:\n  device: {rate: ~, cost: ~}\n  refit: ~\n"
                                     "edges:\n  - a.b -> c.d: ~\nscene: {bodies: {wall: ~}}\n");
  const fs::path written = folder.write("pipeline.yaml", pipeline(rigid_scene));
  const fs::path soft = folder.write("soft.yaml", R"(duration: 1 s
nodes: {v: {type: test.values}}
scene:
  bodies:
    gel:
      box: {size: [80 mm, 80 mm, 40 mm]}
      motion: deformable
      young: 20 kPa
      poisson: 0.45
      tetrahedra: 500
      fixed: [{behind: {p: [0, 0, -20 mm], n: [0, 0, 1]}}, {faces: side}]
      inclusions: {lump: {p: [0, 0, 0], radius: 5 mm, young: 0.2 MPa}, none: ~}
)");
  BOOST_TEST(validate({here / "good/pipeline.yaml", part, written, soft}) == 0);
}

BOOST_TEST_DECORATOR(*boost::unit_test::precondition(has_validator))
BOOST_FIXTURE_TEST_CASE(graphs_with_errors_of_form_do_not_validate, Fixture) {
  std::vector<fs::path> files;
  for (const char* name : {"unknown_key",
                           "no_nodes",
                           "no_duration",
                           "bad_clock",
                           "integer_is_a_fraction",
                           "integer_out_of_bounds",
                           "list_of_wrong_length",
                           "table_lacks_a_column",
                           "table_row_too_long",
                           "node_without_type",
                           "unknown_type",
                           "missing_parameter",
                           "unknown_parameter",
                           "choice_misspelt",
                           "cost_is_a_time",
                           "edge_without_arrow",
                           "queue_of_zero",
                           "motion_misspelt",
                           "sphere_without_radius",
                           "lane_misspelt",
                           "realtime_of_a_type_that_waits",
                           "priority_of_a_hundred",
                           "policy_misspelt",
                           "cpu_below_zero",
                           "thread_of_two_words",
                           "live_is_a_text",
                           "live_with_unknown_key",
                           "on_stall_is_a_boolean",
                           "impose_cost_is_a_time",
                           "pool_of_no_workers",
                           "pool_with_unknown_key",
                           "deformable_fixed_of_no_kind",
                           "deformable_fixed_of_two_kinds",
                           "deformable_fixed_of_unknown_kind",
                           "deformable_inclusion_without_radius",
                           "deformable_poisson_below_zero",
                           "deformable_poisson_of_a_half",
                           "deformable_tetrahedra_of_two"}) {
    files.push_back(here / "bad" / (std::string(name) + ".yaml"));
    BOOST_TEST(fs::exists(files.back()), name);
  }
  BOOST_TEST(validate(files) == static_cast<int>(files.size()));
}

BOOST_AUTO_TEST_SUITE_END()
