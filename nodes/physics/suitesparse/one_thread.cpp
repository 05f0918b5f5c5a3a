#include "nodes/physics/suitesparse/one_thread.hpp"

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

using GetLevels = int (*)();
using SetLevels = void (*)(int);

/// OpenMP's own functions, or null where CHOLMOD is built without it. From level 0 on, none of its regions is parallel.
const GetLevels get_levels = reinterpret_cast<GetLevels>(linked_function("omp_get_max_active_levels"));
const SetLevels set_levels = reinterpret_cast<SetLevels>(linked_function("omp_set_max_active_levels"));

}  // namespace

WithoutOpenMp::WithoutOpenMp() {
  if (get_levels == nullptr || set_levels == nullptr) return;
  levels_ = get_levels();
  set_levels(0);
}

WithoutOpenMp::~WithoutOpenMp() {
  if (get_levels != nullptr && set_levels != nullptr) set_levels(levels_);
}

void use_one_blas_thread() {
  if (void* const set = linked_function("openblas_set_num_threads")) reinterpret_cast<void (*)(int)>(set)(1);
  // BLIS counts in the integers that it was built with, which a register holds either way.
  if (void* const set = linked_function("bli_thread_set_num_threads")) reinterpret_cast<void (*)(long)>(set)(1);
}

}  // namespace tactor
