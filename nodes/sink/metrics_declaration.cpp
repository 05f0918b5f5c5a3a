// The ports, parameters and metrics of sink.metrics.
#include <string>
#include <utility>

#include "nodes/sink/felt_metrics.hpp"
#include "nodes/sink/metrics.hpp"

namespace tactor {

namespace {

using std::string;

constexpr const char* too_short = "fewer than three commands come in the judged interval";

std::string without_reference(const MetricUse& use) {
  return use.reference ? "" : "no reference run is made";
}
std::string without_whole(const MetricUse& use) {
  return use.whole ? "" : "the run goes on until it is stopped, so only its end is kept";
}
std::string without_torque(const MetricUse& use) {
  return use.torque ? "" : "the scene is translation-only";
}
std::string without_input(const MetricUse& use, const char* input) {
  return use.is_fed(input) ? "" : string("nothing feeds the input ") + input;
}

/// Declares the metrics of one part of a wrench.
class PartMetrics {
 public:
  /// `name` and `suffix` as the metrics' names have them, `unit` as tables show it.
  PartMetrics(Declare<Metrics>& node, const char* name, string suffix, string unit)
      : node_(node), name_(name), suffix_(std::move(suffix)), unit_(std::move(unit)) {}

  void declare() {
    const string delivered = "delivered." + name_ + ".", reference = "reference." + name_ + ".";
    const string first = unit_ + "/ms", second = unit_ + "/ms^2";
    add(delivered + "rms_d1_" + suffix_ + "_per_ms", first, "RMS first difference", Better::neither, false);
    add(delivered + "rms_d2_" + suffix_ + "_per_ms2", second, "RMS second difference", Better::lower, false);
    add(delivered + "max_step_" + suffix_, unit_, "largest step between two commands", Better::lower, false);
    add(reference + "rms_" + suffix_, unit_, "RMS of the reference", Better::neither, true);
    add(reference + "rms_d1_" + suffix_ + "_per_ms", first, "RMS first difference of the reference", Better::neither,
        true);
    add(reference + "rms_d2_" + suffix_ + "_per_ms2", second, "RMS second difference of the reference", Better::neither,
        true);
    add(reference + "max_step_" + suffix_, unit_, "largest step of the reference between two commands", Better::neither,
        true);
    add(delivered + "rms_d2_excess_" + suffix_ + "_per_ms2", second, "RMS second difference less that of the reference",
        Better::lower, true);
    add(delivered + "rms_error_" + suffix_, unit_, "RMS error against the reference", Better::lower, true);
    add(delivered + "max_error_" + suffix_, unit_, "largest error against the reference", Better::lower, true);
    add(delivered + "error_above_30hz_" + suffix_, unit_, "RMS of the error above 30 Hz", Better::lower, true,
        string(too_short) + ", or commands come at 60 Hz or slower");
    add(delivered + "delay_ms", "ms", "delay behind the reference; positive: late", Better::near_zero, true,
        string(too_short) + ", or the correlation of their changes has no peak");
    add(delivered + "share_beyond_jnd", "1", "share of the time in which the error can be felt", Better::lower, true);
    const string no_loss = string(too_short) + ", or contact is never lost";
    add(delivered + "overshoot_after_loss_" + suffix_, unit_,
        "largest pull towards the surface after contact was lost, beyond the reference's", Better::lower, true,
        no_loss);
    add(delivered + "ghost_after_loss_" + suffix_, unit_,
        "largest push away from the surface late after contact was lost", Better::lower, true, no_loss);

    const string one_step = "one_step." + name_ + ".";
    add_one_step(one_step + "rms_error_" + suffix_, "RMS error of the first step predicted", Better::lower);
    add_one_step(one_step + "rms_error_hold_" + suffix_, "RMS error that a hold would have", Better::neither);

    const string physics = "physics." + name_ + ".";
    const string no_result = "no physics result comes in the judged interval and before the end of the reference run";
    add(physics + "rms_error_" + suffix_, unit_, "RMS error of the physics results at their stamps", Better::lower,
        true, no_result);
    add(physics + "max_error_" + suffix_, unit_, "largest error of the physics results at their stamps", Better::lower,
        true, no_result);
  }

