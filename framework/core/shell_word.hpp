// Texts of users, files and the environment on their way into a script.
#pragma once

#include <string>
#include <string_view>

namespace tactor {

/// The text as one word of a POSIX shell, whatever is in it. Throws InputError where it holds a control character: a
/// line break ends a comment, and schedulers read scripts by the line. `what` tells where the text comes from,
/// `--out`.
std::string shell_word(const std::string& text, const std::string& what);

/// The same for a line that people copy from a terminal, where plain names stay as they are. Control characters are
/// shown as `\x0a`.
std::string as_typed(const std::string& text);

/// Throws the same for a text that goes into a script or to a scheduler as it is.
void refuse_control_characters(const std::string& text, const std::string& what);

/// What a script can export: letters, digits and _, of which the first is no digit.
bool is_variable_name(std::string_view text);

}  // namespace tactor
