// Former names are replaced where they stand, and nothing else of a file changes.
#include "framework/graph/migrate.hpp"

#include <boost/test/unit_test.hpp>

BOOST_AUTO_TEST_SUITE(migrate_test)

namespace {

using namespace tactor;

/// Two types that were renamed in, and one that still has a parameter called `window`.
std::vector<NodeInfo> types() {
  NodeInfo filter;
  filter.type = "my.filter";
  filter.params.resize(2);
  filter.params[0].name = "detrend";
  filter.params[0].former = "remove";
  filter.params[1].name = "span";
  filter.params[1].former = "window";
  filter.outputs.resize(1);
  filter.outputs[0].name = "parameters";
  filter.outputs[0].former = "law";
  NodeInfo other;
  other.type = "my.other";
  other.params.resize(1);
  other.params[0].name = "window";
  other.inputs.resize(1);
  other.inputs[0].name = "coupling";
  other.inputs[0].former = "law";
  return {filter, other};
}

Migrated migrated(const std::string& text) {
  const std::vector<NodeInfo> all = types();
  Diagnostics diagnostics;
  Migrated found = migrate(text, "x.yaml", {&all[0], &all[1]}, diagnostics);
  BOOST_TEST(!diagnostics.any());
  return found;
}

BOOST_AUTO_TEST_CASE(names_are_replaced_and_comments_spaces_and_order_are_kept) {
  const Migrated found = migrated(
      "# About the law, which we remove.\n"
      "title: \"the law\"   # remove: none\n"
      "\n"
      "nodes:\n"
      "  f: {type: my.filter,  remove: none }   # not `remove`\n"
      "  g:\n"
      "    # window of 3\n"
      "    window : 3\n"
      "    type: my.filter\n"
      "  law: {type: my.other, window: 5}\n"
      "edges:\n"
      "  - f.law -> law.law   # the law\n"
      "  - \"g.law->law.law\": latest\n"
      "  - {from: f.law, to: law.law}\n"
      "record: [f.law, \"g.law\"]\n");
  BOOST_TEST(found.text ==
             "# About the law, which we remove.\n"
             "format: 2\n"
             "title: \"the law\"   # remove: none\n"
             "\n"
             "nodes:\n"
             "  f: {type: my.filter,  detrend: none }   # not `remove`\n"
             "  g:\n"
             "    # window of 3\n"
             "    span : 3\n"
             "    type: my.filter\n"
             "  law: {type: my.other, window: 5}\n"
             "edges:\n"
             "  - f.parameters -> law.coupling   # the law\n"
             "  - \"g.parameters->law.coupling\": latest\n"
             "  - {from: f.parameters, to: law.coupling}\n"
             "record: [f.parameters, \"g.parameters\"]\n");
  BOOST_TEST(found.changes.size() == 11U);
  BOOST_TEST(found.changes[1].place.line == 5);
  BOOST_TEST(found.changes[1].before == "remove");
  BOOST_TEST(found.changes[1].now == "detrend");
  BOOST_TEST(migrated(found.text).changes.empty());
}

BOOST_AUTO_TEST_CASE(a_node_of_unknown_type_gets_the_names_that_all_types_agree_on) {
  // `window` is still the name of a parameter of one type.
  BOOST_TEST(migrated("format: 2\nnodes:\n  f: {remove: none, window: 3}\n").text ==
             "format: 2\nnodes:\n  f: {detrend: none, window: 3}\n");
}

BOOST_AUTO_TEST_CASE(the_paths_of_studies_are_replaced_wherever_they_stand) {
  BOOST_TEST(migrated("graphs: [a.yaml]\n"
                      "set: {f.remove: none}\n"
                      "vary:\n"
                      "  f.remove, g.remove: [none, mean]\n"
                      "  way: {swap: {one: {nodes: {f: {remove: none}}, edges: [f.law -> g.x]}}}\n"
                      "short: {vary: {nodes.f.remove: [none]}}\n")
                 .text ==
             "format: 2\n"
             "graphs: [a.yaml]\n"
             "set: {f.detrend: none}\n"
             "vary:\n"
             "  f.detrend, g.detrend: [none, mean]\n"
             "  way: {swap: {one: {nodes: {f: {detrend: none}}, edges: [f.parameters -> g.x]}}}\n"
             "short: {vary: {nodes.f.detrend: [none]}}\n");
}

BOOST_AUTO_TEST_CASE(a_file_of_one_line_gets_its_format_inside_the_braces) {
  BOOST_TEST(migrated("{nodes: {f: {remove: none}}}\n").text == "{format: 2, nodes: {f: {detrend: none}}}\n");
}

BOOST_AUTO_TEST_CASE(what_an_alias_repeats_is_replaced_where_it_was_written_and_nowhere_else) {
  BOOST_TEST(migrated("format: 2\n"
                      "nodes:\n"
                      "  f: &f {type: my.filter, remove: none}   # remove\n"
                      "  g: *f   # remove\n"
                      "edges: &e [f.law -> g.law]   # f.law\n"
                      "short: {edges: *e}   # f.law\n")
                 .text ==
             "format: 2\n"
             "nodes:\n"
             "  f: &f {type: my.filter, detrend: none}   # remove\n"
             "  g: *f   # remove\n"
             "edges: &e [f.parameters -> g.law]   # f.law\n"
             "short: {edges: *e}   # f.law\n");
}

BOOST_AUTO_TEST_CASE(only_the_key_is_replaced_and_not_a_value_that_reads_like_it) {
  BOOST_TEST(migrated("format: 2\nnodes:\n  f: {type: my.filter, span: remove, 'remove': remove}\n").text ==
             "format: 2\nnodes:\n  f: {type: my.filter, span: remove, 'detrend': remove}\n");
  // A key that is spelt with escapes is left to the user, and nothing else is touched.
  const std::string spelt = "format: 2\nnodes:\n  f: {type: my.filter, \"rem\\x6fve\": remove}\n";
  BOOST_TEST(migrated(spelt).text == spelt);
}

BOOST_AUTO_TEST_CASE(a_mark_of_the_byte_order_stays_in_front) {
  BOOST_TEST(migrated("\xEF\xBB\xBFnodes: {f: {type: my.filter, remove: none}}\n").text ==
             "\xEF\xBB\xBF"
             "format: 2\nnodes: {f: {type: my.filter, detrend: none}}\n");
}

BOOST_AUTO_TEST_CASE(a_form_that_cannot_be_rewritten_is_refused_and_stays_as_it_is) {
  for (const char* text : {"? nodes\n: {}\n", "format: 2\nnodes: {f: {type: my.filter, remove: 1, detrend: 2}}\n"}) {
    const std::vector<NodeInfo> all = types();
    Diagnostics diagnostics;
    const Migrated found = migrate(text, "x.yaml", {&all[0], &all[1]}, diagnostics);
    BOOST_TEST(found.text == text);
    BOOST_TEST(found.changes.empty());
    BOOST_REQUIRE(diagnostics.list().size() == 1U);
    BOOST_TEST(diagnostics.list()[0].place.text().starts_with("x.yaml:1:"));
    BOOST_TEST(diagnostics.list()[0].message.find("by hand") != std::string::npos);
  }
}

BOOST_AUTO_TEST_CASE(what_is_no_yaml_stays_as_it_is) {
  Diagnostics diagnostics;
  BOOST_TEST(migrate("nodes: [", "x.yaml", {}, diagnostics).text == "nodes: [");
  BOOST_TEST(diagnostics.any());
}

}  // namespace

BOOST_AUTO_TEST_SUITE_END()
