// A flight file as text for a terminal, as JSON and as CSV.
#pragma once

#include <cstddef>
#include <ostream>
#include <string>
#include <vector>

#include "app/flight/flight_findings.hpp"
#include "app/flight/flight_source.hpp"

namespace tactor {

/// `line_failed, node device, 3.214 s: no whole answer within 25 ms`.
std::string fault_line(const FlightFinding& finding);

/// The fault in the first line, then what the file is, the other findings, and the ticks of the device round the fault,
/// at most `columns` wide.
std::string flight_text(const FlightSource& source, const std::vector<FlightFinding>& findings, std::size_t columns);

/// JSON lines: the first has the fault and what the file is, then comes one a record, in the order of their times.
void write_flight_json(const FlightSource& source, const std::vector<FlightFinding>& findings, std::ostream& out);

/// A row a record, in the order of their times. The columns have the fields of all kinds, those of another kind empty.
void write_flight_csv(const FlightLog& log, std::ostream& out);

}  // namespace tactor
