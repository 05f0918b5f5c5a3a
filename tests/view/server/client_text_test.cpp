// What a page may say, and what it may not.
#include "app/view/server/client_text.hpp"

#include <boost/test/unit_test.hpp>

BOOST_AUTO_TEST_SUITE(client_text_test)

using namespace tactor;

BOOST_AUTO_TEST_CASE(every_message_of_the_protocol_is_read) {
  const auto ack = read_client_text(R"({"type":"ack","frame":17})");
  BOOST_REQUIRE(ack.has_value());
  BOOST_TEST((ack->kind == ClientMessage::Kind::ack));
  BOOST_TEST(ack->frame == 17U);
  const auto input = read_client_text(R"({"type":"input","p":[0.1,-2,3e-1],"q":[0,0,1,0],"held":true})");
  BOOST_REQUIRE(input.has_value());
  BOOST_TEST((input->kind == ClientMessage::Kind::input));
  BOOST_TEST((input->X_WC.p == Vec3{0.1, -2, 0.3}));
  BOOST_TEST((input->X_WC.R == Quat{0, 0, 1, 0}));
  BOOST_TEST(input->held);
  const auto set = read_client_text(R"({"type":"set","parameter":"coupling.k_0","value":"1200 N/m"})");
  BOOST_REQUIRE(set.has_value());
  BOOST_TEST(set->parameter == "coupling.k_0");
  BOOST_TEST(set->value == "1200 N/m");
  BOOST_TEST((read_client_text(R"({"type":"stop"})")->kind == ClientMessage::Kind::stop));
  BOOST_TEST((read_client_text(R"({"type":"control"})")->kind == ClientMessage::Kind::control));
}

BOOST_AUTO_TEST_CASE(what_is_no_message_is_refused) {
  for (const char* text : {"",
                           "{",
                           "[]",
                           "null",
                           "17",
                           R"("stop")",
                           "{}",
                           R"({"type":17})",
                           R"({"type":"dance"})",
                           R"({"type":"ack"})",
                           R"({"type":"ack","frame":-1})",
                           R"({"type":"ack","frame":1.5})",
                           R"({"type":"ack","frame":"1"})",
                           R"({"type":"input"})",
                           R"({"type":"input","p":[0,0],"q":[1,0,0,0],"held":true})",
                           R"({"type":"input","p":[0,0,"0"],"q":[1,0,0,0],"held":true})",
                           R"({"type":"input","p":[0,0,NaN],"q":[1,0,0,0],"held":true})",
                           R"({"type":"input","p":[0,0,null],"q":[1,0,0,0],"held":true})",
                           R"({"type":"input","p":[0,0,1e999],"q":[1,0,0,0],"held":true})",
                           R"({"type":"input","p":[0,0,1e6],"q":[1,0,0,0],"held":true})",
                           R"({"type":"input","p":[0,0,0],"q":[0,0,0,0],"held":true})",
                           R"({"type":"input","p":[0,0,0],"q":[2,0,0,0],"held":true})",
                           R"({"type":"input","p":[0,0,0],"q":[1,0,0,0],"held":1})",
                           R"({"type":"input","p":[0,0,0],"q":[1,0,0,0]})",
                           R"({"type":"set","parameter":"a.b"})",
                           R"({"type":"set","parameter":"a.b","value":3})",
                           R"({"type":"set","parameter":"","value":"3"})",
                           "{\"type\":\"set\",\"parameter\":\"\xff\",\"value\":\"3\"}"}) {
    BOOST_TEST_CONTEXT(text) {
      BOOST_TEST(!read_client_text(text).has_value());
    }
  }
  const std::string longest(257, 'x');
  BOOST_TEST(!read_client_text(R"({"type":"set","parameter":"a.b","value":")" + longest + "\"}").has_value());
  BOOST_TEST(!read_client_text(std::string(4096, '[')).has_value());
}

BOOST_AUTO_TEST_CASE(a_quaternion_is_made_a_unit_one) {
  const auto input = read_client_text(R"({"type":"input","p":[0,0,0],"q":[1.0004,0,0,0],"held":false})");
  BOOST_REQUIRE(input.has_value());
  BOOST_TEST((input->X_WC.R == Quat{1, 0, 0, 0}));
}

BOOST_AUTO_TEST_SUITE_END()
