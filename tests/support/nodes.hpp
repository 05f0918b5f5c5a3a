// Makes nodes with their declared defaults, so that tests name only what they change; stamps, and what nodes send and
// report.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "framework/node/info.hpp"

namespace tactor::test {

template <class N>
typename N::Params default_params() {
  typename N::Params params{};
  for (const ParamInfo& p : N::declare().params) p.assign(&params, p.default_value.value());
  return params;
}

/// The values of a node's parameters: those given by name, the defaults of the others.
inline std::vector<ParamValue> param_values(const NodeInfo& info, const std::map<std::string, ParamValue>& given) {
  std::vector<ParamValue> values;
  for (const ParamInfo& param : info.params) {
    const auto it = given.find(param.name);
    values.push_back(it == given.end() ? param.default_value.value() : it->second);
  }
  return values;
}

inline NodeContext context_for(const Scene& scene) {
  NodeContext context;
  context.name = "test";
  context.scene = &scene;
  context.torque = scene.rotates();
  return context;
}

inline Time at_ms(double ms) {
  return Time::from_seconds(1e-3 * ms);
}

/// The stamp of a message that is valid and produced at that time.
inline Stamp stamp_ms(double ms, std::uint64_t sequence = 0) {
  return {at_ms(ms), at_ms(ms), sequence};
}

/// What the node reports.
template <class N>
Report report_of(const N& node) {
  Report report;
  report.ask(node, "test", N::declare().metrics);
  return report;
}

inline std::map<std::string, double> metrics_of(const Report& report) {
  return {report.metrics().begin(), report.metrics().end()};
}

template <class N>
std::map<std::string, double> metrics_of(const N& node) {
  return metrics_of(report_of(node));
}

/// The message number i that the running step has sent.
template <class T>
const T& sent(const Output<T>& out, std::size_t i = 0) {
  return *static_cast<const T*>(out.pending_value(i));
}

}  // namespace tactor::test
