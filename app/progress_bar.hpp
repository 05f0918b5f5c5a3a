// A bar on the last line of a terminal, with the time left; nothing where standard error is none.
#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include "framework/core/shown_text.hpp"

namespace tactor {

/// `1:05:09`, `5:09`: hours where there are any, minutes, seconds.
inline std::string clock_text(double seconds) {
  const auto s = static_cast<long>(std::lround(std::max(0.0, seconds)));
  return s < 3600 ? fmt::format("{}:{:02}", s / 60, s % 60)
                  : fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

/// Draws what is done of one thing after the other; a share smaller than the last begins the next. Used by one thread
/// at a time.
class ProgressBar {
 public:
  ~ProgressBar() { clear(); }
  void draw(double share, const std::string& what) {
    if (!terminal_) return;
    const auto now = std::chrono::steady_clock::now();
    if (share < share_ || !begun_) begin_ = now;
    begun_ = true;
    share_ = share;
    if (now - drawn_ < std::chrono::milliseconds(50)) return;
    drawn_ = now;
    constexpr int width = 24;
    const int full = std::clamp(static_cast<int>(std::lround(share * width)), 0, width);
    const double elapsed = std::chrono::duration<double>(now - begin_).count();
    const std::string left = share > 0 && elapsed > 1 ? clock_text(elapsed * (1 - share) / share) + " left" : "";
    draw_on_terminal(STDERR_FILENO, fmt::format("\r  [{:=<{}}{: <{}}] {:3.0f} %  {:<24.24} {:<13}", "", full, "",
                                                width - full, 100 * share, shown_text(what), left));
    shown_ = true;
  }
  void clear() {
    if (shown_) draw_on_terminal(STDERR_FILENO, fmt::format("\r{: <78}\r", ""));
    shown_ = false;
  }

 private:
  const bool terminal_ = isatty(STDERR_FILENO) == 1;
  bool shown_ = false, begun_ = false;
  double share_ = 0;
  std::chrono::steady_clock::time_point begin_, drawn_;
};

}  // namespace tactor
