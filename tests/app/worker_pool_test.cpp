// What becomes of jobs whose workers crash, hang, are killed or told to end, and of the jobs beside them.
#include "app/study/run/worker_pool.hpp"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <boost/test/unit_test.hpp>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "framework/core/check.hpp"

BOOST_AUTO_TEST_SUITE(worker_pool_test)

using namespace tactor;

namespace {

/// Jobs 0, 1, ... that are handed over as their numbers and answered with a letter in front, by a pool that notes what
/// became of each.
class Jobs {
 public:
  explicit Jobs(std::function<void(int job, const PoolLink& pool)> work)
      : work_(std::move(work)),
        pool(
            [this](const std::string& job, const PoolLink& link) {
              const rlimit no_core{0, 0};
              setrlimit(RLIMIT_CORE, &no_core);
              for (const int number : {SIGSEGV, SIGABRT}) std::signal(number, SIG_DFL);  // not the test program's
              work_(std::stoi(job), link);
              return "a" + job + " " + std::to_string(getpid());
            },
            [this] { return interruptions; }) {}

  bool run(std::size_t jobs, unsigned at_once) {
    JobBatch batch;
    batch.jobs = jobs;
    batch.at_once = at_once;
    batch.time_limit_s = time_limit_s;
    batch.job = [](std::size_t job) { return std::to_string(job); };
    batch.done = [this](std::size_t job, const std::string& answer) {
      const std::size_t space = answer.find(' ');
      BOOST_TEST(answer.substr(0, space) == "a" + std::to_string(job));
      done.insert(job);
      processes.insert(std::stoi(answer.substr(space)));
      if (on_done) on_done();
      return !stops_after_first;
    };
    batch.lost = [this](std::size_t job, const Ending& ending) { lost.emplace(job, ending); };
    batch.note = [this](const std::string& note) {
      notes.push_back(note);
      if (on_note) on_note(note);
    };
    return pool.run(batch);
  }

 private:
  std::function<void(int job, const PoolLink& pool)> work_;

 public:
  std::set<std::size_t> done;
  std::map<std::size_t, Ending> lost;
  std::vector<std::string> notes;
  std::set<int> processes;
  int interruptions = 0;
  bool stops_after_first = false;
  std::optional<double> time_limit_s;
  std::function<void()> on_done;
  std::function<void(const std::string& note)> on_note;
  WorkerPool pool;
};

using Numbers = std::set<std::size_t>;

}  // namespace

BOOST_AUTO_TEST_CASE(every_job_is_done_once_by_no_more_workers_than_asked_for) {
  Jobs jobs([](int, const PoolLink&) {});
  BOOST_TEST(jobs.run(20, 3));
  BOOST_TEST(jobs.done.size() == 20U);
  BOOST_TEST(jobs.processes.size() <= 3U);
  BOOST_TEST(!jobs.processes.contains(getpid()));
  // The same workers take the next batch.
  const std::set<int> before = jobs.processes;
  BOOST_TEST(jobs.run(5, 2));
  BOOST_TEST((jobs.processes == before));
  BOOST_TEST(jobs.run(0, 2));
}

BOOST_AUTO_TEST_CASE(what_ends_a_worker_costs_its_job_alone) {
  for (const unsigned at_once : {1U, 4U}) {
    Jobs jobs([](int job, const PoolLink&) {
      if (job == 1) raise(SIGKILL);
      if (job == 2) std::abort();
      if (job == 4) _exit(3);
      if (job == 5) throw std::runtime_error("nobody catches this");
      if (job == 7) raise(SIGSEGV);
    });
    BOOST_TEST(jobs.run(9, at_once));
    BOOST_TEST((jobs.done == Numbers{0, 3, 6, 8}));
    BOOST_REQUIRE(jobs.lost.size() == 5U);
    BOOST_TEST(jobs.lost.at(1).text == "killed (SIGKILL), perhaps for lack of memory");
    BOOST_TEST(jobs.lost.at(1).may_differ);
    BOOST_TEST(jobs.lost.at(2).text == "ended by SIGABRT");
    BOOST_TEST(!jobs.lost.at(2).may_differ);
    BOOST_TEST(jobs.lost.at(4).text == "ended with exit code 3");
    BOOST_TEST(jobs.lost.at(5).text == "ended by SIGABRT");
    BOOST_TEST(jobs.lost.at(7).text == "ended by SIGSEGV");
    // Some ended a worker that had done others before, and were tried once more.
    BOOST_TEST(jobs.pool.lost() >= 5U);
    BOOST_TEST(jobs.pool.lost() <= 9U);
  }
}

