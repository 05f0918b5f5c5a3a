// Graphs in process, as the command takes them: loaded, checked and run with what is laid over them.
#pragma once

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <regex>
#include <string>
#include <vector>

#include "app/run/run.hpp"
#include "framework/core/check.hpp"
#include "framework/core/message.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/engine/plan_nodes.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"
#include "framework/session/session.hpp"

namespace tactor::test {

/// The folder of the shipped graphs.
inline const std::filesystem::path graphs = std::filesystem::path(TACTOR_SOURCE_DIR) / "graphs";

/// Skips a test where this build has no generated meshes.
struct NeedsMeshes {
  boost::test_tools::assertion_result operator()(boost::unit_test::test_unit_id) const {
    boost::test_tools::assertion_result result(
        std::filesystem::exists(std::filesystem::path(TACTOR_BINARY_DIR) / "meshes/bunny.off"));
    if (!result) result.message() << "this build has no CGAL, so no generated meshes";
    return result;
  }
};

/// The node types of this build.
inline Registry& registry() {
  static Registry all({TACTOR_NODE_FOLDER});
  return all;
}

inline std::filesystem::path write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file) << text;
  return file;
}

inline std::string text_in(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  BOOST_REQUIRE(stream.good());
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// The text with all of `what`, which it has, replaced.
inline std::string replaced(std::string text, const std::string& what, const std::string& by) {
  std::size_t at = text.find(what);
  BOOST_TEST(at != std::string::npos, what << " in " << text);
  for (; at != std::string::npos; at = text.find(what, at + by.size())) text.replace(at, what.size(), by);
  return text;
}

/// What is laid over a graph: each word is `PATH=VALUE`, or a file, whose path may begin in `graphs`.
using Over = std::vector<std::string>;

inline Over operator+(Over over, const Over& more) {
  over.insert(over.end(), more.begin(), more.end());
  return over;
}

inline GraphSpec loaded(const std::filesystem::path& graph, const Over& over = {}) {
  Overrides patches;
  for (const std::string& word : over) {
    patches.push_back(word.find('=') == std::string::npos ? over_patch(graphs / word) : set_patch(word));
  }
  return load_graph(graphs / graph, registry(), patches);
}

inline Plan planned(const std::filesystem::path& graph, const Over& over = {}) {
  return make_plan(loaded(graph, over));
}

/// `check --explain` on a wide terminal.
inline std::string explained(const std::filesystem::path& graph, const Over& over = {}) {
  return explain(planned(graph, over), 1000);
}

/// The error that `work` throws because of its input; empty where it throws none.
template <class Work>
std::string refusal_of(const Work& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

/// Why a check refuses the graph; empty where it does not.
inline std::string refusal(const std::filesystem::path& graph, const Over& over = {}) {
  return refusal_of([&] { check_nodes(planned(graph, over)); });
}

/// Why a run refuses it before it begins.
inline std::string refusal_of_run(const std::filesystem::path& graph, const Over& over = {}) {
  return refusal_of([&] { const Session session(planned(graph, over)); });
}

/// What a check notes, one note a line.
inline std::string notes_of(const std::filesystem::path& graph, const Over& over = {}) {
  std::string text;
  for (const std::string& note : check_nodes(planned(graph, over))) text += note + "\n";
  return text;
}

/// Listens to a session before it starts.
using Listener = std::function<void(Session&)>;

/// Keeps all messages of an output.
template <class T>
Listener kept(const std::string& output, std::vector<Stamped<T>>& messages) {
  return [output, &messages](Session& session) {
    BOOST_REQUIRE(type_of(session.plan(), find_output(session.plan(), output)).size == sizeof(T));
    session.on_message(output, [&messages](const Stamp& stamp, const void* value) {
      Stamped<T>& message = messages.emplace_back();
      message.stamp = stamp;
      std::memcpy(static_cast<void*>(&message.value), value, sizeof message.value);
    });
  };
}

/// Runs the plan to its end. Throws RunError where it fails.
inline RunResult run(const Plan& plan, const std::vector<Listener>& listeners = {}, RunOptions options = {}) {
  static const TemporaryFolder references;
  options.cache_folder = references.path();
  options.before_start = [&listeners](Session& session) {
    for (const Listener& listener : listeners) listener(session);
  };
  RunResult result = execute(plan, options);
  if (result.failure) throw RunError(*result.failure);
  return result;
}

/// What a node did in the run.
inline const NodeCost& node_of(const RunResult& run, const std::string& name) {
  for (const NodeCost& node : run.nodes) {
    if (node.node == name) return node;
  }
  BOOST_FAIL("no node " + name);
  return run.nodes.front();
}

/// Fails where the two numbers are further apart.
inline void near(double found, double expected, double difference) {
  BOOST_TEST(std::abs(found - expected) <= difference, found << " is not within " << difference << " of " << expected);
}

/// Fails where the text does not have the ECMAScript pattern.
inline void says_like(const std::string& text, const std::string& pattern) {
  BOOST_TEST(std::regex_search(text, std::regex(pattern)), pattern << " in " << text);
}

}  // namespace tactor::test
