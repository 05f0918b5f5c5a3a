// Every way to the heap is counted, on the thread that takes it, whichever library it is taken in.
#include "framework/realtime/allocation_watch.hpp"

#include <dlfcn.h>
#include <malloc.h>

#include <array>
#include <boost/test/unit_test.hpp>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <thread>

#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(allocation_watch_test)

using namespace tactor;
namespace utf = boost::unit_test;

namespace {

/// What `work` adds to the count of this thread.
template <class Work>
std::int64_t calls_of(Work&& work) {
  const std::int64_t before = thread_heap_calls();
  work();
  return thread_heap_calls() - before;
}

/// Keeps the compiler from leaving out a block that nobody looks at.
void* seen(void* block) {
  void* volatile kept = block;
  return kept;
}

struct alignas(256) Wide {
  double value = 0;
};

}  // namespace

BOOST_AUTO_TEST_CASE(it_is_available_unless_a_sanitizer_is_in_the_way) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  BOOST_TEST(!heap_calls_are_counted());
  BOOST_TEST(thread_heap_calls() == 0);
#else
  BOOST_TEST(heap_calls_are_counted());
#endif
}

BOOST_AUTO_TEST_CASE(each_function_of_the_c_heap_counts_once, *utf::precondition(test::heap_is_counted)) {
  void* block = nullptr;
  BOOST_TEST(calls_of([&] { block = seen(std::malloc(8)); }) == 1);
  BOOST_TEST(calls_of([&] { block = seen(std::realloc(block, 4096)); }) == 1);
  BOOST_TEST(calls_of([&] { block = seen(reallocarray(block, 100, 80)); }) == 1);
  BOOST_TEST(calls_of([&] { std::free(block); }) == 1);
  BOOST_TEST(calls_of([&] { block = seen(std::calloc(10, 10)); }) == 1);
  std::free(block);
  BOOST_TEST(calls_of([&] { block = seen(std::aligned_alloc(64, 128)); }) == 1);
  BOOST_TEST(reinterpret_cast<std::uintptr_t>(block) % 64 == 0U);
  std::free(block);
  BOOST_TEST(calls_of([&] { block = seen(memalign(512, 100)); }) == 1);
  BOOST_TEST(reinterpret_cast<std::uintptr_t>(block) % 512 == 0U);
  std::free(block);
  BOOST_TEST(calls_of([&] { BOOST_REQUIRE(posix_memalign(&block, 1024, 100) == 0); }) >= 1);
  BOOST_TEST(reinterpret_cast<std::uintptr_t>(block) % 1024 == 0U);
  std::free(block);
}

BOOST_AUTO_TEST_CASE(freeing_nothing_is_no_call, *utf::precondition(test::heap_is_counted)) {
  void* volatile nothing = nullptr;
  BOOST_TEST(calls_of([&] { std::free(nothing); }) == 0);
}

BOOST_AUTO_TEST_CASE(the_heap_keeps_its_promises, *utf::precondition(test::heap_is_counted)) {
  void* block = nullptr;
  BOOST_TEST(posix_memalign(&block, 3, 100) == EINVAL);
  BOOST_TEST(posix_memalign(&block, 4, 100) == EINVAL);
  volatile std::size_t huge = std::numeric_limits<std::size_t>::max() / 2;
  errno = 0;
  BOOST_TEST(reallocarray(nullptr, huge, 4) == nullptr);
  BOOST_TEST(errno == ENOMEM);
  BOOST_CHECK_THROW(seen(::operator new(huge)), std::bad_alloc);
}

BOOST_AUTO_TEST_CASE(operator_new_and_delete_are_counted, *utf::precondition(test::heap_is_counted)) {
  BOOST_TEST(calls_of([] { delete static_cast<int*>(seen(new int(7))); }) == 2);
  BOOST_TEST(calls_of([] { delete static_cast<Wide*>(seen(new Wide)); }) == 2);
  BOOST_TEST(calls_of([] { static_cast<void>(seen(std::make_shared<std::string>(100, 'x').get())); }) == 4);
  const std::array<int, 64> large{};
  BOOST_TEST(calls_of([&] { std::function<int()>([large] { return large[3]; })(); }) == 2);
}

BOOST_AUTO_TEST_CASE(what_uses_no_heap_counts_nothing, *utf::precondition(test::heap_is_counted)) {
  BOOST_TEST(calls_of([] {
               const std::string small = "short";
               static_cast<void>(seen(const_cast<char*>(small.data())));
             }) == 0);
}

BOOST_AUTO_TEST_CASE(the_calls_of_a_library_loaded_while_running_are_counted,
                     *utf::precondition(test::heap_is_counted)) {
  void* module = dlopen(ALLOCATING_MODULE, RTLD_NOW | RTLD_LOCAL);
  BOOST_REQUIRE_MESSAGE(module != nullptr, dlerror());
  for (const char* name : {"use_malloc", "use_vector", "use_strdup"}) {
    auto* function = reinterpret_cast<void (*)()>(dlsym(module, name));
    BOOST_REQUIRE(function != nullptr);
    BOOST_TEST(calls_of(function) == 2, name);
  }
  dlclose(module);
}

BOOST_AUTO_TEST_CASE(each_thread_has_a_count_of_its_own, *utf::precondition(test::heap_is_counted)) {
  std::int64_t theirs = 0;
  std::thread other;
  const auto busy = [&] {
    theirs = calls_of([] {
      for (int i = 0; i < 1000; ++i) delete static_cast<int*>(seen(new int(i)));
    });
  };
  const std::int64_t ours = calls_of([&] {
    other = std::thread(busy);
    other.join();
  });
  BOOST_TEST(theirs == 2000);
  // Making the thread takes some calls here; those of the thread are not among them.
  BOOST_TEST(ours < 100);
}

BOOST_AUTO_TEST_SUITE_END()
