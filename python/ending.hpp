// The end of a program: what its other threads have begun ends before the interpreter does.
#pragma once

namespace tactor::python {

/// True once the program ends, on every thread but the one that ends it. Whoever works on asks it now and then.
bool is_ending();

/// Work of the framework on a thread of Python, without the interpreter's lock. Once the program ends, no other thread
/// begins any, and none goes back to Python: it waits for the end of the process.
class Work {
 public:
  /// `live`: devices may follow it, so that it has to end by itself.
  explicit Work(bool live);
  Work(const Work&) = delete;
  Work& operator=(const Work&) = delete;
  ~Work();

 private:
  bool live_;
};

/// Ends the work of all other threads, and waits: for live work until it has ended, for other work up to 10 s. Called
/// as the program ends, with the interpreter's lock.
void end_work();
/// In the child of a fork, which has the calling thread alone.
void forget_work();

}  // namespace tactor::python
