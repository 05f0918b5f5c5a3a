// For tests that count the calls of the heap: skipped, with their names told, where the program cannot count.
#pragma once

#include <boost/test/unit_test.hpp>
#include <cstdio>

#include "framework/realtime/allocation_watch.hpp"

namespace tactor::test {

/// Precondition of such a test. The heap of a sanitizer is its own and is not counted.
inline boost::test_tools::assertion_result heap_is_counted(boost::unit_test::test_unit_id id) {
  boost::test_tools::assertion_result result(heap_calls_are_counted());
  if (!heap_calls_are_counted()) {
    const auto& test = boost::unit_test::framework::get(id, boost::unit_test::TUT_ANY);
    std::fprintf(stderr, "skipped: %s: this build does not count the calls of the heap\n", test.full_name().c_str());
    result.message() << "this build does not count the calls of the heap";
  }
  return result;
}

}  // namespace tactor::test
