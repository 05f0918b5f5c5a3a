#include "nodes/sink/felt_metrics.hpp"

#include <string>

#include "framework/core/felt.hpp"
#include "nodes/sink/metrics.hpp"

namespace tactor {

void declare_felt_metrics(Declare<Metrics>& node) {
  const auto add = [&node](const char* name, const char* unit, const char* doc, Better better, const char* missing) {
    node.metric(std::string("delivered.force.") + name, unit, doc, better)
        .missing_where(missing)
        .left_out_when([](const Metrics::Params&, const MetricUse& use) {
          return use.reference ? std::string() : "no reference run is made";
        });
  };
  add("share_beyond_weber", "1", "share of the time in which the error is noticed at the reference's force",
      Better::lower, "fewer than three commands come in the judged interval");
  const char* const no_band = "less than 0.5 s is judged, or commands come slower than 25 Hz";
  add("vibration_above_threshold_dB", "dB", "vibration of the error over what is felt, highest band", Better::lower,
      no_band);
  add("vibration_above_threshold_Hz", "Hz", "centre of that band", Better::neither,
      "less than 0.5 s is judged, commands come slower than 25 Hz, or there is no vibration");
  add("worst_vibration_above_threshold_dB", "dB", "the same of the worst half second", Better::lower, no_band);
}

void report_felt(Report& report, std::span<const Vec3> x, std::span<const Vec3> reference, double rate_Hz,
                 double handle_mass) {
  const std::string delivered = "delivered.force.";
  report.set(delivered + "share_beyond_weber", share_beyond_weber(x, reference));
  const auto felt = felt_vibration(x, reference, rate_Hz, handle_mass);
  if (!felt) return;
  report.set(delivered + "vibration_above_threshold_dB", felt->mean_dB);
  if (felt->mean_Hz > 0) report.set(delivered + "vibration_above_threshold_Hz", felt->mean_Hz);
  report.set(delivered + "worst_vibration_above_threshold_dB", felt->worst_dB);
}

}  // namespace tactor
