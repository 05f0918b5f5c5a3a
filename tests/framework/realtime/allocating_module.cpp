// A library with functions that use the heap, each in its own way.
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

extern "C" {

/// One malloc, one free.
__attribute__((visibility("default"))) void use_malloc() {
  void* volatile block = std::malloc(100);
  std::free(block);
}

/// One operator new, one operator delete.
__attribute__((visibility("default"))) void use_vector() {
  std::vector<double> values(100);
  double* volatile first = values.data();
  *first = 1;
}

/// The C library allocates, the module frees.
__attribute__((visibility("default"))) void use_strdup() {
  char* volatile text = strdup("a text that the C library copies");
  std::free(text);
}

}  // extern "C"
