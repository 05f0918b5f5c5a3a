// Every field of every message type there is has a doc: sentences that say more than its name.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cctype>
#include <set>
#include <string>
#include <vector>

#include "framework/engine/run_events.hpp"
#include "framework/node/registry.hpp"

BOOST_AUTO_TEST_SUITE(message_docs_test)

using namespace tactor;

namespace {

/// The words of a text in lower case, without articles and the like.
std::set<std::string> words_of(const std::string& text) {
  const std::set<std::string> empty{"a", "an", "the", "of", "its", "is", "this"};
  std::set<std::string> words;
  std::string word;
  for (const char c : text + " ") {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    } else if (!word.empty()) {
      if (!empty.contains(word)) words.insert(word);
      word.clear();
    }
  }
  return words;
}

/// Empty, or what is wrong with the doc of that name.
std::string wrong_with(const std::string& doc, const std::string& name) {
  if (doc.empty()) return "it has no doc";
  if (!doc.ends_with(".")) return "its doc ends without a full stop";
  if (doc.starts_with(" ") || doc.find("  ") != std::string::npos) return "its doc has a space too many";
  if (doc.find('\n') != std::string::npos) return "its doc is more than a line";
  if (std::isupper(static_cast<unsigned char>(doc[0])) == 0 && doc[0] != '`' && doc[0] != '1') {
    return "its doc begins without a capital";
  }
  const std::set<std::string> said = words_of(doc), named = words_of(name);
  const bool repeats = std::includes(named.begin(), named.end(), said.begin(), said.end());
  return repeats ? "its doc repeats its name" : "";
}

void check_fields(const std::vector<Field>& fields, const std::string& where) {
  for (const Field& field : fields) {
    const std::string path = where + "." + field.name;
    BOOST_TEST(wrong_with(field.doc, field.name) == "", path);
    for (const Enumerator& one : field.enumerators) {
      if (!one.doc.empty()) BOOST_TEST(wrong_with(one.doc, one.name) == "", path << "." << one.name);
    }
    check_fields(field.fields, path);
  }
}

void check_type(const MessageType& type) {
  BOOST_TEST(wrong_with(type.doc, type.name) == "", type.name);
  // Each type that travels says what its stamp is.
  BOOST_TEST(type.doc.find("tamp") != std::string::npos, type.name);
  check_fields(type.fields, type.name);
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_field_of_every_shipped_message_type_says_what_it_means) {
  Registry registry{{TACTOR_NODE_FOLDER}};
  registry.load_all();
  std::size_t types = 0;
  for (const auto& [name, type] : registry.message_types()) {
    if (type == &any_message()) continue;
    check_type(*type);
    ++types;
  }
  BOOST_TEST(types > 15U);
}

BOOST_AUTO_TEST_CASE(so_do_the_events_of_a_run) {
  check_type(message_type<StepEvent>());
  check_type(message_type<TickEvent>());
  check_type(message_type<StopEvent>());
  check_type(message_type<SetEvent>());
}

BOOST_AUTO_TEST_CASE(a_doc_that_says_nothing_is_found) {
  BOOST_TEST(wrong_with("", "count") == "it has no doc");
  BOOST_TEST(wrong_with("Entries in use", "count") == "its doc ends without a full stop");
  BOOST_TEST(wrong_with("The peak of the second.", "peak_second") == "its doc repeats its name");
  BOOST_TEST(wrong_with("entries in use.", "count") == "its doc begins without a capital");
  BOOST_TEST(wrong_with("Entries in use.", "count") == "");
}

BOOST_AUTO_TEST_SUITE_END()
