// Questions that the command asks at its terminal.
#pragma once

#include <atomic>
#include <cstdio>
#include <string>

#include "framework/node/info.hpp"

namespace tactor {

/// Asks on the terminal; with `yes` without asking. Only what is typed after the question counts. False too where
/// standard input has ended, and as soon as `interrupted` is set. `shown`: where the question is written.
bool confirmed(const std::string& question, bool yes, const std::atomic<int>& interrupted, std::FILE* shown = stdout);

/// For EngineOptions::without_dead_man: yes where it is `accepted`; else asks the person at the terminal; null where
/// nobody is there to be asked.
Ask ask_without_dead_man(bool accepted);

}  // namespace tactor
