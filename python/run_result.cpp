#include "python/run_result.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/output.hpp"
#include "app/report/run_report.hpp"
#include "app/results_folder.hpp"
#include "app/run/live.hpp"
#include "app/run/run.hpp"
#include "app/run/summary.hpp"
#include "framework/core/message_json.hpp"
#include "framework/core/user_folders.hpp"
#include "framework/realtime/flight_file.hpp"
#include "framework/session/session.hpp"
#include "python/errors.hpp"
#include "python/file_text.hpp"
#include "python/graph.hpp"
#include "python/message_arrays.hpp"
#include "python/release_lock.hpp"
#include "python/tap_buffer.hpp"

namespace tactor::python {

namespace py = pybind11;
namespace fs = std::filesystem;
using namespace py::literals;

namespace {

/// A finished run with what was tapped of it.
struct FinishedRun {
  RunResult result;
  std::shared_ptr<Registry> registry;  // the taps' message types live in it
  GraphSpec graph;
  std::vector<std::string> notes;
  std::vector<std::pair<std::string, std::shared_ptr<TapBuffer>>> taps;
  std::string folder;     ///< of the results, or empty
  std::string recording;  ///< or empty

  [[nodiscard]] std::string html() const { return run_report(result, &graph); }
};

struct RunRequest {
  std::optional<std::string> out;
  bool overwrite = false, follow = false, without_reference = false, no_dead_man = false;
  std::optional<std::string> reference;
  std::vector<std::string> taps;
};

/// The files that the command leaves.
void write_results(const fs::path& folder, const Plan& plan, const FinishedRun& run) {
  write_file(folder / "summary.json", to_json(run.result).dump(2) + "\n");
  write_file(folder / "graph.yaml", run.result.graph_yaml);
  if (run.result.live) write_file(folder / "latencies.csv", latencies_csv(plan, *run.result.live));
  write_file(folder / "report.html", run.html());
}

/// Before anything is written: throws InputError where the plan has no such output.
void make_buffers(const Plan& plan, const std::vector<std::string>& outputs, FinishedRun& run) {
  for (const std::string& output : outputs) {
    const MessageType& type = type_of(plan, find_output(plan, output));
    run.taps.emplace_back(output, std::make_shared<TapBuffer>(type, 0));
  }
}

/// Looks for signals while a run goes on; what their handlers raise waits until the run has ended.
class SignalWatch {
 public:
  /// False once a handler has raised, or the program ends.
  bool go_on() {
    if (raised_) return false;
    if (is_ending()) return false;
    const LockHeld lock;
    if (PyErr_CheckSignals() == 0) return true;
    raised_ = std::make_unique<py::error_already_set>();
    return false;
  }
  /// With the interpreter's lock.
  void pass_on() {
    if (raised_) throw py::error_already_set(*raised_);
  }

