// The command line of `tactor`: all verbs together.
#pragma once

namespace tactor {

/// Does what the command line says; returns the exit code. Throws InputError and RunError.
int run_command(int argc, char** argv);

}  // namespace tactor
