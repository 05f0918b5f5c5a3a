// The bytes of chunks, frames and meshes are those that the protocol tells.
#include "app/view/samples.hpp"

#include <boost/test/unit_test.hpp>
#include <cstring>
#include <vector>

BOOST_AUTO_TEST_SUITE(samples_test)

using namespace tactor;

namespace {

template <class T>
T at(const std::string& bytes, std::size_t offset) {
  T value;
  BOOST_REQUIRE(offset + sizeof value <= bytes.size());
  BOOST_REQUIRE(offset % sizeof value == 0);
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_chunk_holds_rows_and_sets_at_multiples_of_eight_bytes) {
  ChunkWriter writer;
  BOOST_TEST(writer.empty());
  const std::vector<double> times{1.5, 1.501};
  const std::vector<float> rows{1, 2, 3, 4, 5, 6};
  writer.add_rows(7, times, rows);
  const std::vector<float> set{9, 8, 7};
  writer.add_set(2, 1.25, 1, set);
  writer.add_set(3, 1.75, 0, {});
  const std::string chunk = writer.take(1.501);
  BOOST_TEST(writer.empty());
  BOOST_TEST(chunk.size() % 8 == 0U);
  BOOST_TEST(at<std::uint32_t>(chunk, 0) == chunk.size());
  BOOST_TEST(at<std::uint32_t>(chunk, 4) == 3U);
  BOOST_TEST(at<double>(chunk, 8) == 1.501);
  // Rows.
  BOOST_TEST(at<std::uint16_t>(chunk, 16) == 0);
  BOOST_TEST(at<std::uint16_t>(chunk, 18) == 7);
  BOOST_TEST(at<std::uint32_t>(chunk, 20) == 2U);
  BOOST_TEST(at<double>(chunk, 32) == 1.501);
  BOOST_TEST(at<float>(chunk, 40 + 20) == 6.0F);
  // A set of one row of three columns, with four bytes behind it.
  BOOST_TEST(at<std::uint16_t>(chunk, 64) == 1);
  BOOST_TEST(at<std::uint16_t>(chunk, 66) == 2);
  BOOST_TEST(at<std::uint32_t>(chunk, 68) == 1U);
  BOOST_TEST(at<double>(chunk, 72) == 1.25);
  BOOST_TEST(at<float>(chunk, 88) == 7.0F);
  // An empty set.
  BOOST_TEST(at<std::uint32_t>(chunk, 96 + 4) == 0U);
  BOOST_TEST(at<double>(chunk, 104) == 1.75);
  BOOST_TEST(chunk.size() == 112U);
}

BOOST_AUTO_TEST_CASE(a_frame_begins_with_its_kind_its_chunks_and_its_number) {
  const std::string header = frame_header(3, 1234567890123);
  BOOST_TEST(header.size() == 16U);
  BOOST_TEST(at<std::uint32_t>(header, 0) == 1U);
  BOOST_TEST(at<std::uint32_t>(header, 4) == 3U);
  BOOST_TEST(at<std::uint64_t>(header, 8) == 1234567890123U);
}

BOOST_AUTO_TEST_CASE(a_mesh_holds_positions_and_then_indices) {
  const std::vector<float> positions{0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::vector<std::uint32_t> indices{0, 1, 2};
  const std::string mesh = mesh_message(5, positions, indices);
  BOOST_TEST(at<std::uint32_t>(mesh, 0) == 2U);
  BOOST_TEST(at<std::uint32_t>(mesh, 4) == 5U);
  BOOST_TEST(at<std::uint32_t>(mesh, 8) == 3U);
  BOOST_TEST(at<std::uint32_t>(mesh, 12) == 1U);
  BOOST_TEST(at<float>(mesh, 16 + 12) == 1.0F);
  BOOST_TEST(at<std::uint32_t>(mesh, 52 + 8) == 2U);
  BOOST_TEST(mesh.size() == 64U);
}

BOOST_AUTO_TEST_CASE(sections_and_chunks_are_read_as_they_were_written) {
  ChunkWriter writer;
  writer.add_rows(1, std::vector<double>{0.5, 0.75, 1}, std::vector<float>{1, 2, 3});
  writer.add_set(0, 1.25, 2, std::vector<float>{4, 5, 6, 7, 8, 9});
  writer.add_set(0, 1.5, 0, {});
  const std::string first = writer.take(1.5);
  writer.add_rows(1, std::vector<double>{2}, std::vector<float>{10});
  const std::string second = writer.take(2);
  std::vector<std::string> chunks;
  for_each_chunk(frame_header(2, 1) + first + second, [&](std::string_view chunk) { chunks.emplace_back(chunk); });
  BOOST_TEST(chunks == (std::vector<std::string>{first, second}));
  BOOST_TEST(chunk_end(first) == 1.5);

  const std::vector<std::size_t> columns{3, 1};
  std::vector<ChunkSection> sections;
  for_each_section(first, columns, [&](const ChunkSection& section) { sections.push_back(section); });
  BOOST_REQUIRE(sections.size() == 3U);
  BOOST_TEST((!sections[0].is_set && sections[0].stream == 1U));
  BOOST_TEST(sections[0].times == (std::vector<double>{0.5, 0.75, 1}));
  BOOST_TEST(sections[0].values == (std::vector<float>{1, 2, 3}));
  BOOST_TEST((sections[1].is_set && sections[1].stream == 0U));
  BOOST_TEST(sections[1].times == std::vector<double>{1.25});
  BOOST_TEST(sections[1].values == (std::vector<float>{4, 5, 6, 7, 8, 9}));
  BOOST_TEST((sections[2].is_set && sections[2].times == std::vector<double>{1.5} && sections[2].values.empty()));
}

BOOST_AUTO_TEST_SUITE_END()
