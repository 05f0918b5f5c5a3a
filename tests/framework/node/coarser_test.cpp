// Which value of a parameter comes next on the way from fine to coarse.
#include <boost/test/unit_test.hpp>
#include <string>

#include "framework/node/info.hpp"

BOOST_AUTO_TEST_SUITE(coarser_test)

using namespace tactor;

namespace {

ParamInfo with(std::vector<ParamValue> values) {
  ParamInfo info;
  info.coarser = std::move(values);
  return info;
}

}  // namespace

BOOST_AUTO_TEST_CASE(numbers_go_on_in_the_direction_of_the_ladder) {
  const ParamInfo up = with({0.001, 0.002, 0.004});
  BOOST_TEST(std::get<double>(next_coarser(up, 0.0).value()) == 0.001);
  BOOST_TEST(std::get<double>(next_coarser(up, 0.001).value()) == 0.002);
  BOOST_TEST(std::get<double>(next_coarser(up, 0.003).value()) == 0.004);
  BOOST_TEST(!next_coarser(up, 0.004).has_value());
  const ParamInfo down = with({std::int64_t{10}, std::int64_t{5}});
  BOOST_TEST(std::get<std::int64_t>(next_coarser(down, std::int64_t{60}).value()) == 10);
  BOOST_TEST(std::get<std::int64_t>(next_coarser(down, std::int64_t{10}).value()) == 5);
  BOOST_TEST(!next_coarser(down, std::int64_t{5}).has_value());
  BOOST_TEST(!next_coarser(down, std::int64_t{0}).has_value());
}

BOOST_AUTO_TEST_CASE(words_and_switches_go_on_to_the_one_after) {
  const ParamInfo words = with({std::string("middle"), std::string("coarse")});
  BOOST_TEST(std::get<std::string>(next_coarser(words, std::string("fine")).value()) == "middle");
  BOOST_TEST(std::get<std::string>(next_coarser(words, std::string("middle")).value()) == "coarse");
  BOOST_TEST(!next_coarser(words, std::string("coarse")).has_value());
  BOOST_TEST(std::get<bool>(next_coarser(with({false}), true).value()) == false);
  BOOST_TEST(!next_coarser(with({false}), false).has_value());
}

BOOST_AUTO_TEST_CASE(a_parameter_without_a_ladder_has_none) {
  BOOST_TEST(!next_coarser(ParamInfo{}, 1.0).has_value());
}

BOOST_AUTO_TEST_SUITE_END()
