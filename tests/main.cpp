// main() of every test program: the suite is named after the program. With it the header of Boost.Test is precompiled.
#include <boost/test/unit_test.hpp>

#include <filesystem>

namespace {

bool name_suite() {
  auto& suite = boost::unit_test::framework::master_test_suite();
  suite.p_name.value = std::filesystem::path(suite.argv[0]).filename().string();
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  return boost::unit_test::unit_test_main(name_suite, argc, argv);
}
