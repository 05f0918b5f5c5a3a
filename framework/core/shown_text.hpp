// Text as a terminal may show it: whatever comes out of a file, from a user or from a device, it controls nothing.
#pragma once

#include <string>
#include <string_view>

namespace tactor {

/// The text with each character that a terminal or a reader could take for something else written as `\u001b`: control
/// characters but line breaks and tabs, and marks that turn or hide text. Bytes that are not UTF-8 become `\xff`. All
/// other characters stay. JSON stays the same JSON.
std::string shown_text(std::string_view text);

/// From now on standard output and standard error of this process write shown_text of what they are given, whoever
/// gives it: stdio, fmt or C++ streams. To be called first, by a program and not by a library.
void show_only_text();

/// Writes to the terminal at `file` (STDOUT_FILENO, STDERR_FILENO) as it is, in one piece and behind what was printed
/// before: for colours and the cursor. Parts that are not ours have to be shown_text.
void draw_on_terminal(int file, std::string_view text);

}  // namespace tactor
