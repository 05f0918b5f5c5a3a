// The precondition of tests that run a session in wall time.
#pragma once

#include <boost/test/unit_test.hpp>

#include "framework/node/plugin.hpp"

namespace tactor::test {

/// Skips a test where this build has no live engine.
struct NeedsLive {
  boost::test_tools::assertion_result operator()(boost::unit_test::test_unit_id) const {
    boost::test_tools::assertion_result result(has_plugin("libtactor_live.so"));
    if (!result) result.message() << "this build has no live engine";
    return result;
  }
};

}  // namespace tactor::test
