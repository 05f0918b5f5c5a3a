// Message types as data: they describe the struct, go through JSON, and tell one layout from another.
#include <algorithm>
#include <atomic>
#include <boost/test/unit_test.hpp>
#include <cstddef>
#include <string>
#include <thread>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/core/message_json.hpp"
#include "framework/core/messages.hpp"
#include "tests/scan_nodes/scan.hpp"

BOOST_AUTO_TEST_SUITE(message_test)

using namespace tactor;

namespace {

const Field& field(const std::vector<Field>& fields, const std::string& name) {
  const auto found = std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.name == name; });
  BOOST_REQUIRE((found != fields.end()));
  return *found;
}

/// One that comes back as long as others hold arrays.
std::size_t free_arrays(ArrayPool<int>& pool) {
  std::vector<SharedArray<int>> all;
  while (auto one = pool.make(1, [](auto) {})) all.push_back(*one);
  return all.size();
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_description_has_the_offsets_of_the_struct) {
  const MessageType& type = message_type<Scan>();
  BOOST_TEST(type.size == sizeof(Scan));
  BOOST_TEST(type.alignment == alignof(Scan));
  BOOST_TEST(field(type.fields, "quality").offset == offsetof(Scan, quality));
  BOOST_TEST(field(type.fields, "begin").offset == offsetof(Scan, begin));
  BOOST_TEST(field(type.fields, "bounds").offset == offsetof(Scan, bounds));
  BOOST_TEST(field(type.fields, "last").offset == offsetof(Scan, last));
  const Field& points = field(type.fields, "points");
  BOOST_TEST(points.changes_size);
  BOOST_TEST(element_size(points) == sizeof(ScanPoint));
  BOOST_TEST(field(points.fields, "brightness").offset == offsetof(ScanPoint, brightness));
  const Field& heads = field(type.fields, "heads");
  BOOST_TEST(element_size(heads) == sizeof(ScanHead));
  const std::vector<std::size_t> arrays{offsetof(Scan, points), offsetof(Scan, heads) + offsetof(ScanHead, warmth),
                                        offsetof(Scan, heads) + sizeof(ScanHead) + offsetof(ScanHead, warmth)};
  BOOST_TEST(type.arrays == arrays, boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(a_description_goes_through_json_and_comes_back_equal) {
  for (const MessageType* type :
       {&message_type<Scan>(), &message_type<Wrench>(), &message_type<ContactSet>(), &message_type<SafetyState>()}) {
    const MessageType again = message_type_from_json(to_json(*type));
    BOOST_TEST(again.name == type->name);
    BOOST_TEST(again.frame == type->frame);
    BOOST_TEST(to_json(again) == to_json(*type));
    BOOST_TEST(again.size == type->size);
    BOOST_TEST(again.alignment == type->alignment);
    BOOST_TEST(again.layout_hash == type->layout_hash);
    BOOST_TEST((again.arrays == type->arrays));
    BOOST_TEST(same_type(again, *type));
  }
}

BOOST_AUTO_TEST_CASE(any_change_of_a_description_changes_its_hash) {
  const MessageType& type = message_type<Scan>();
  const auto differs = [&](const auto& change) {
    MessageType other = type;
    change(other);
    lay_out(other);
    return other.layout_hash != type.layout_hash && !same_type(other, type);
  };
  BOOST_TEST(differs([](MessageType& t) { t.fields[0].name = "turns"; }));
  BOOST_TEST(differs([](MessageType& t) { t.fields[0].kind = FieldKind::i8; }));
  BOOST_TEST(differs([](MessageType& t) { t.fields[0].unit = "m"; }));
  BOOST_TEST(differs([](MessageType& t) { t.fields[1].enumerators[1].value = 8; }));
  BOOST_TEST(differs([](MessageType& t) { t.fields[3].fields[0].frame = "T"; }));
  BOOST_TEST(differs([](MessageType& t) { std::swap(t.fields[0], t.fields[6]); }));
  BOOST_TEST(differs([](MessageType& t) { t.fields[4].shape = {2, 3}; }));
  BOOST_TEST(differs([](MessageType& t) { t.frame = "W"; }));
  BOOST_TEST(!differs([](MessageType&) {}));
}

BOOST_AUTO_TEST_CASE(a_doc_changes_neither_the_type_nor_what_recordings_keep) {
  const MessageType& type = message_type<Scan>();
  MessageType other = type;
  other.doc = "Another sentence.";
  other.fields[1].doc = "Another one.";
  other.fields[1].enumerators[0].doc = "A third.";
  other.fields[3].fields[0].doc.clear();
  lay_out(other);
  BOOST_TEST(other.layout_hash == type.layout_hash);
  BOOST_TEST(same_type(other, type));
  BOOST_TEST(&keep_message_type(other) == &keep_message_type(type));
  BOOST_TEST(to_json(other) == to_json(type));
  BOOST_TEST(to_json(type).find("doc") == std::string::npos);
}

BOOST_AUTO_TEST_CASE(a_documented_description_has_every_sentence_and_is_read_as_the_same_type) {
  const MessageType& type = message_type<Scan>();
  const std::string text = to_documented_json(type);
  BOOST_TEST(text.find(R"("doc":"One turn of a scanner.")") != std::string::npos);
  BOOST_TEST(text.find(R"("doc":"How far the turn can be trusted.","docs":{"dusty":"Some points are missing."})") !=
             std::string::npos);
  BOOST_TEST(text.find(R"("doc":"Position, measured from the scanner.")") != std::string::npos);
  const MessageType again = message_type_from_json(text);
  BOOST_TEST(same_type(again, type));
  BOOST_TEST(again.doc.empty());
  MessageType latin = type;
  latin.doc =
      "Gr\xf6\xdf"
      "e.";
  BOOST_TEST(same_type(message_type_from_json(to_documented_json(latin)), type));
}

BOOST_AUTO_TEST_CASE(a_record_without_a_doc_gets_that_of_its_type) {
  BOOST_TEST(field(message_type<Scan>().fields, "points").doc == "A point that a scanner saw.");
  BOOST_TEST(field(message_type<PhysicsState>().fields, "p_WT").doc != field(message_type<Pose>().fields, "p").doc);
}

BOOST_AUTO_TEST_CASE(a_broken_description_is_refused_with_its_place) {
  const auto refusal = [](const std::string& text) {
    try {
      static_cast<void>(message_type_from_json(text));
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  const auto of = [](const std::string& one) {
    return R"({"name": "my.Thing", "frame": "W", "fields": [)" + one + "]}";
  };
  BOOST_TEST(refusal("") == "the description of a message type is not a JSON object");
  BOOST_TEST(refusal("[1]") == "the description of a message type is not a JSON object");
  BOOST_TEST(refusal(R"({"name": 3})").find("name is missing or no text") != std::string::npos);
  BOOST_TEST(refusal(of("")).find("my.Thing: fields is missing or no list") != std::string::npos);
  const std::string a = R"({"name": "a", "unit": "m", "kind": "f64"})";
  BOOST_TEST(refusal(of(a)) == "taken");
  BOOST_TEST(refusal(of(a + "," + a)).find("two fields are called a") != std::string::npos);
  BOOST_TEST(refusal(of(R"({"name": "a/b", "unit": "m", "kind": "f64"})")).find("a/b") != std::string::npos);
  BOOST_TEST(refusal(of(R"({"name": "a", "unit": "m", "kind": "f16"})")).find("my.Thing.a: there is no kind \"f16\"") !=
             std::string::npos);
  for (const char* shape : {"[]", "[0]", "[-1]", "[1.5]", "[4000000000]", "[100000, 100000]", "3"}) {
    const std::string text = of(R"({"name": "a", "unit": "m", "kind": "f64", "shape": )" + std::string(shape) + "}");
    BOOST_TEST(refusal(text).find("my.Thing.a") != std::string::npos, shape);
  }
  BOOST_TEST(refusal(of(R"({"name": "a", "unit": "m", "kind": "f64", "shape": [3000000]})")).find("larger than") !=
             std::string::npos);
  BOOST_TEST(
      refusal(of(R"({"name": "a", "unit": "1", "kind": "f64", "enumerators": {"x": 1}})")).find("whole numbers") !=
      std::string::npos);
  BOOST_TEST(
      refusal(of(R"({"name": "a", "unit": "1", "kind": "i32", "enumerators": {"x": 1, "y": 1}})")).find("\"y\"") !=
      std::string::npos);
  const std::string inner = R"({"name": "b", "unit": "m", "kind": "f64", "changes_size": true})";
  BOOST_TEST(
      refusal(of(R"({"name": "a", "unit": "1", "kind": "record", "record": "R", "changes_size": true, "fields": [)" +
                 inner + "]}"))
          .find("in another one") != std::string::npos);
  std::string deep = a;
  for (int i = 0; i < 20; ++i) {
    deep = R"({"name": "a", "unit": "1", "kind": "record", "record": "R", "fields": [)" + deep + "]}";
  }
  BOOST_TEST(refusal(of(deep)).find("too deeply") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(a_pool_gives_out_what_it_has_and_takes_back_what_nobody_holds) {
  ArrayPool<int> pool(3, 4);
  BOOST_TEST(free_arrays(pool) == 3U);
  const std::vector<int> numbers{1, 2, 3};
  auto one = pool.copy(numbers);
  BOOST_REQUIRE(one.has_value());
  BOOST_TEST(*one == numbers, boost::test_tools::per_element());
  BOOST_TEST(free_arrays(pool) == 2U);
  SharedArray<int> copy = *one;
  one.reset();
  BOOST_TEST(free_arrays(pool) == 2U);
  BOOST_TEST(copy == numbers, boost::test_tools::per_element());
  copy = SharedArray<int>();
  BOOST_TEST(free_arrays(pool) == 3U);
}

BOOST_AUTO_TEST_CASE(arrays_outlive_their_pool) {
  SharedArray<int> kept;
  {
    ArrayPool<int> pool(2, 4);
    kept = pool.copy(std::vector<int>{5, 6}).value();
  }
  BOOST_TEST(kept.size() == 2U);
  BOOST_TEST(kept[1] == 6);
}

BOOST_AUTO_TEST_CASE(threads_share_a_pool_and_no_array_is_given_out_twice) {
  ArrayPool<int> pool(8, 16);
  std::atomic<int> torn{0};
  const auto work = [&](int me) {
    std::vector<SharedArray<int>> held;
    for (int i = 0; i < 20000; ++i) {
      if (auto array = pool.make(16, [&](std::span<int> to) { std::fill(to.begin(), to.end(), 100000 * me + i); })) {
        held.push_back(*array);
      }
      if (held.size() > 3 || i % 7 == 0) held.clear();
      for (const SharedArray<int>& array : held) {
        if (!std::all_of(array.begin(), array.end(), [&](int n) { return n == array[0] && n / 100000 == me; })) ++torn;
      }
    }
  };
  std::vector<std::thread> threads;
  for (int me = 1; me <= 4; ++me) threads.emplace_back(work, me);
  for (std::thread& thread : threads) thread.join();
  BOOST_TEST(torn == 0);
  BOOST_TEST(free_arrays(pool) == 8U);
}

BOOST_AUTO_TEST_SUITE_END()
