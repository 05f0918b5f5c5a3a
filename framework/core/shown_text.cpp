#include "framework/core/shown_text.hpp"

#include <unistd.h>
#include <ext/stdio_sync_filebuf.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <iostream>

namespace tactor {

namespace {

/// A character of UTF-8, or a byte that is none.
struct Character {
  std::uint32_t code = 0;
  std::size_t size = 1;  // bytes
  bool is_valid = false;
  bool is_cut = false;  // the text ends within it
};

Character first_character(std::string_view text) {
  const auto byte = [text](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(text[i])); };
  const std::uint32_t lead = byte(0);
  if (lead < 0x80) return {lead, 1, true};
  const std::size_t size = lead >= 0xc2 && lead <= 0xdf   ? 2
                           : lead >= 0xe0 && lead <= 0xef ? 3
                           : lead >= 0xf0 && lead <= 0xf4 ? 4
                                                          : 0;
  if (size == 0) return {lead, 1, false};
  std::uint32_t code = lead & (0xffU >> (size + 1));
  for (std::size_t i = 1; i < size; ++i) {
    if (i == text.size()) return {lead, 1, false, true};
    if ((byte(i) & 0xc0U) != 0x80) return {lead, 1, false};
    code = code << 6U | (byte(i) & 0x3fU);
  }
  // Longer than need be, half of a pair, or beyond the last.
  constexpr std::array<std::uint32_t, 5> least{0, 0, 0x80, 0x800, 0x10000};
  const bool is_valid = code >= least[size] && code <= 0x10ffff && !(code >= 0xd800 && code <= 0xdfff);
  return is_valid ? Character{code, size, true} : Character{lead, 1, false};
}

bool is_shown(std::uint32_t code) {
  if (code == '\n' || code == '\t') return true;
  if (code < 0x20 || (code >= 0x7f && code < 0xa0)) return false;
  struct Range {
    std::uint32_t first, last;
  };
  // Marks of direction, blanks without width, ends of lines and paragraphs, and tags.
  constexpr std::array<Range, 8> hidden{{{0x00ad, 0x00ad},
                                         {0x061c, 0x061c},
                                         {0x180e, 0x180e},
                                         {0x200b, 0x200f},
                                         {0x2028, 0x202e},
                                         {0x2060, 0x206f},
                                         {0xfeff, 0xfeff},
                                         {0xe0000, 0xe007f}}};
  return std::none_of(hidden.begin(), hidden.end(),
                      [code](const Range& range) { return code >= range.first && code <= range.last; });
}

void append_escaped(std::string& out, const Character& character) {
  std::array<char, 16> text{};
  if (!character.is_valid) {
    std::snprintf(text.data(), text.size(), "\\x%02x", static_cast<unsigned>(character.code));
  } else if (character.code < 0x10000) {
    std::snprintf(text.data(), text.size(), "\\u%04x", static_cast<unsigned>(character.code));
  } else {
    // As JSON has it.
    const std::uint32_t beyond = character.code - 0x10000;
    std::snprintf(text.data(), text.size(), "\\u%04x\\u%04x", static_cast<unsigned>(0xd800 + (beyond >> 10U)),
                  static_cast<unsigned>(0xdc00 + (beyond & 0x3ffU)));
  }
  out += text.data();
}

/// Appends what can be told of the text and returns what is left: the first bytes of a character.
std::string_view append_shown(std::string& out, std::string_view text) {
  while (!text.empty()) {
    const Character character = first_character(text);
    if (character.is_cut) return text;
    if (character.is_valid && is_shown(character.code)) {
      out.append(text.substr(0, character.size));
    } else {
      append_escaped(out, character);
    }
    text.remove_prefix(character.size);
  }
  return {};
}

bool write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = ::write(file, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

/// The target of a stream of stdio.
struct ShownFile {
  int file;
  std::string cut;  // the beginning of a character whose other bytes have not come yet
};

ssize_t write_shown(void* cookie, const char* bytes, std::size_t size) {
  auto& to = *static_cast<ShownFile*>(cookie);
  try {
    std::string out;
    const std::string text = to.cut + std::string(bytes, size);
    to.cut = append_shown(out, text);
    return write_all(to.file, out) ? static_cast<ssize_t>(size) : 0;
  } catch (const std::exception&) {
    errno = ENOMEM;
    return 0;
  }
}

std::FILE* shown_stream(ShownFile& to, int buffering) {
  std::FILE* stream = fopencookie(&to, "w", {nullptr, write_shown, nullptr, nullptr});
  if (stream != nullptr) std::setvbuf(stream, nullptr, buffering, BUFSIZ);
  return stream;
}

}  // namespace

std::string shown_text(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  std::string_view cut = append_shown(out, text);
  for (; !cut.empty(); cut.remove_prefix(1)) append_escaped(out, {static_cast<unsigned char>(cut[0]), 1, false});
  return out;
}

void show_only_text() {
  // Streams are flushed after static objects have ended. So nothing that they write through is ever deleted.
  static auto& out = *new ShownFile{STDOUT_FILENO, {}};
  static auto& err = *new ShownFile{STDERR_FILENO, {}};
  std::FILE* shown_out = shown_stream(out, isatty(STDOUT_FILENO) == 1 ? _IOLBF : _IOFBF);
  std::FILE* shown_err = shown_stream(err, _IOLBF);
  // Without memory for a stream there is no memory for anything that it could say.
  if (shown_out == nullptr || shown_err == nullptr) return;
  stdout = shown_out;
  stderr = shown_err;
  // The streams of C++ keep the streams of stdio that were there before.
  using Buffer = __gnu_cxx::stdio_sync_filebuf<char>;
  std::cout.rdbuf(new Buffer(stdout));
  std::cerr.rdbuf(new Buffer(stderr));
  std::clog.rdbuf(new Buffer(stderr));
}

void draw_on_terminal(int file, std::string_view text) {
  static_cast<void>(std::fflush(file == STDERR_FILENO ? stderr : stdout));
  static_cast<void>(write_all(file, text));
}

}  // namespace tactor
