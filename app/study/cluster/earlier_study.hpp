// The study that was in a folder before, kept aside until a new one has been handed over.
#pragma once

#include <filesystem>

namespace tactor {

/// Takes out what an earlier study has left in the folder, but for its cached reference runs.
void clear_study_folder(const std::filesystem::path& out);

/// Moves the earlier study aside. The destructor takes out what is new and puts the earlier study back, unless the new
/// one stands. Cached reference runs stay where they are: they are kept under what they are made of.
class EarlierStudy {
 public:
  /// Throws RunError where the disk refuses.
  explicit EarlierStudy(std::filesystem::path out);
  ~EarlierStudy();
  EarlierStudy(const EarlierStudy&) = delete;
  EarlierStudy& operator=(const EarlierStudy&) = delete;
  /// The new study stands: the earlier one goes.
  void drop();

 private:
  std::filesystem::path out_, aside_;
  bool is_dropped_ = false;
};

}  // namespace tactor
