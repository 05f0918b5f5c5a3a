// Which fields of a plan go into its file.
#pragma once

#include "app/study/cluster/cluster_plan.hpp"
#include "app/study/run/job_fields.hpp"

namespace tactor {

void fields(auto& bytes, SameAs<Overlay> auto& overlay) {
  bytes(overlay.name, overlay.patch);
}
void fields(auto& bytes, SameAs<StudyValue> auto& value) {
  bytes(value.text, value.swap, value.place);
}
void fields(auto& bytes, SameAs<StudyRange> auto& range) {
  bytes(range.from, range.to, range.unit, range.log, range.whole);
}
void fields(auto& bytes, SameAs<StudyAxis> auto& axis) {
  bytes(axis.name, axis.paths, axis.values, axis.range);
}
void fields(auto& bytes, SameAs<AxisValue> auto& at) {
  bytes(at.axis, at.value);
}
void fields(auto& bytes, SameAs<StudySpec> auto& s) {
  bytes(s.name, s.title, s.file, s.text, s.is_short, s.graphs, s.methods, s.set, s.vary, s.design, s.baseline,
        s.samples, s.design_seed, s.seeds, s.first_seed, s.duration, s.run_timeout_s, s.reference,
        s.reference_recording, s.judge, s.without_reference, s.metrics, s.metric_places, s.report, s.report_place,
        s.error, s.error_place, s.time, s.bounds, s.worst, s.record, s.record_places, s.repeats, s.warm_up);
}
void fields(auto& bytes, SameAs<JudgedFrom> auto& judged) {
  bytes(judged.from, judged.run, judged.last, judged.cold);
}
void fields(auto& bytes, SameAs<RunCase> auto& c) {
  bytes(c.graph, c.overrides, c.configuration, c.against, c.reference, c.reference_recording, c.group, c.judged,
        c.unvaried);
}
void fields(auto& bytes, SameAs<TableIdentity> auto& identity) {
  bytes(identity.title, identity.study, identity.options, identity.program);
}
void fields(auto& bytes, SameAs<CasesSettings> auto& s) {
  bytes(s.seeds, s.repeats, s.warm_up, s.judge_warm, s.without_reference, s.run_timeout_s, s.refused_are_results,
        s.identity, s.study_file);
}
void fields(auto& bytes, SameAs<Obstacle> auto& obstacle) {
  bytes(obstacle.status, obstacle.message, obstacle.may_differ);
}
void fields(auto& bytes, SameAs<PlannedCases> auto& p) {
  bytes(p.cases, p.settings, p.checks, p.obstacles, p.libraries, p.codes, p.inputs, p.loaded, p.reference_case,
        p.judged);
}
void fields(auto& bytes, SameAs<Stage> auto& stage) {
  bytes(stage.kind, stage.cases, stage.chunk_begin);
}
void fields(auto& bytes, SameAs<UnitCosts> auto& costs) {
  bytes(costs.warm, costs.references, costs.runs);
}
void fields(auto& bytes, SameAs<ClusterPlan> auto& plan) {
  bytes(plan.spec, plan.planned, plan.code, plan.stages, plan.costs, plan.recordings, plan.depends_on_processor,
        plan.chunk_s, plan.exclusive);
}

}  // namespace tactor
