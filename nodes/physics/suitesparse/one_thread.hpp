// How many threads the libraries below CHOLMOD use: one.
#pragma once

namespace tactor {

/// Sets OpenBLAS and BLIS to one thread, for this process. Other libraries, the reference BLAS among them, are taken as
/// they are.
void use_one_blas_thread();

/// As long as it lives, OpenMP opens no threads on this one. CHOLMOD asks for four while it factors, which wait for
/// each other by spinning.
class WithoutOpenMp {
 public:
  WithoutOpenMp();
  ~WithoutOpenMp();
  WithoutOpenMp(const WithoutOpenMp&) = delete;
  WithoutOpenMp& operator=(const WithoutOpenMp&) = delete;

 private:
  int levels_ = 0;
};

}  // namespace tactor
