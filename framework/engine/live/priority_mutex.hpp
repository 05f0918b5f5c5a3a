// A mutex whose holder inherits the priority of those who wait, and a condition that waits for a point in time.
#pragma once

#include <pthread.h>

#include <cstdint>
#include <ctime>

#include "framework/core/check.hpp"

namespace tactor {

/// A lock between threads of different priorities: a low one that holds it runs at the priority of the highest that
/// waits, so that nothing in between can keep that one waiting.
class PriorityMutex {
 public:
  PriorityMutex() {
    pthread_mutexattr_t attributes;
    TACTOR_DEMAND(pthread_mutexattr_init(&attributes) == 0);
    TACTOR_DEMAND(pthread_mutexattr_setprotocol(&attributes, PTHREAD_PRIO_INHERIT) == 0);
    TACTOR_DEMAND(pthread_mutex_init(&mutex_, &attributes) == 0);
    pthread_mutexattr_destroy(&attributes);
  }
  ~PriorityMutex() { pthread_mutex_destroy(&mutex_); }
  PriorityMutex(const PriorityMutex&) = delete;
  PriorityMutex& operator=(const PriorityMutex&) = delete;

  void lock() { TACTOR_DEMAND(pthread_mutex_lock(&mutex_) == 0); }
  void unlock() { TACTOR_DEMAND(pthread_mutex_unlock(&mutex_) == 0); }
  pthread_mutex_t* native() { return &mutex_; }

 private:
  pthread_mutex_t mutex_;
};

/// A condition on a PriorityMutex. May wake without cause.
class PriorityCondition {
 public:
  PriorityCondition() {
    pthread_condattr_t attributes;
    TACTOR_DEMAND(pthread_condattr_init(&attributes) == 0);
    TACTOR_DEMAND(pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC) == 0);
    TACTOR_DEMAND(pthread_cond_init(&condition_, &attributes) == 0);
    pthread_condattr_destroy(&attributes);
  }
  ~PriorityCondition() { pthread_cond_destroy(&condition_); }
  PriorityCondition(const PriorityCondition&) = delete;
  PriorityCondition& operator=(const PriorityCondition&) = delete;

  void notify_one() { pthread_cond_signal(&condition_); }
  void notify_all() { pthread_cond_broadcast(&condition_); }
  void wait(PriorityMutex& mutex) { pthread_cond_wait(&condition_, mutex.native()); }
  /// Waits until woken or until CLOCK_MONOTONIC shows `ns` nanoseconds.
  void wait_until(PriorityMutex& mutex, std::int64_t ns) {
    const timespec t{.tv_sec = ns / 1'000'000'000, .tv_nsec = ns % 1'000'000'000};
    pthread_cond_timedwait(&condition_, mutex.native(), &t);
  }

 private:
  pthread_cond_t condition_;
};

}  // namespace tactor
