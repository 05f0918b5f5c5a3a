#include "nodes/physics/contact/surface_contacts.hpp"

namespace tactor {

namespace {

class SceneSurface final : public ContactSource {
 public:
  SceneSurface(const SurfaceOptions& options, const NodeContext& context)
      : contacts_(*context.scene, options, cell_distances(options, nullptr)), most_work_(options.most_work) {}
  bool find(const BodyStates& bodies, ContactSet& set) override {
    return contacts_.find_within(most_work_, bodies, set);
  }
  void find_at_anchor(const BodyStates& bodies, LocalContacts& around) override {
    contacts_.find_ahead(bodies, 0, around);
  }

 private:
  SceneContacts contacts_;
  int most_work_;
};

}  // namespace

std::unique_ptr<ContactSource> surface_contacts(const SurfaceOptions& options, const NodeContext& context) {
  if (options.contacts == SurfaceOptions::From::anchors) return nullptr;
  SurfaceOptions at_one = options;
  at_one.anchors = 1;
  return std::make_unique<SceneSurface>(at_one, context);
}

}  // namespace tactor
