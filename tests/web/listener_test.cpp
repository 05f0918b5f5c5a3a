// A listener that gets no descriptors waits and tells it once, and goes on when there are some.
#include "app/web/listener.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <boost/test/unit_test.hpp>
#include <chrono>
#include <list>
#include <vector>

BOOST_AUTO_TEST_SUITE(listener_test)

using namespace tactor;
using boost::asio::ip::tcp;

namespace {

/// Takes all descriptors that there are, until its end.
class NoDescriptors {
 public:
  NoDescriptors() {
    getrlimit(RLIMIT_NOFILE, &before_);
    rlimit few = before_;
    few.rlim_cur = 64;
    setrlimit(RLIMIT_NOFILE, &few);
    for (int file = 0; (file = ::open("/dev/null", O_RDONLY | O_CLOEXEC)) >= 0;) files_.push_back(file);
  }
  NoDescriptors(const NoDescriptors&) = delete;
  NoDescriptors& operator=(const NoDescriptors&) = delete;
  ~NoDescriptors() {
    for (const int file : files_) ::close(file);
    setrlimit(RLIMIT_NOFILE, &before_);
  }

 private:
  rlimit before_{};
  std::vector<int> files_;
};

}  // namespace

BOOST_AUTO_TEST_CASE(without_descriptors_it_tries_ten_times_a_second_and_no_more) {
  boost::asio::io_context io;
  Listener listener(io, 0, "the view", "--port");
  std::list<tcp::socket> taken;
  std::vector<std::string> notes;
  listener.start([&](tcp::socket socket) { taken.push_back(std::move(socket)); },
                 [&](const std::string& note) { notes.push_back(note); });
  // They connect while nobody takes them in: the system holds them.
  std::list<tcp::socket> clients;
  for (int i = 0; i < 5; ++i) {
    clients.emplace_back(io);
    clients.back().connect({boost::asio::ip::address_v4::loopback(), listener.port()});
  }
  {
    const NoDescriptors none;
    const auto begun = std::chrono::steady_clock::now();
    io.run_for(std::chrono::milliseconds(550));
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    BOOST_TEST(taken.empty());
    BOOST_TEST(listener.refused() >= 1U);
    // Whatever the machine does beside it, tries lie that far apart.
    BOOST_TEST(static_cast<double>(listener.refused()) <= seconds / 0.1 + 2);
    BOOST_TEST(notes.size() == 1U);
    if (!notes.empty()) BOOST_TEST(notes.front().find("the view cannot take a connection: ") == 0U);
  }
  while (taken.size() < clients.size() && io.run_one_for(std::chrono::seconds(20)) > 0) {
  }
  BOOST_TEST(taken.size() == clients.size());
  BOOST_TEST(notes.size() == 1U);
  listener.close();
  io.run_for(std::chrono::seconds(20));
  BOOST_TEST(io.stopped());
}

BOOST_AUTO_TEST_SUITE_END()
