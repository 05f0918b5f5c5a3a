// The parameters and metrics of devices that count the energy on their line.
#pragma once

#include <optional>

#include "framework/node/declare.hpp"
#include "framework/realtime/line_energy.hpp"

namespace tactor {

/// What a graph says of the energy on a line; `declare_line` declares it.
struct LineParams {
  bool energy_bound = false;
  double handle_acceleration = 60;  ///< m/s^2
  bool tool_weight = true;          ///< the method displays it
};

/// Adds LineParams, from which the Params of N derive, and the metrics of `N::line_totals`, absent where nothing was
/// counted.
template <class N>
void declare_line(Declare<N>& declaration) {
  using P = typename N::Params;
  const LineParams defaults;
  const auto metric = [&declaration](const char* name, const char* unit, const char* doc, Better better,
                                     double LineTotals::*member) {
    declaration
        .metric(name, unit, doc, better,
                [member](const N& self) {
                  const std::optional<LineTotals> totals = self.line_totals();
                  return totals ? std::optional((*totals).*member) : std::nullopt;
                })
        .missing_where("nothing is counted: a handle that is led along a path, or one that follows another run");
  };
  declaration
      .boolean("energy_bound", static_cast<bool P::*>(&P::energy_bound), defaults.energy_bound,
               "bounds the energy on the line itself, by the rule of passivity.energy_bound and with the delays "
               "that the line knows: efforts are scaled down where they could give more than has come in")
      .real("handle_acceleration", static_cast<double P::*>(&P::handle_acceleration),
            {.doc = "largest acceleration of the handle that this bound covers",
             .unit = "m/s^2",
             .default_value = defaults.handle_acceleration,
             .min = 0,
             .max = 1e4})
      .boolean("tool_weight", static_cast<bool P::*>(&P::tool_weight), defaults.tool_weight,
               "true if the method displays the tool's weight, whose part of the energy then counts as the hand's own; "
               "false for a proxy and for a force field",
               Role::sink);
  metric("device.line.energy_generated_J", "J",
         "most energy that the motors had given, net, by the efforts that were in force between the samples of the "
         "encoders",
         Better::lower, &LineTotals::generated_J);
  metric("device.line.energy_allowed_J", "J", "what one encoder step at the largest force and one cycle can bring",
         Better::neither, &LineTotals::allowed_J);
  metric("device.line.changed_share", "1", "share of the cycles with an effort in which energy_bound changed it",
         Better::lower, &LineTotals::changed_share);
}

}  // namespace tactor
