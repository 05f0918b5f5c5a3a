#include "scan.hpp"

class Scanner {
 public:
  void fill(std::span<ScanPoint> points);
  void step(std::size_t count) {
    Scan scan;
    BLOCK;
  }

 private:
  std::size_t left_out_ = 0;
};
