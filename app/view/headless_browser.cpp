#include "app/view/headless_browser.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int patience_ms = 120'000;
constexpr std::chrono::milliseconds page_look_period{50};
// The files by which the browser is told what to do and answers, as --remote-debugging-pipe wants them.
constexpr int browser_reads = 3, browser_writes = 4;

fs::path find_browser() {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    for (const char* name : {"chromium", "chromium-browser", "google-chrome", "google-chrome-stable"}) {
      if (access((fs::path(folder) / name).c_str(), X_OK) == 0) return fs::path(folder) / name;
    }
  }
  throw InputError("pictures are drawn by Chromium, which is not installed; on Debian: apt-get install chromium");
}

/// The ends of a pipe, neither of them one of the first files.
struct Pipe {
  FileDescriptor read, write;
  Pipe() {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) throw RunError("the system gives no pipe for the browser");
    const FileDescriptor low_read(ends[0]), low_write(ends[1]);
    constexpr int behind_those_of_the_browser = 10;
    read = FileDescriptor(fcntl(ends[0], F_DUPFD_CLOEXEC, behind_those_of_the_browser));
    write = FileDescriptor(fcntl(ends[1], F_DUPFD_CLOEXEC, behind_those_of_the_browser));
    if (!read || !write) throw RunError("the system gives no pipe for the browser");
  }
};

std::string from_base64(const std::string& text) {
  std::string bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const std::size_t digit = digits.find(c);
    if (digit == std::string_view::npos) break;
    bits = bits << 6U | static_cast<std::uint32_t>(digit);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> static_cast<unsigned>(count) & 255U);
  }
  return bytes;
}

}  // namespace

HeadlessBrowser::HeadlessBrowser(int width, int height) {
  const fs::path browser = find_browser();
  Pipe orders, answers;
  std::vector<std::string> arguments{browser,
                                     "--headless=new",
                                     "--remote-debugging-pipe",
                                     "--disable-dev-shm-usage",
                                     "--enable-unsafe-swiftshader",
                                     "--hide-scrollbars",
                                     "--disable-background-networking",
                                     "--disable-component-update",
                                     "--disable-sync",
                                     "--no-first-run",
                                     "--user-data-dir=" + profile_.path().string(),
                                     "about:blank"};
  // The browser refuses its sandbox to root. The page is our own.
  if (geteuid() == 0) arguments.insert(arguments.begin() + 1, "--no-sandbox");
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t files{};
  posix_spawn_file_actions_init(&files);
  for (const int output : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&files, output, "/dev/null", O_RDWR, 0);
  }
  posix_spawn_file_actions_adddup2(&files, orders.read.number(), browser_reads);
  posix_spawn_file_actions_adddup2(&files, answers.write.number(), browser_writes);
  const int refused = posix_spawn(&process_, pointers[0], &files, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (refused != 0) throw RunError("cannot start " + browser.string());
  to_ = std::move(orders.write);
  from_ = std::move(answers.read);
  const json target = json::parse(call("Target.createTarget", R"({"url":"about:blank"})"));
  const json params = {{"targetId", target.at("targetId")}, {"flatten", true}};
  session_ = json::parse(call("Target.attachToTarget", params.dump())).at("sessionId");
  call("Emulation.setDeviceMetricsOverride",
       fmt::format(R"({{"width":{},"height":{},"deviceScaleFactor":1,"mobile":false}})", width, height));
}

HeadlessBrowser::~HeadlessBrowser() {
  // Told by the end of its pipe, it ends; a browser that does not is ended.
  static_cast<void>(to_.close());
  for (int looks = 0; process_ > 0; ++looks) {
    if (waitpid(process_, nullptr, WNOHANG) != 0) return;
    if (looks == 60) kill(process_, SIGKILL);
    std::this_thread::sleep_for(page_look_period);
  }
}

std::string HeadlessBrowser::next_message() {
  std::size_t end = 0;
  while ((end = received_.find('\0')) == std::string::npos) {
    pollfd ready{from_.number(), POLLIN, 0};
    if (poll(&ready, 1, patience_ms) <= 0) throw RunError("the browser does not answer");
    std::array<char, 65536> part{};
    const ssize_t size = ::read(from_.number(), part.data(), part.size());
    if (size <= 0) throw RunError("the browser has ended");
    received_.append(part.data(), static_cast<std::size_t>(size));
  }
  std::string message = received_.substr(0, end);
  received_.erase(0, end + 1);
  return message;
}

std::string HeadlessBrowser::call(const std::string& method, const std::string& params) {
  json order = {{"id", ++calls_}, {"method", method}, {"params", json::parse(params)}};
  if (!session_.empty()) order["sessionId"] = session_;
  const std::string text = order.dump();
  // With the zero byte behind it.
  if (!to_.write_all(text.c_str(), text.size() + 1)) throw RunError("the browser has ended");
  for (;;) {
    const json message = json::parse(next_message(), nullptr, false);
    if (!message.is_object() || message.value("id", 0) != calls_) continue;
    if (message.contains("error")) throw RunError("the browser refused " + method + ": " + message["error"].dump());
    return message.at("result").dump();
  }
}

std::string HeadlessBrowser::evaluate(const std::string& expression) {
  const json params = {{"expression", expression}, {"returnByValue", true}};
  const json result = json::parse(call("Runtime.evaluate", params.dump()));
  if (result.contains("exceptionDetails")) throw RunError("the page failed: " + result["exceptionDetails"].dump());
  return result.at("result").value("value", json()).dump();
}

void HeadlessBrowser::open(const std::string& url) {
  call("Page.navigate", json({{"url", url}}).dump());
}

void HeadlessBrowser::wait_for(const std::string& expression) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(patience_ms);
  while (evaluate("Boolean(" + expression + ")") != "true") {
    if (std::chrono::steady_clock::now() > until) throw RunError("the browser drew nothing in two minutes");
    std::this_thread::sleep_for(page_look_period);
  }
}

std::vector<std::string> HeadlessBrowser::texts(const std::string& expression) {
  return json::parse(evaluate(expression)).get<std::vector<std::string>>();
}

std::string HeadlessBrowser::screenshot() {
  return from_base64(json::parse(call("Page.captureScreenshot", R"({"format":"png"})")).at("data").get<std::string>());
}

}  // namespace tactor
