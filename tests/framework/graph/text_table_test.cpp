// Tables and prose fit the columns that there are, and lose nothing on the way.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <sstream>

#include "framework/graph/text_table.hpp"

BOOST_AUTO_TEST_SUITE(text_table_test)

using namespace tactor;
using enum TextTable::Align;

namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::size_t widest(const std::string& text) {
  std::size_t width = 0;
  for (const std::string& line : lines_of(text)) width = std::max(width, display_width(line));
  return width;
}

std::string without_spaces(std::string text) {
  std::erase_if(text, [](char c) { return c == ' ' || c == '\n'; });
  return text;
}

TextTable numbers(std::size_t columns) {
  std::vector<TextTable::Column> heads{{"name"}};
  for (std::size_t c = 0; c < columns; ++c) heads.push_back({"head " + std::to_string(c), right});
  TextTable table(heads);
  for (const char* name : {"short", "a name that is rather long, and goes on"}) {
    std::vector<std::string> cells{name};
    for (std::size_t c = 0; c < columns; ++c) cells.push_back(std::to_string(1000 * c) + ".5");
    table.add(cells);
  }
  return table;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_table_that_fits_is_one_block_with_its_columns_in_line) {
  TextTable table({{"node"}, {"steps", right}});
  table.add({"device", "4000"});
  table.add({"collision", "391"});
  BOOST_TEST(table.text(80) == "  node       steps\n  device      4000\n  collision    391\n");
}

BOOST_AUTO_TEST_CASE(every_width_holds_every_line) {
  for (std::size_t columns = 40; columns <= 160; ++columns) {
    BOOST_TEST(widest(numbers(9).text(columns)) <= columns);
  }
}

BOOST_AUTO_TEST_CASE(columns_that_find_no_room_stand_in_another_block_with_the_first_column_again) {
  const std::string text = numbers(9).text(60);
  BOOST_TEST(lines_of(numbers(9).text(200)).size() == 3U);
  BOOST_TEST(lines_of(text).size() > 6U);
  for (std::size_t c = 0; c < 9; ++c) {
    BOOST_TEST(text.find("head " + std::to_string(c)) != std::string::npos);
    BOOST_TEST(text.find(std::to_string(1000 * c) + ".5") != std::string::npos);
  }
  std::size_t names = 0;
  for (const std::string& line : lines_of(text)) names += line.starts_with("  short") ? 1 : 0;
  std::size_t blocks = 1;
  for (const std::string& line : lines_of(text)) blocks += line.empty() ? 1 : 0;
  BOOST_TEST(names == blocks);
}

BOOST_AUTO_TEST_CASE(a_text_is_broken_in_its_cell_and_loses_no_letter) {
  TextTable table({{""}, {""}});
  const std::string why = "the output force is read by nobody, and averylongwordthatfitsintonocellofthiswidthatall";
  table.add({"left.out", why});
  const std::string text = table.text(40);
  BOOST_TEST(widest(text) <= 40U);
  BOOST_TEST(without_spaces(text) == without_spaces("left.out" + why));
  for (const std::string& line : lines_of(text)) BOOST_TEST(!line.ends_with(' '));
}

BOOST_AUTO_TEST_CASE(a_word_stays_whole_where_the_longest_of_each_column_find_room) {
  TextTable table({{""}, {""}});
  table.add({"international", "a few short words that can be broken at many spaces"});
  table.add({"x", "y"});
  // Two columns to the left, two between.
  for (std::size_t columns = 4 + display_width("international") + display_width("broken"); columns <= 80; ++columns) {
    const std::string text = table.text(columns);
    for (const char* word : {"international", "short", "broken", "spaces"}) {
      BOOST_TEST(text.find(word) != std::string::npos, "at " << columns << " columns:\n" << text);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_letter_of_several_bytes_is_one_column) {
  BOOST_TEST(display_width("µm") == 2U);
  TextTable table({{"µ"}, {"x", right}});
  table.add({"µµ", "1"});
  BOOST_TEST(table.text(80) == "  µ   x\n  µµ  1\n");
}

BOOST_AUTO_TEST_CASE(prose_is_broken_at_spaces_two_columns_further_in) {
  BOOST_TEST(wrapped("  one two three four\n\nshort\n", 12) == "  one two\n    three\n    four\n\nshort\n");
}

BOOST_AUTO_TEST_CASE(a_path_stays_whole_though_it_is_wider) {
  const std::string path = "  report  /a/folder/with/a/long/name/report.html\n";
  BOOST_TEST(wrapped(path, 24) == "  report\n    /a/folder/with/a/long/name/report.html\n");
}

BOOST_AUTO_TEST_CASE(what_fits_stays_as_it_is_at_every_width) {
  const std::string text = "a b\n  c d e\n\n    f\n";
  for (std::size_t columns = 9; columns < 50; ++columns) BOOST_TEST(wrapped(text, columns) == text);
}

BOOST_AUTO_TEST_SUITE_END()
