#include "framework/core/shared_object.hpp"

#include <map>
#include <mutex>

namespace tactor {

std::shared_ptr<const void> shared_object(const std::string& key,
                                          const std::function<std::shared_ptr<const void>()>& make) {
  static std::mutex mutex;
  static std::map<std::string, std::weak_ptr<const void>> held;
  const std::lock_guard lock(mutex);
  std::erase_if(held, [](const auto& entry) { return entry.second.expired(); });
  std::weak_ptr<const void>& known = held[key];
  std::shared_ptr<const void> object = known.lock();
  if (!object) known = object = make();
  return object;
}

}  // namespace tactor
