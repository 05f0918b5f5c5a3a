#include "nodes/physics/suitesparse/blas_threads.hpp"

#include <dlfcn.h>

namespace tactor {

namespace {

/// A function of the libraries that this one was linked with, or null.
void* linked_function(const char* name) {
  Dl_info here;
  if (dladdr(reinterpret_cast<void*>(&use_one_blas_thread), &here) == 0) return nullptr;
  // Libraries of a plugin are not among those that RTLD_DEFAULT looks through.
  void* const library = dlopen(here.dli_fname, RTLD_LAZY | RTLD_NOLOAD);
  if (library == nullptr) return nullptr;
  void* const found = dlsym(library, name);
  dlclose(library);
  return found;
}

}  // namespace

void use_one_blas_thread() {
  if (void* const set = linked_function("openblas_set_num_threads")) reinterpret_cast<void (*)(int)>(set)(1);
  // BLIS counts in the integers that it was built with, which a register holds either way.
  if (void* const set = linked_function("bli_thread_set_num_threads")) reinterpret_cast<void (*)(long)>(set)(1);
}

}  // namespace tactor
