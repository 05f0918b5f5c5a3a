// Nothing that comes from outside controls the terminal, and honest text stays as it is.
#include "framework/core/shown_text.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <boost/test/unit_test.hpp>
#include <cstdio>
#include <iostream>
#include <random>

BOOST_AUTO_TEST_SUITE(shown_text_test)

using namespace tactor;

namespace {

std::string utf8(std::uint32_t code) {
  const auto byte = [](std::uint32_t bits) { return static_cast<char>(bits); };
  if (code < 0x80) return {byte(code)};
  if (code < 0x800) return {byte(0xc0 | code >> 6U), byte(0x80 | (code & 0x3fU))};
  if (code < 0x10000) return {byte(0xe0 | code >> 12U), byte(0x80 | (code >> 6U & 0x3fU)), byte(0x80 | (code & 0x3fU))};
  return {byte(0xf0 | code >> 18U), byte(0x80 | (code >> 12U & 0x3fU)), byte(0x80 | (code >> 6U & 0x3fU)),
          byte(0x80 | (code & 0x3fU))};
}

/// Whether bytes hold a control character as a terminal understands them: C0 but line break and tab, DEL, or C1.
bool controls(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    if ((c < 0x20 && c != '\n' && c != '\t') || c == 0x7f) return true;
    if (c == 0xc2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xa0) return true;
  }
  return false;
}

/// What a child that has called show_only_text writes to both of its outputs.
template <class Write>
std::string written_by(const Write& write) {
  int ends[2];
  BOOST_REQUIRE(pipe(ends) == 0);
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    dup2(ends[1], STDOUT_FILENO);
    dup2(ends[1], STDERR_FILENO);
    close(ends[0]), close(ends[1]);
    show_only_text();
    write();
    std::fflush(nullptr);
    _exit(0);
  }
  close(ends[1]);
  std::string text;
  char part[4096];
  for (ssize_t n = 0; (n = read(ends[0], part, sizeof part)) > 0;) text.append(part, static_cast<std::size_t>(n));
  close(ends[0]);
  waitpid(child, nullptr, 0);
  return text;
}

}  // namespace

BOOST_AUTO_TEST_CASE(what_controls_a_terminal_is_told_by_its_number) {
  struct Case {
    std::string_view text;
    std::string_view shown;
  };
  using namespace std::string_view_literals;
  const Case cases[] = {
      {"\x1b]0;title\x07"sv, R"(\u001b]0;title\u0007)"},
      {"\x1b[2J\x1b[1;1H"sv, R"(\u001b[2J\u001b[1;1H)"},
      {"one\rtwo\btwo\x7f"sv, R"(one\u000dtwo\u0008two\u007f)"},
      {"a\0b"sv, R"(a\u0000b)"},
      {"\xc2\x9b"
       "31m"sv,
       R"(\u009b31m)"},
      {"\x9b"
       "31m"sv,
       R"(\x9b31m)"},
      {"\xe2\x80\xae"
       "fdp.exe"sv,
       R"(\u202efdp.exe)"},
      {"\xe2\x81\xa6x\xe2\x81\xa9"sv, R"(\u2066x\u2069)"},
      {"\xe2\x80\x8b\xef\xbb\xbf"sv, R"(\u200b\ufeff)"},
      {"\xf3\xa0\x81\x81"sv, R"(\udb40\udc41)"},
      {"\xc0\x9b\xe0\x80\x9b"sv, R"(\xc0\x9b\xe0\x80\x9b)"},
      {"\xed\xa0\x80"sv, R"(\xed\xa0\x80)"},
      {"\xf4\x90\x80\x80\xff"sv, R"(\xf4\x90\x80\x80\xff)"},
      {"cut \xe2\x82"sv, R"(cut \xe2\x82)"},
  };
  for (const Case& one : cases) BOOST_TEST(shown_text(one.text) == one.shown);
}

BOOST_AUTO_TEST_CASE(honest_text_stays) {
  for (const std::string text :
       {"", "line\n\tindented\n", "\xc2\xb5m, \xc3\xa9t\xc3\xa9, \xe2\x86\x92, \xe6\x8a\x80\xe8\xa1\x93",
        "\xf0\x9f\x99\x82", "\xd7\xa9\xd7\x9c\xd7\x95\xd7\x9d", "back\\slash", "\xef\xbf\xbd"}) {
    BOOST_TEST(shown_text(text) == text);
  }
}

BOOST_AUTO_TEST_CASE(every_character_of_unicode_stays_or_is_told) {
  std::size_t members = 0, told = 0;
  for (std::uint32_t code = 0; code <= 0x10ffff; ++code) {
    if (code >= 0xd800 && code <= 0xdfff) continue;
    const std::string text = utf8(code), shown = shown_text(text);
    ++members;
    if (shown == text) {
      if (controls(shown)) BOOST_ERROR("a control stays: " << code);
      continue;
    }
    ++told;
    if (shown[0] != '\\' || controls(shown)) BOOST_ERROR("not told: " << code);
  }
  BOOST_TEST(members == 0x110000U - 0x800U);
  // 32 of C0 without two, DEL and 32 of C1 among them.
  BOOST_TEST(told > 63U);
  BOOST_TEST(told < 300U);
}

BOOST_AUTO_TEST_CASE(any_bytes_give_text_without_controls_and_shown_twice_is_shown_once) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> byte(0, 255), length(0, 12);
  for (int i = 0; i < 100'000; ++i) {
    std::string text;
    for (int n = length(random); n > 0; --n) text += static_cast<char>(byte(random));
    const std::string shown = shown_text(text);
    if (controls(shown) || shown_text(shown) != shown) BOOST_ERROR("bytes of member " << i);
  }
}

BOOST_AUTO_TEST_CASE(every_way_to_the_outputs_is_guarded) {
  const std::string escape = "\x1b[31m";
  const std::string shown = R"(\u001b[31m)";
  BOOST_TEST(written_by([&] { std::fputs(escape.c_str(), stdout); }) == shown);
  BOOST_TEST(written_by([&] { std::fputs(escape.c_str(), stderr); }) == shown);
  BOOST_TEST(written_by([&] { std::printf("%s%d", escape.c_str(), 7); }) == shown + "7");
  BOOST_TEST(written_by([&] { std::cout << escape << std::flush; }) == shown);
  BOOST_TEST(written_by([&] { std::cerr << escape; }) == shown);
  BOOST_TEST(written_by([&] { std::clog << escape << std::endl; }) == shown + "\n");
  // Our own colours, behind what was printed before.
  BOOST_TEST(written_by([&] {
               std::fputs("before ", stdout);
               draw_on_terminal(STDOUT_FILENO, escape);
             }) == "before " + escape);
}

BOOST_AUTO_TEST_CASE(a_character_that_is_written_in_two_pieces_stays_one) {
  BOOST_TEST(written_by([&] {
               std::fputs("\xe2\x86", stderr);
               std::fflush(stderr);
               std::fputs("\x92\xc2", stderr);
               std::fflush(stderr);
               std::fputs("\x9b!", stderr);
             }) == "\xe2\x86\x92\\u009b!");
}

BOOST_AUTO_TEST_SUITE_END()
