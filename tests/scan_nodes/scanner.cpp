#include "tests/scan_nodes/scanner.hpp"

namespace tactor::scan {

NodeInfo Source::declare() {
  return Declare<Source>("scan.source", "Sends scans.")
      .output("scan", &Source::scan, "the scans")
      .rate("rate", &Params::rate, {.doc = "scans a second", .default_value = 100})
      .info();
}

void Source::step(StepContext& context) {
  scan.send(context.now(), maker_.make(next_++));
}

NodeInfo Judge::declare() {
  return Declare<Judge>("scan.judge", "Compares scans with those that the source sends.")
      .sink()
      .input("scan", &Judge::scan,
             {.doc = "the scans", .trigger = Trigger::yes, .queue = {QueuePolicy::drop_oldest, 8}})
      .metric("good_scans", "1", "scans that hold what the source sends", Better::higher)
      .metric("bad_scans", "1", "scans that do not", Better::lower)
      .info();
}

void Judge::step(StepContext& /*context*/) {
  Stamped<Scan> message;
  while (new_scans_.next(scan, message)) {
    const bool good = same_scan(message.value, maker_.make(good_ + bad_));
    good ? ++good_ : ++bad_;
  }
}

void Judge::report(Report& report) const {
  report.set("good_scans", static_cast<double>(good_));
  report.set("bad_scans", static_cast<double>(bad_));
}

}  // namespace tactor::scan
