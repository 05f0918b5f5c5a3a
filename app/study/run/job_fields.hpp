// Which fields of jobs, answers and what they are made of go from one process of a study to another.
#pragma once

#include "app/study/run/job.hpp"
#include "framework/core/bytes.hpp"

namespace tactor {

// Of a run this is what its table keeps.

void fields(auto& bytes, SameAs<SourceLocation> auto& place) {
  bytes(place.file, place.line, place.column);
}
void fields(auto& bytes, SameAs<Tree> auto& tree) {
  bytes(tree.kind, tree.place, tree.text, tree.quoted, tree.items, tree.entries);
}
void fields(auto& bytes, SameAs<TreeEntry> auto& entry) {
  bytes(entry.key, entry.place, entry.value);
}
void fields(auto& bytes, SameAs<Assignment> auto& assignment) {
  bytes(assignment.path, assignment.value);
}
void fields(auto& bytes, SameAs<Patch> auto& patch) {
  bytes(patch.place, patch.change);
}
void fields(auto& bytes, SameAs<Time> auto& time) {
  bytes(time.ns);
}
void fields(auto& bytes, SameAs<Warmth> auto& warmth) {
  bytes(warmth.since, warmth.last, warmth.when);
}
void fields(auto& bytes, SameAs<Job> auto& job) {
  bytes(job.kind, job.graph, job.overrides, job.reference, job.seed, job.seeds, job.libraries, job.repeats, job.warm_up,
        job.without_reference, job.reference_recording, job.judge_from, job.judge_whole, job.all_curves,
        job.time_limit_s, job.cache_folder);
}
void fields(auto& bytes, SameAs<JobCost> auto& cost) {
  bytes(cost.cpu_s, cost.waited_for_core_s, cost.interrupted, cost.depends_on_processor);
}
void fields(auto& bytes, SameAs<WarmUp> auto& warm_up) {
  bytes(warm_up.warmth, warm_up.failure, warm_up.may_differ, warm_up.cost);
}
void fields(auto& bytes, SameAs<MetricInfo> auto& info) {
  bytes(info.name, info.unit, info.doc, info.better, info.summed, info.missing);
}
void fields(auto& bytes, SameAs<RunMetrics> auto& metrics) {
  bytes(metrics.reported, metrics.left_out);
}
void fields(auto& bytes, SameAs<CaseCheck> auto& check) {
  bytes(check.result, check.message, check.title, check.content, check.reference, check.duration_s,
        check.has_to_warm_up, check.metrics, check.notes, check.libraries, check.code_files, check.codes, check.inputs,
        check.loaded);
}
void fields(auto& bytes, SameAs<NodeCost> auto& node) {
  bytes(node.node, node.type, node.role, node.steps, node.missed_ticks, node.median_us, node.p99_us, node.total_s);
}
void fields(auto& bytes, SameAs<Series> auto& series) {
  bytes(series.name, series.unit, series.time, series.value);
}
void fields(auto& bytes, SameAs<Chosen> auto& chosen) {
  bytes(chosen.node, chosen.asked, chosen.type, chosen.why);
}
void fields(auto& bytes, SameAs<LeftOut> auto& left_out) {
  bytes(left_out.what, left_out.why);
}
void fields(auto& bytes, SameAs<NoForce> auto& no_force) {
  bytes(no_force.device, no_force.reason, no_force.count, no_force.of, no_force.text);
}
void fields(auto& bytes, SameAs<RunResult> auto& result) {
  bytes(result.title, result.duration_s, result.cpu_s, result.wall_s, result.peak_memory_MB, result.metrics,
        result.declared, result.series, result.nodes, result.chosen, result.left_out, result.reference.too_coarse,
        result.devices, result.no_force);
}
void fields(auto& bytes, SameAs<RanOn> auto& machine) {
  bytes(machine.node, machine.processor, machine.c_library);
}
void fields(auto& bytes, SameAs<RunRecord> auto& record) {
  bytes(record.status, record.message, record.may_differ, record.result, record.cpu_s, record.control_us, record.ran_on,
        record.finished);
}
void fields(auto& bytes, SameAs<RunAnswer> auto& answer) {
  bytes(answer.record, answer.cost);
}

}  // namespace tactor