BOOST_AUTO_TEST_CASE(what_an_earlier_job_broke_is_done_by_a_new_worker) {
  bool broken = false;  // of each worker its own
  Jobs jobs([&broken](int job, const PoolLink&) {
    if (job == 3 && broken) std::abort();
    broken = true;
  });
  BOOST_TEST(jobs.run(6, 1));
  BOOST_TEST(jobs.done.size() == 6U);
  BOOST_TEST(jobs.lost.empty());
  BOOST_TEST(jobs.processes.size() == 2U);
  BOOST_TEST(jobs.pool.lost() == 1U);
}

BOOST_AUTO_TEST_CASE(a_worker_that_is_killed_between_two_jobs_costs_none) {
  Jobs jobs([](int, const PoolLink&) {});
  BOOST_TEST(jobs.run(1, 1));
  kill(*jobs.processes.begin(), SIGKILL);
  siginfo_t info{};
  waitid(P_PID, static_cast<id_t>(*jobs.processes.begin()), &info, WEXITED | WNOWAIT);
  BOOST_TEST(jobs.run(3, 1));
  BOOST_TEST(jobs.done.size() == 3U);
  BOOST_TEST(jobs.lost.empty());
}

BOOST_AUTO_TEST_CASE(a_job_over_the_time_limit_is_killed_and_its_neighbours_are_not) {
  Jobs jobs([](int job, const PoolLink& pool) {
    if (job == 0) usleep(1'500'000);  // its clock never began
    pool.begin_clock();
    while (job == 2) pause();
    for (int repeat = 0; job == 3 && repeat < 3; ++repeat) {
      pool.begin_clock();  // each repeat has its own time
      usleep(500'000);
    }
  });
  jobs.time_limit_s = 1;
  BOOST_TEST(jobs.run(6, 4));
  BOOST_TEST((jobs.done == Numbers{0, 1, 3, 4, 5}));
  BOOST_REQUIRE(jobs.lost.size() == 1U);
  BOOST_TEST(jobs.lost.at(2).text == "took longer than 1 s, the run_timeout");
  BOOST_TEST(jobs.lost.at(2).may_differ);
}

BOOST_AUTO_TEST_CASE(an_interruption_reaches_jobs_under_way_and_begins_no_further_ones) {
  Jobs jobs([](int job, const PoolLink& pool) {
    if (job == 1) pool.note("it began");
    while (job == 1 && pool.go_on()) usleep(1000);
  });
  jobs.on_note = [&jobs](const std::string&) { jobs.interruptions = 1; };
  BOOST_TEST(!jobs.run(9, 1));
  BOOST_TEST((jobs.done == Numbers{0, 1}));
  BOOST_TEST((jobs.notes == std::vector<std::string>{"it began"}));
  BOOST_TEST(!jobs.run(9, 1));  // nor does another batch
  BOOST_TEST(jobs.done.size() == 2U);
}

BOOST_AUTO_TEST_CASE(who_asks_again_a_second_later_ends_what_hangs) {
  Jobs jobs([](int, const PoolLink& pool) {
    pool.note("it hangs");
    usleep(1'200'000);
    pool.note("it hangs on");
    for (;;) pause();
  });
  jobs.on_note = [&jobs](const std::string& note) { jobs.interruptions += note == "it hangs" ? 2 : 1; };
  BOOST_CHECK_THROW(jobs.run(1, 1), RunError);
  BOOST_TEST(jobs.done.empty());
  BOOST_TEST(jobs.notes.size() == 2U);
}

BOOST_AUTO_TEST_CASE(who_asks_a_worker_to_end_means_the_command) {
  Jobs jobs([](int job, const PoolLink&) {
    for (const int number : {SIGINT, SIGHUP}) raise(number);  // a terminal sends these to all of its processes
    if (job == 1) raise(SIGTERM);
  });
  BOOST_TEST(!jobs.run(3, 1));
  BOOST_TEST((jobs.done == Numbers{0}));
  BOOST_TEST(jobs.lost.empty());
}

BOOST_AUTO_TEST_CASE(an_answer_may_end_a_batch_and_not_the_next_one) {
  Jobs jobs([](int, const PoolLink&) {});
  jobs.stops_after_first = true;
  BOOST_TEST(jobs.run(5, 1));
  BOOST_TEST((jobs.done == Numbers{0}));
  jobs.stops_after_first = false;
  BOOST_TEST(jobs.run(5, 1));
  BOOST_TEST(jobs.done.size() == 5U);
}

BOOST_AUTO_TEST_CASE(a_failure_of_the_caller_ends_the_workers) {
  int process = 0;
  {
    Jobs jobs([](int job, const PoolLink&) {
      while (job == 1) pause();
    });
    jobs.on_done = [] { throw RunError("the disk is full"); };
    BOOST_CHECK_THROW(jobs.run(2, 2), RunError);
    process = *jobs.processes.begin();
  }
  BOOST_TEST(kill(process, 0) == -1);
  BOOST_TEST(waitpid(-1, nullptr, WNOHANG) == -1);  // no child is left
}

BOOST_AUTO_TEST_SUITE_END()
