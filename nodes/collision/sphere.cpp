#include "nodes/collision/sphere.hpp"

#include "nodes/scene/body_mesh.hpp"

namespace tactor {

SphereCollision::SphereCollision(const Params& params, const NodeContext& context) : params_(params) {
  const Body* tool = context.scene->tool();
  if (tool == nullptr) throw InputError("collision.sphere needs a moving body in the scene");
  const auto* sphere = std::get_if<SphereShape>(&tool->shape);
  if (sphere == nullptr) {
    throw InputError("collision.sphere: the tool '" + tool->name + "' is a mesh; use collision.mesh");
  }
  radius_ = sphere->radius;
  X_WT_start_ = tool->X_WB;
  for (const Body& body : context.scene->bodies) {
    if (body.motion != Motion::fixed) continue;
    if (obstacles_.size() == ContactSet::capacity) {
      throw InputError("collision.sphere: the scene has more than " + std::to_string(ContactSet::capacity) +
                       " fixed bodies; join some into one mesh");
    }
    Obstacle obstacle{.X_WS = body.X_WB, .material = combine(tool->material, body.material)};
    if (body.mesh() != nullptr) {
      obstacle.distance.emplace(load_body_mesh(body), body.mesh()->file.string());
    } else if (const auto* ball = std::get_if<SphereShape>(&body.shape)) {
      obstacle.radius = ball->radius;
    } else {
      throw InputError("collision.sphere: the body '" + body.name + "' is neither a mesh nor a sphere");
    }
    obstacles_.push_back(std::move(obstacle));
  }
}

/// The surface of the body nearest to the centre p_SC of the tool, or nothing where it is out of reach.
std::optional<Nearest> SphereCollision::nearest(Obstacle& obstacle, const Vec3& p_SC) const {
  if (!obstacle.distance) {
    const double length = norm(p_SC);
    const Vec3 n = length > 0 ? p_SC / length : Vec3{0, 0, 1};
    return Nearest{length - obstacle.radius, obstacle.radius * n, n, 0, Feature::face, 0};
  }
  // The distance changes by no more than the way moved.
  if (obstacle.last.face >= 0 &&
      obstacle.last.distance - norm(p_SC - obstacle.asked_at) > radius_ + params_.margin + 1e-12) {
    return std::nullopt;
  }
  obstacle.last = obstacle.distance->nearest(p_SC, obstacle.last.face);
  obstacle.asked_at = p_SC;
  return obstacle.last;
}

void SphereCollision::query(const Pose& X_WT, ContactSet& set) {
  set.bodies.count = 1;
  set.bodies.X_WB[0] = X_WT;
  set.count = set.penetrating = set.truncated = 0;
  for (Obstacle& obstacle : obstacles_) {
    const std::optional<Nearest> near = nearest(obstacle, transform(inverse(obstacle.X_WS), X_WT.p));
    if (!near || near->distance - radius_ >= params_.margin) continue;
    const Material& m = obstacle.material;
    const Vec3 n_W = rotate(obstacle.X_WS.R, near->gradient);
    set.contact[static_cast<std::size_t>(set.count++)] = {.p_TC = rotate(inverse(X_WT.R), -radius_ * n_W),
                                                          .p_WC = transform(obstacle.X_WS, near->p),
                                                          .n_W = n_W,
                                                          .distance = near->distance - radius_,
                                                          .weight = 1,
                                                          .stiffness = m.stiffness,
                                                          .damping = m.damping,
                                                          .friction = m.friction};
    if (near->distance < radius_) ++set.penetrating;
  }
}

NodeInfo SphereCollision::declare() {
  Declare<SphereCollision> d("collision.sphere", "Exact contacts of a sphere tool with fixed meshes and spheres.");
  d.details(
      "The signed distance of the sphere's centre less its radius, one contact a body. Where the sphere fits into "
      "a notch it touches one side of it at a time.");
  declare_collision(d);
  return d.info();
}

}  // namespace tactor
