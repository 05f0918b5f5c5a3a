// Nodes that send scans, and that judge scans which come.
#pragma once

#include "framework/node/declare.hpp"
#include "framework/node/new_messages.hpp"
#include "tests/scan_nodes/scan.hpp"

namespace tactor::scan {

/// Sends scan n at its n-th step.
class Source final : public Node {
 public:
  struct Params {
    double rate = 0;
  };
  Source(const Params& /*params*/, const NodeContext& /*context*/) {}
  static NodeInfo declare();
  void step(StepContext& context) override;

  Output<Scan> scan;

 private:
  ScanMaker maker_{64, 5};
  std::int64_t next_ = 0;
};

/// Counts the scans that hold what the source sends, and those that do not, in order from the first.
class Judge final : public Node {
 public:
  struct Params {};
  Judge(const Params& /*params*/, const NodeContext& /*context*/) {}
  static NodeInfo declare();
  void step(StepContext& context) override;
  void report(Report& report) const override;

  Input<Scan> scan;

 private:
  ScanMaker maker_{1, 5};
  NewMessages<Scan> new_scans_;
  std::int64_t good_ = 0, bad_ = 0;
};

}  // namespace tactor::scan
