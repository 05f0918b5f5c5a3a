// Who may connect.
#include "app/web/request_rules.hpp"

#include <array>
#include <boost/test/unit_test.hpp>
#include <set>

BOOST_AUTO_TEST_SUITE(request_rules_test)

using namespace tactor;

BOOST_AUTO_TEST_CASE(only_names_of_this_machine_are_its_own) {
  for (const char* host : {"localhost", "127.0.0.1", "localhost:8080", "127.0.0.1:1"}) BOOST_TEST(is_own_host(host));
  for (const char* host :
       {"", ":", "example.org", "example.org:8080", "127.0.0.1.example.org", "localhost.", "127.0.0.2", "0.0.0.0",
        "localhost:", "localhost:80a", "localhost:123456", "[::1]:80", "Localhost@evil"}) {
    BOOST_TEST_CONTEXT(host) {
      BOOST_TEST(!is_own_host(host));
    }
  }
}

BOOST_AUTO_TEST_CASE(an_address_is_no_name) {
  for (const char* host : {"10.0.0.7", "10.0.0.7:80", "127.0.0.1"}) BOOST_TEST(is_numeric_host(host));
  for (const char* host : {"", "localhost", "10.0.0", "10.0.0.7.example.org", "10.0.0.7:", "[::1]:80", "10.0.0.256"}) {
    BOOST_TEST_CONTEXT(host) {
      BOOST_TEST(!is_numeric_host(host));
    }
  }
}

BOOST_AUTO_TEST_CASE(the_origin_is_the_host_with_its_port) {
  BOOST_TEST(is_same_origin("http://127.0.0.1:8080", "127.0.0.1:8080"));
  for (const char* origin : {"", "null", "http://127.0.0.1", "http://127.0.0.1:8081", "http://localhost:8080",
                             "https://127.0.0.1:8080", "http://127.0.0.1:8080/", "http://127.0.0.1:8080.evil"}) {
    BOOST_TEST_CONTEXT(origin) {
      BOOST_TEST(!is_same_origin(origin, "127.0.0.1:8080"));
    }
  }
}

BOOST_AUTO_TEST_CASE(the_token_is_among_the_subprotocols) {
  BOOST_TEST(offered_token("tactor.view, token.abc", "tactor.view").value() == "abc");
  BOOST_TEST(offered_token("token.abc,tactor.view", "tactor.view").value() == "abc");
  BOOST_TEST(offered_token("  tactor.view ,  token.abc  ", "tactor.view").value() == "abc");
  for (const char* offers :
       {"", ",", "tactor.view", "token.abc", "tactor.viewer, token.abc", "tactor.view, tokenabc"}) {
    BOOST_TEST_CONTEXT(offers) {
      BOOST_TEST(!offered_token(offers, "tactor.view").has_value());
    }
  }
}

BOOST_AUTO_TEST_CASE(the_first_known_protocol_that_is_offered_is_spoken) {
  constexpr std::array<std::string_view, 2> known{"new.v1", "old.v1"};
  BOOST_TEST(offered_protocol("old.v1,new.v1", known).value() == "new.v1");
  BOOST_TEST(offered_protocol(" old.v1 ", known).value() == "old.v1");
  for (const char* offers : {"", ",", "old.v2", "old", "new.v1.x", "old.v1 new.v1"}) {
    BOOST_TEST_CONTEXT(offers) {
      BOOST_TEST(!offered_protocol(offers, known).has_value());
    }
  }
}

BOOST_AUTO_TEST_CASE(secrets_are_equal_or_not) {
  BOOST_TEST(same_secret("abc", "abc"));
  BOOST_TEST(!same_secret("abc", "abd"));
  BOOST_TEST(!same_secret("abc", "ab"));
  BOOST_TEST(!same_secret("", "a"));
}

BOOST_AUTO_TEST_CASE(no_token_comes_twice) {
  std::set<std::string> tokens;
  for (int i = 0; i < 1000; ++i) tokens.insert(make_token());
  BOOST_TEST(tokens.size() == 1000U);
  BOOST_TEST(tokens.begin()->size() == 32U);
  BOOST_TEST(tokens.begin()->find_first_not_of("0123456789abcdef") == std::string::npos);
}

BOOST_AUTO_TEST_SUITE_END()