 private:
  void add(string name, string unit, string doc, Better better, bool needs_reference, string missing = too_short) {
    const bool is_torque = name_ == "torque";
    node_.metric(std::move(name), std::move(unit), std::move(doc), better)
        .missing_where(std::move(missing))
        .left_out_when([is_torque, needs_reference](const Metrics::Params&, const MetricUse& use) {
          string why = is_torque ? without_torque(use) : string();
          return !why.empty() || !needs_reference ? why : without_reference(use);
        });
  }
  void add_one_step(string name, string doc, Better better) {
    const bool is_torque = name_ == "torque";
    node_.metric(std::move(name), unit_, std::move(doc), better)
        .missing_where("no physics result comes after a forecast in the judged interval")
        .left_out_when([is_torque](const Metrics::Params&, const MetricUse& use) {
          string why = is_torque ? without_torque(use) : string();
          return why.empty() ? without_input(use, "forecast") : why;
        });
  }

  Declare<Metrics>& node_;
  string name_, suffix_, unit_;
};

void declare_parameters(Declare<Metrics>& node) {
  using Params = Metrics::Params;
  node.real("settle", &Params::settle,
            {.doc = "time at the start that the metrics leave out", .unit = "s", .default_value = 0.2, .min = 0})
      .real("jnd_force", &Params::jnd_force,
            {.doc = "the smallest force that is felt on the arm", .unit = "N", .default_value = 0.04, .min = 0})
      .real("jnd_torque", &Params::jnd_torque,
            {.doc = "the smallest torque felt: 0.04 N at 50 mm", .unit = "N m", .default_value = 0.002, .min = 0})
      .real("jnd_fraction", &Params::jnd_fraction,
            {.doc = "smallest relative change that is felt", .default_value = 0.07, .min = 0, .max = 1})
      .real("mass", &Params::handle_mass,
            {.doc = "mass of the device's handle, which decides how much force makes it vibrate",
             .unit = "kg",
             .default_value = 0.1,
             .min = 0.001,
             .max = 100,
             .as_in = Role::device})
      .real("max_delay", &Params::max_delay,
            {.doc = "largest delay that is searched for", .unit = "s", .default_value = 0.1, .min = 0, .max = 10})
      .real("loss_force", &Params::loss_force,
            {.doc = "contact is lost when the reference force falls below this",
             .unit = "N",
             .default_value = 0.2,
             .min = 0})
      .real("loss_torque", &Params::loss_torque,
            {.doc = "contact is lost when the reference torque falls below this",
             .unit = "N m",
             .default_value = 0.01,
             .min = 0})
      .real("loss_window", &Params::loss_window,
            {.doc = "time after a loss of contact in which overshoot and ghost force are measured",
             .unit = "s",
             .default_value = 0.2,
             .min = 0})
      .real("rest", &Params::rest,
            {.doc =
                 "time at the end of the run in which the tool should be at rest, for stability.*; 0: it need not rest",
             .unit = "s",
             .default_value = 0,
             .min = 0})
      .real("rest_peak_to_peak", &Params::rest_peak_to_peak,
            {.doc = "peak-to-peak amplitude that the tool may have at rest; more counts as a limit cycle. The tremor "
                    "of a trajectory is included",
             .unit = "m",
             .default_value = 1e-4,
             .min = 0})
      .real("encoder_step", &Params::encoder_step,
            {.doc = "step of the device's position encoders, for port.energy_allowed_J",
             .unit = "m",
             .default_value = 1e-5,
             .min = 0,
             .max = 1e-2,
             .as_in = Role::device})
      .real("encoder_step_angle", &Params::encoder_step_angle,
            {.doc = "step of its angle encoders",
             .unit = "rad",
             .default_value = 1e-4,
             .min = 0,
             .max = 0.1,
             .as_in = Role::device})
      .boolean("tool_weight", &Params::tool_weight, true,
               "true if the method displays the tool's weight, whose part of port.energy_generated_J then counts as "
               "the hand's own; false for a proxy and for a force field")
      .formerly("rest_peak_to_peak", "rest_swing")
      .formerly("mass", "handle_mass");
  for (const auto& [name, member] : {std::pair{"delay_in", &Params::delay_in}, {"delay_out", &Params::delay_out}}) {
    node.real(name, member,
              {.doc = "as of the device's line; stability.passive is told where it is 0",
               .unit = "s",
               .default_value = 0,
               .min = 0,
               .as_in = Role::device});
  }
}

void declare_energy_metrics(Declare<Metrics>& node) {
  const auto unwatched = [](const Metrics::Params&, const MetricUse& use) {
    if (!use.whole) return without_whole(use);
    return use.is_fed("state") ? string() : without_input(use, "device");
  };
  const auto without_rest = [unwatched](const Metrics::Params& params, const MetricUse& use) {
    return params.rest.ns == 0 ? string("rest is 0") : unwatched(params, use);
  };
  const char* const unseen = "fewer than two samples of handle and tool come";
  node.metric("stability.verdict", "1", "0 stable, 1 limit cycle, 3 energy from nowhere, 4 not finite", Better::lower)
      .missing_where(unseen)
      .left_out_when(unwatched)
      .metric("stability.peak_energy_J", "J", "most energy that the tool had at a time", Better::neither)
      .missing_where(unseen)
      .left_out_when(unwatched)
      .metric("stability.passivity_violation_J", "J", "most energy that the hand got beyond what it had given",
              Better::lower)
      .missing_where(unseen)
      .left_out_when(unwatched)
      .metric("stability.oscillation_amplitude_m", "m", "amplitude of the tool's oscillation over `rest`",
              Better::lower)
      .missing_where(unseen)
      .left_out_when(without_rest)
      .metric("stability.oscillation_frequency_Hz", "Hz", "frequency of the tool's oscillation over `rest`",
              Better::neither)
      .missing_where(unseen)
      .left_out_when(without_rest);
  const auto no_port = [](const Metrics::Params&, const MetricUse& use) {
    if (!use.whole) return without_whole(use);
    return use.is_fed("truth") ? string() : without_input(use, "device");
  };
  const char* const few = "fewer than two samples of the handle come";
  node.metric("stability.passive", "1", "1: port.energy_generated_J is within port.energy_allowed_J, 0: it is not",
              Better::higher)
      .missing_where(
          "fewer than two samples of the handle come, or the line of the device delays: then device.line.* "
          "tells what it gave")
      .left_out_when(no_port)
      .metric("port.energy_generated_J", "J", "most net energy that the motors had given to handle and hand",
              Better::lower)
      .missing_where(few)
      .left_out_when(no_port)
      .metric("port.energy_allowed_J", "J", "what one encoder step at the largest force and one tick can bring",
              Better::neither)
      .missing_where(few)
      .left_out_when(no_port);
}

void declare_metrics(Declare<Metrics>& node) {
  PartMetrics(node, "force", "N", "N").declare();
  PartMetrics(node, "torque", "Nm", "N m").declare();
  declare_felt_metrics(node);
  const char* const never_cold =
      "all nodes are warm from the start or one never is, nothing comes before, or the whole run is judged";
  node.metric("judged.from_s", "s", "when the judged interval begins", Better::neither)
      .metric("judged.duration_s", "s", "how long it is", Better::neither)
      .missing_where("no command comes after its begin")
      .metric("cold_start.delivered.force.rms_error_N", "N",
              "RMS error against the reference from `settle` until all nodes are warm", Better::lower)
      .missing_where(never_cold)
      .left_out_when([](const Metrics::Params&, const MetricUse& use) {
        return use.whole ? without_reference(use) : without_whole(use);
      })
      .metric("cold_start.one_step.force.rms_error_N", "N",
              "RMS error of the first step predicted from `settle` until all nodes are warm", Better::lower)
      .missing_where(never_cold)
      .left_out_when([](const Metrics::Params&, const MetricUse& use) {
        return use.whole ? without_input(use, "forecast") : without_whole(use);
      });
  const char* const no_rate = "fewer than two physics results come, or none in the judged interval";
  node.metric("physics.steps", "1", "physics results", Better::neither)
      .metric("physics.rate_hz_min", "Hz", "lowest rate of the physics over ten intervals", Better::neither)
      .missing_where(no_rate)
      .metric("physics.rate_hz_max", "Hz", "highest rate of the physics over ten intervals", Better::neither)
      .missing_where(no_rate)
      .metric("physics.rate_hz_median", "Hz", "median rate of the physics over ten intervals", Better::neither)
      .missing_where(no_rate);
  const auto without_state = [](const Metrics::Params&, const MetricUse& use) { return without_input(use, "state"); };
  const char* const no_state = "no state comes in the judged interval";
  node.metric("contacts.max", "1", "most contacts that carried force", Better::neither)
      .missing_where(no_state)
      .left_out_when(without_state)
      .metric("contacts.median", "1", "median number of contacts that carried force", Better::neither)
      .missing_where(no_state)
      .left_out_when(without_state);
}

}  // namespace

NodeInfo Metrics::declare() {
  const Queue every{QueuePolicy::drop_oldest, 64};
  Declare<Metrics> node("sink.metrics", "Measures error, delay and smoothness of the delivered force.");
  node.sink()
      .details(
          "delivered.* compares `commanded` with the physics force of the reference run at the same time. It has the "
          "RMS and the largest error, and the RMS of the error above 30 Hz (Butterworth of fourth order forwards and "
          "backwards, so without a shift). The delay is the lag at which the changes of the two within 20 ms correlate "
          "best; positive means late, and it is left out if there is none. Smoothness is the RMS of the first and "
          "second difference, the second also as the excess over the reference's, and the largest step. The share of "
          "time in which the error can be felt has two forms: share_beyond_jnd has one floor and one fraction, "
          "share_beyond_weber a curve that grows at low forces. The vibration of the error is compared with what a "
          "hand on the handle feels, in thirds of an octave (docs/results/thresholds.md). After contact is lost, if it "
          "ever is, the overshoot is the largest force towards the surface beyond the reference's own, and the ghost "
          "is the force that still pushes away from it late in the window.\none_step.* compares the predicted force "
          "with the next physics force, and has the error of a hold.\nphysics.* tells how often `force` comes, counted "
          "over ten intervals in a row (over all if there are fewer), and its error at its own stamp against the "
          "reference at that time, which contains no delay.\ncontacts.* counts contacts that carried "
          "force.\nstability.* is about the energy where hand and device meet, and about the tool at rest. "
          "passivity_violation is the most energy that the hand has got from the device beyond what it had given and "
          "what the tool's weight gave. peak_energy is the most energy that the tool had at a time: kinetic energy, "
          "and the energy of its height if it was above its start. oscillation is the amplitude (half of the way there "
          "and back; a drift in one direction does not count) and the frequency of the tool over `rest`. The verdict "
          "is 0 stable, 1 limit cycle (more than `rest_peak_to_peak` there and back), 3 energy from nowhere (over 10 % "
          "of what came in and 1 uJ), 4 not finite. Only the tool counts, no other moving body; a massless tool counts "
          "with the weight that the scene gives it. stability.passive is the strict form of stable. It holds if at no "
          "time the motors had given more net energy at the port (commanded wrench by the displacement of the handle, "
          "less the weight's part) than max |F| D + max |F . dx|, where D is a step of the encoder and dx the "
          "displacement of a tick. The displacement is the handle's true one if `truth` is connected. Without a "
          "reference, the metrics that need one are left out. A run until stopped is judged over its last one to two "
          "minutes, without its energy and without a reference.")
      .input("commanded", &Metrics::commanded,
             {.doc = "the wrench that the device should display, at its rate",
              .trigger = Trigger::yes,
              .queue = every,
              .judged = true})
      .input("force", &Metrics::force,
             {.doc = "the physics force; the reference run's is the truth",
              .trigger = Trigger::yes,
              .queue = every,
              .reference = true})
      .input("forecast", &Metrics::forecast,
             {.doc = "what was predicted", .trigger = Trigger::yes, .required = false, .queue = every})
      .input("state", &Metrics::state,
             {.doc = "for the contacts", .trigger = Trigger::yes, .required = false, .queue = every})
      .input("device", &Metrics::device,
             {.doc = "for the displacement", .trigger = Trigger::yes, .required = false, .queue = every})
      .input("truth", &Metrics::true_device,
             {.doc = "the true state of the handle, for the energy of the port; without this input, `device` is used",
              .trigger = Trigger::yes,
              .required = false,
              .queue = every});
  declare_parameters(node);
  declare_metrics(node);
  declare_energy_metrics(node);
  return node.info();
}

}  // namespace tactor
