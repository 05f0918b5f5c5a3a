// Fields of reports: bytes as the standards lay them, limits, wrap-around, and a million random reports.
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>

#include "devices/usb/report_layout.hpp"

BOOST_AUTO_TEST_SUITE(report_layout_test)

using namespace tactor;

namespace {

ReportField field(FieldType type, ByteOrder order, std::size_t at = 0) {
  return {"x", at, type, order};
}

}  // namespace

BOOST_AUTO_TEST_CASE(numbers_are_read_as_their_types_lay_them) {
  const std::vector<std::uint8_t> bytes{0xff, 0xfe, 0x01, 0x80, 0x00, 0x00, 0xc0, 0x3f};
  BOOST_TEST(field(FieldType::u8, ByteOrder::little).read(bytes) == 255);
  BOOST_TEST(field(FieldType::i8, ByteOrder::little).read(bytes) == -1);
  BOOST_TEST(field(FieldType::i16, ByteOrder::little).read(bytes) == -257);  // 0xfeff
  BOOST_TEST(field(FieldType::i16, ByteOrder::big).read(bytes) == -2);       // 0xfffe
  BOOST_TEST(field(FieldType::u16, ByteOrder::little).read(bytes) == 65279);
  BOOST_TEST(field(FieldType::i32, ByteOrder::little).read(bytes) == -2147352833.0);  // 0x8001feff
  BOOST_TEST(field(FieldType::u32, ByteOrder::big).read(bytes) == 4294836608.0);      // 0xfffe0180
  BOOST_TEST(field(FieldType::f32, ByteOrder::little, 4).read(bytes) == 1.5);         // 0x3fc00000
}

BOOST_AUTO_TEST_CASE(what_does_not_fit_is_cut_and_what_is_no_number_is_zero) {
  std::vector<std::uint8_t> bytes(4, 0x55);
  const ReportField f = field(FieldType::i16, ByteOrder::little, 1);
  f.write(bytes, 1e9);
  BOOST_TEST(f.read(bytes) == 32767);
  f.write(bytes, -1e9);
  BOOST_TEST(f.read(bytes) == -32768);
  f.write(bytes, std::numeric_limits<double>::quiet_NaN());
  BOOST_TEST(f.read(bytes) == 0);
  f.write(bytes, std::numeric_limits<double>::infinity());
  BOOST_TEST(f.read(bytes) == 0);
  BOOST_TEST(bytes[0] == 0x55);
  BOOST_TEST(bytes[3] == 0x55);
}

BOOST_AUTO_TEST_CASE(efforts_are_scaled_and_never_beyond_their_limit) {
  OutputLayout layout;
  layout.size = 6;
  layout.fields = {field(FieldType::i16, ByteOrder::little, 0), field(FieldType::i16, ByteOrder::little, 2),
                   field(FieldType::i16, ByteOrder::little, 4)};
  layout.axes = {{0, -1000, 2000}, {1, 500, 2000}};
  layout.fixed = {{2, 7}};
  std::vector<std::uint8_t> report(6);
  write_efforts(layout, std::vector<double>{0.25, 100}, report);
  BOOST_TEST(layout.fields[0].read(report) == -250);
  BOOST_TEST(layout.fields[1].read(report) == 2000);
  BOOST_TEST(layout.fields[2].read(report) == 7);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  write_efforts(layout, std::vector<double>{nan, -std::numeric_limits<double>::infinity()}, report);
  BOOST_TEST(layout.fields[0].read(report) == 0);
  BOOST_TEST(layout.fields[1].read(report) == 0);
}

BOOST_AUTO_TEST_CASE(a_counter_that_begins_anew_goes_on) {
  BOOST_TEST(count_from(32760, -32766, 65536) == 10);
  BOOST_TEST(count_from(-32766, 32760, 65536) == -10);
  BOOST_TEST(count_from(-5, 7, 65536) == 12);
  BOOST_TEST(count_from(1e9, -1e9, 0) == -2e9);
}

BOOST_AUTO_TEST_CASE(flags_are_bits_or_values_above_a_bound) {
  const std::vector<ReportField> fields{field(FieldType::u16, ByteOrder::big),
                                        field(FieldType::i16, ByteOrder::little)};
  const std::vector<std::uint8_t> report{0x80, 0x01};
  BOOST_TEST((Flag{0, 15}).is_set(fields, report));
  BOOST_TEST((Flag{0, 0}).is_set(fields, report));
  BOOST_TEST(!(Flag{0, 7}).is_set(fields, report));
  BOOST_TEST(!(Flag{1, -1, 5000}).is_set(fields, report));  // 0x0180 = 384
  BOOST_TEST((Flag{1, -1, 383}).is_set(fields, report));
}

BOOST_AUTO_TEST_CASE(a_million_random_reports_read_within_the_bounds_of_their_types) {
  boost::random::mt19937_64 random(7);
  boost::random::uniform_int_distribution<int> byte(0, 255), type(0, 6), order(0, 1), at(0, 12);
  std::vector<std::uint8_t> report(16), again(16);
  for (int i = 0; i < 1'000'000; ++i) {
    for (auto& b : report) b = static_cast<std::uint8_t>(byte(random));
    const ReportField f = field(static_cast<FieldType>(type(random)), static_cast<ByteOrder>(order(random)),
                                static_cast<std::size_t>(at(random)));
    const double value = f.read(report);
    if (!std::isfinite(value)) {
      BOOST_TEST_REQUIRE(!f.is_whole());
      continue;
    }
    BOOST_TEST_REQUIRE(value >= f.least());
    BOOST_TEST_REQUIRE(value <= f.most());
    f.write(again, value);
    BOOST_TEST_REQUIRE(f.read(again) == value);
  }
}

BOOST_AUTO_TEST_SUITE_END()
