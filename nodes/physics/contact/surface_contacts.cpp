#include "nodes/physics/contact/surface_contacts.hpp"

namespace tactor {

namespace {

class SceneSurface final : public ContactSource {
 public:
  SceneSurface(const SurfaceOptions& options, const NodeContext& context)
      : contacts_(*context.scene, options, cell_distances(options, nullptr)), most_work_(options.most_work) {
    contacts_.reserve_within(most_work_);
  }
  bool find(const BodyStates& bodies, ContactSet& set) override {
    return contacts_.find_within(most_work_, bodies, set, &work_);
  }
  [[nodiscard]] int work() const override { return work_; }

 private:
  SceneContacts contacts_;
  int most_work_;
  int work_ = 0;
};

}  // namespace

std::unique_ptr<ContactSource> surface_contacts(const SurfaceOptions& options, const NodeContext& context) {
  if (options.contacts == SurfaceOptions::From::anchors) return nullptr;
  return std::make_unique<SceneSurface>(options, context);
}

}  // namespace tactor
