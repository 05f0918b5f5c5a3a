// The command `tactor`.
#include "app/interruption.hpp"
#include "app/output.hpp"
#include "app/verbs/command.hpp"
#include "framework/core/check.hpp"
#include "framework/core/read_budget.hpp"
#include "framework/core/shown_text.hpp"

int main(int argc, char** argv) {
  tactor::show_only_text();
  tactor::listen_for_interruption();
  tactor::heed_while_reading([] { return tactor::interruption.load(); });
  try {
    return tactor::run_command(argc, argv);
  } catch (const tactor::InputError& error) {
    tactor::tell(std::string(error.what()) + "\n");
    return 2;
  } catch (const std::exception& error) {
    tactor::tell_note(error.what());
    return 1;
  }
}