 private:
  std::unique_ptr<py::error_already_set> raised_;
};

std::unique_ptr<FinishedRun> run(const Graph& graph, const RunRequest& request) {
  auto made = std::make_unique<FinishedRun>();
  made->registry = graph.registry();
  made->graph = graph.spec();
  SignalWatch signals;
  const auto make = [&] {
    const Plan plan = graph.plan_for(request.taps);
    make_buffers(plan, request.taps, *made);
    std::optional<ResultsFolder> results;
    RunOptions options;
    if (request.out) {
      results.emplace(fs::path(*request.out), ResultsRequest{fs::path(*request.out), request.overwrite});
      results->refuse_to_replace(plan.graph.file);
      made->folder = results->path().string();
      options.before_writing = [&results] { results->clear(); };
      options.recording = results->path() / "recording.h5";
      options.flight = results->path() / flight_name;
    }
    options.keeps_tables = true;
    options.traces = true;
    options.provenance = true;
    options.cache_folder = default_cache_folder();
    options.note = [&](const std::string& note) { made->notes.push_back(note); };
    options.progress = [&](double, const char*) { return signals.go_on(); };
    options.live_progress = [&](const LiveLook&) { return signals.go_on(); };
    options.without_dead_man = [&](const std::string&) { return request.no_dead_man; };
    options.reference_recording = request.reference;
    options.without_reference = request.without_reference;
    if (request.follow) {
      if (plan.graph.clock != Clock::real) {
        throw InputError(
            "follow: expected a graph with clock: real, found clock: virtual, which is compared afterwards");
      }
      options.follow = graph.registry().get();
    }
    options.before_start = [&](Session& session) {
      for (const auto& [output, buffer] : made->taps) {
        session.on_message(output, [kept = buffer](const Stamp& stamp, const void* value) { kept->put(stamp, value); });
      }
    };
    made->result = execute(plan, options);
    if (results && !plan.streams.empty()) made->recording = options.recording->string();
    if (results) write_results(results->path(), plan, *made);
    // A step that never came back still uses the declarations.
    if (made->result.abandoned) static_cast<void>(new std::shared_ptr<Registry>(graph.registry()));
  };
  without_lock(make, graph.spec().clock == Clock::real);
  signals.pass_on();
  return made;
}

py::dict series_of(const FinishedRun& run) {
  py::dict all;
  for (const Series& series : run.result.series) {
    all[py::str(series.name)] = py::make_tuple(
        series.unit, py::array_t<double>(static_cast<py::ssize_t>(series.time.size()), series.time.data()),
        py::array_t<double>(static_cast<py::ssize_t>(series.value.size()), series.value.data()));
  }
  return all;
}

py::dict taps_of(const FinishedRun& run) {
  py::dict all;
  for (const auto& [output, buffer] : run.taps) {
    all[py::str(output)] =
        py::make_tuple(to_documented_json(buffer->type()), MessageArrays(buffer->type()).take(buffer->take()));
  }
  return all;
}

}  // namespace

py::list metric_list(const std::vector<std::pair<std::string, double>>& metrics, const MetricMap& declared) {
  py::list all;
  for (const auto& [name, value] : metrics) {
    const auto found = declared.find(name);
    const MetricInfo info = found == declared.end() ? MetricInfo{} : found->second;
    all.append(py::make_tuple(name, value, info.unit, name_of(info.better), info.doc));
  }
  return all;
}

void bind_run(py::module_& module) {
  py::class_<FinishedRun>(module, "RunResult")
      .def_property_readonly("summary", [](const FinishedRun& run) { return to_json(run.result).dump(); })
      .def_property_readonly(
          "metrics", [](const FinishedRun& run) { return metric_list(run.result.metrics, run.result.declared); })
      .def_property_readonly("series", series_of)
      .def("take_taps", taps_of)
      .def_property_readonly("failure",
                             [](const FinishedRun& run) -> py::object {
                               if (!run.result.failure) return py::none();
                               return python_text(*run.result.failure);
                             })
      .def_property_readonly("notes", [](const FinishedRun& run) { return python_texts(run.notes); })
      .def_property_readonly("graph_yaml", [](const FinishedRun& run) { return python_text(run.result.graph_yaml); })
      .def_property_readonly("folder", [](const FinishedRun& run) { return python_text(run.folder); })
      .def_property_readonly("recording", [](const FinishedRun& run) { return python_text(run.recording); })
      .def(
          "table", [](const FinishedRun& run, std::size_t columns) { return summary_table(run.result, columns); },
          py::arg("columns"))
      .def("html", &FinishedRun::html);
  module.def(
      "run",
      [](const Graph& graph, const std::optional<std::string>& out, bool overwrite, bool follow,
         const std::optional<std::string>& reference, bool without_reference, bool no_dead_man,
         const std::vector<std::string>& taps) {
        return run(graph, {out, overwrite, follow, without_reference, no_dead_man, reference, taps});
      },
      py::arg("graph"), py::kw_only(), py::arg("out") = py::none(), py::arg("overwrite") = false,
      py::arg("follow") = false, py::arg("reference") = py::none(), py::arg("without_reference") = false,
      py::arg("no_dead_man") = false, py::arg("taps") = std::vector<std::string>{});
}

}  // namespace tactor::python
