#include "nodes/physics/contact/patch_contacts.hpp"

#include "nodes/physics/contact/soft_contacts.hpp"
#include "nodes/physics/geometry/mesh_distance.hpp"

namespace tactor {

namespace {

class PatchSurface final : public SoftContactSource {
 public:
  PatchSurface(const SoftContactOptions& options, const NodeContext& context)
      : contacts_(*context.scene, options, cell_distances({}, nullptr)) {}
  [[nodiscard]] int deformable() const override { return contacts_.deformable(); }
  bool find_on(const SoftFaces& faces, std::span<const Vec3> nodes_W, const Pose& X_WT,
               std::vector<SoftContact>& found) override {
    return contacts_.find_on(faces.node, faces.body, faces.area, nodes_W, X_WT, found);
  }

 private:
  SoftContacts contacts_;
};

}  // namespace

std::unique_ptr<SoftContactSource> patch_contacts(const SoftContactOptions& options, const NodeContext& context) {
  if (context.scene->deformable().empty()) return nullptr;
  return std::make_unique<PatchSurface>(options, context);
}

std::string something_deforms(const Scene& scene) {
  const std::vector<std::size_t> soft = scene.deformable();
  return soft.empty() ? std::string() : "body '" + scene.bodies[soft.front()].name + "' deforms";
}

std::string nothing_deforms(const Scene& scene) {
  return scene.deformable().empty() ? "nothing in the scene deforms" : std::string();
}

}  // namespace tactor
