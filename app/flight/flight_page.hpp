// The page of a flight file: the last moments on one time axis.
#pragma once

#include <string>
#include <vector>

#include "app/flight/flight_findings.hpp"
#include "app/flight/flight_source.hpp"
#include "app/report/chart.hpp"

namespace tactor {

/// Force, position, gate, wake-ups and ages over time, with the findings as marks; none without a device.
std::vector<Chart> flight_charts(const FlightLog& log, const std::vector<FlightFinding>& findings);

/// An HTML page with the fault, the charts and the findings.
std::string flight_page(const FlightSource& source, const std::vector<FlightFinding>& findings);

}  // namespace tactor
