// `tactor doctor`: what this machine offers to a real-time loop.
#include "app/machine/doctor.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "app/verbs/option_values.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/core/shown_text.hpp"

namespace tactor {

namespace {

struct DoctorArguments {
  double seconds = 1;
  bool json = false;
};

int look_at_machine(const DoctorArguments& arguments) {
  const Diagnosis diagnosis = diagnose(Duration::from_seconds(arguments.seconds));
  const bool coloured = isatty(STDOUT_FILENO) == 1 && std::getenv("NO_COLOR") == nullptr;
  if (arguments.json) {
    fmt::print("{}\n", to_json(diagnosis).dump(2));
  } else {
    draw_on_terminal(STDOUT_FILENO, diagnosis_text(diagnosis, coloured) + "\n");
  }
  return 0;
}

}  // namespace

void add_doctor(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand(
      "doctor", "Check whether this machine can run a real-time loop, and say how to fix what is missing");
  const auto arguments = std::make_shared<DoctorArguments>();
  add_number(*verb, "--seconds", arguments->seconds, {.unit = "s", .min = 0.1, .max = 3600},
             "Length of each trial loop, in s")
      ->default_str("1");
  verb->add_flag("--json", arguments->json, "Print JSON, for programs");
  verb->callback([arguments, &exit_code] { exit_code = look_at_machine(*arguments); });
}

}  // namespace tactor
