// The command `tactor`.
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "app/interruption.hpp"
#include "app/output.hpp"
#include "app/verbs/command.hpp"
#include "framework/core/check.hpp"
#include "framework/core/read_budget.hpp"
#include "framework/core/shown_text.hpp"

namespace {

/// The exit code, which tells where what was printed has not arrived: little of it leaves the program before its end.
int with_all_printed(int code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  tactor::tell_note(std::string("cannot write to standard output: ") + std::strerror(errno));
  return code == 0 ? 1 : code;
}

}  // namespace

int main(int argc, char** argv) {
  tactor::show_only_text();
  tactor::listen_for_interruption();
  tactor::heed_while_reading([] { return tactor::interruption.load(); });
  try {
    return with_all_printed(tactor::run_command(argc, argv));
  } catch (const tactor::InputError& error) {
    tactor::tell(std::string(error.what()) + "\n", tactor::LogLevel::error);
    return 2;
  } catch (const std::exception& error) {
    tactor::tell_failure(error.what());
    return 1;
  }
}
