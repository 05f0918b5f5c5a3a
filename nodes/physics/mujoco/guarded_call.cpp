#include "nodes/physics/mujoco/guarded_call.hpp"

#include <mujoco/mujoco.h>

#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace tactor {

namespace {

/// A call under way on a thread.
struct Guard {
  std::jmp_buf landing;
  MujocoText* text = nullptr;
};

/// The innermost call of the thread. Storage that the thread has from its begin: other storage of a plugin is allocated
/// when a thread first touches it.
__attribute__((tls_model("initial-exec"))) thread_local Guard* guard = nullptr;

void note(const char* text) {
  if ((*guard->text)[0] == '\0') std::snprintf(guard->text->data(), guard->text->size(), "%s", text);
}

void (*others_error)(const char*) = nullptr;
void (*others_warning)(const char*) = nullptr;

/// A fatal error outside of our calls is that of another user of the library, and ends as it would without us.
void on_error(const char* text) {
  if (guard != nullptr) {
    (*guard->text)[0] = '\0';
    note(text);
    std::longjmp(guard->landing, 1);
  }
  if (others_error != nullptr) return others_error(text);
  std::fprintf(stderr, "%s\n", text);
  std::exit(EXIT_FAILURE);
}

/// By itself, MuJoCo writes warnings into a file of the current folder.
void on_warning(const char* text) {
  if (guard != nullptr) return note(text);
  if (others_warning != nullptr) others_warning(text);
}

[[maybe_unused]] const bool installed = [] {
  others_error = mju_user_error;
  others_warning = mju_user_warning;
  mju_user_error = on_error;
  mju_user_warning = on_warning;
  return true;
}();

}  // namespace

bool call_guarded(MujocoText& text, void (*work)(void*), void* argument) {
  text[0] = '\0';
  Guard here;
  here.text = &text;
  Guard* const outer = guard;
  guard = &here;
  if (setjmp(here.landing) == 0) {
    work(argument);
    guard = outer;
    return true;
  }
  guard = outer;
  return false;
}

}  // namespace tactor
