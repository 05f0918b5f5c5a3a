// Chromium without a window, told what to do through a pipe by the DevTools protocol.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "framework/core/file_descriptor.hpp"
#include "framework/core/temporary_folder.hpp"

namespace tactor {

/// A browser with one page. Every function throws RunError where the browser fails or does not answer in two minutes.
class HeadlessBrowser {
 public:
  /// `width` by `height` pixels. Throws InputError where no browser is installed.
  HeadlessBrowser(int width, int height);
  ~HeadlessBrowser();
  HeadlessBrowser(const HeadlessBrowser&) = delete;
  HeadlessBrowser& operator=(const HeadlessBrowser&) = delete;

  void open(const std::string& url);
  /// Until the expression is true in the page.
  void wait_for(const std::string& expression);
  /// The list of texts that the expression is.
  std::vector<std::string> texts(const std::string& expression);
  /// What the page shows, as the bytes of a PNG file.
  std::string screenshot();

 private:
  /// Calls a method of the protocol; its result, as JSON.
  std::string call(const std::string& method, const std::string& params);
  /// The value of the expression in the page, as JSON.
  std::string evaluate(const std::string& expression);
  std::string next_message();

  TemporaryFolder profile_;
  FileDescriptor to_, from_;
  pid_t process_ = 0;
  int calls_ = 0;
  std::string session_;
  std::string received_;  // bytes of messages that were not taken yet
};

}  // namespace tactor
