#include "framework/core/processor_dependence.hpp"

#include <mutex>
#include <set>

namespace tactor {

namespace {

struct Noted {
  std::mutex mutex;
  std::set<std::string> texts;
};

Noted& noted() {
  static Noted all;
  return all;
}

}  // namespace

void note_processor_dependence(const std::string& what) {
  const std::lock_guard lock(noted().mutex);
  noted().texts.insert(what);
}

std::vector<std::string> processor_dependence() {
  const std::lock_guard lock(noted().mutex);
  return {noted().texts.begin(), noted().texts.end()};
}

}  // namespace tactor
