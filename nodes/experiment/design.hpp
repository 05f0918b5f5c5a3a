// What makes the trials of an experiment, and what is felt in them: a table is continued by the same design alone.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tactor {

/// The parts of a design, by name, each as text. A table keeps its digest, which does not tell what the parts are, so
/// that it stays blind.
class StudyDesign {
 public:
  void add(std::string name, std::string text) { parts_.emplace_back(std::move(name), std::move(text)); }
  /// 16 hexadecimal digits for the whole, and two for each part. It holds no comma.
  [[nodiscard]] std::string digest() const;
  /// Which parts differ from those of a digest: `levels, interval`. Empty where the digest is that of this design.
  [[nodiscard]] std::string differing(const std::string& other) const;

 private:
  std::vector<std::pair<std::string, std::string>> parts_;
};

}  // namespace tactor
