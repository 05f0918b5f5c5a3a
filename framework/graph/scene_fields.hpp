// The keys of `scene` in a graph file, each described once (see framework/fields/fields.hpp).
#pragma once

#include <array>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "framework/core/scene.hpp"
#include "framework/fields/fields.hpp"

namespace tactor {

class FieldCheck;

/// In the order of the enumeration.
inline const std::vector<std::string> motion_words{"static", "translation", "rigid", "deformable"};

/// A pose as a file has it.
struct PoseText {
  Vec3 p;
  std::optional<Vec3> rpy;
  std::optional<std::array<double, 4>> quaternion;
};
template <>
struct DescribedAs<Pose> {
  using Text = PoseText;
};
PoseText as_text(const Pose& X);
Pose from_text(const PoseText& text);

template <class Visit>
void fields(Visit& visit, PoseText& X) {
  constexpr double turn = 2 * std::numbers::pi;
  visit.field("p", X.p, {.doc = "position", .unit = "m"});
  visit.field("rpy", X.rpy,
              {.doc = "roll, pitch and yaw about the fixed x, y and z", .unit = "rad", .min = -turn, .max = turn});
  visit.field("quaternion", X.quaternion, {.doc = "unit quaternion w, x, y, z, in place of `rpy`"});
}

template <class Visit>
void fields(Visit& visit, Material& m) {
  visit.field("stiffness", m.stiffness, {.doc = "of one contact patch", .unit = "N/m", .min = 0, .above_min = true});
  visit.field("damping", m.damping, {.doc = "of one contact patch", .unit = "N s/m", .min = 0});
  visit.field("friction", m.friction, {.doc = "Coulomb coefficient", .min = 0});
  visit.field("patch_area", m.patch_area,
              {.doc = "the area that a contact patch stands for where a mesh touches a mesh",
               .unit = "m^2",
               .min = 0,
               .above_min = true});
}

template <class Visit>
void fields(Visit& visit, SphereShape& shape) {
  visit.field("radius", shape.radius, {.doc = "radius", .unit = "m", .min = 0, .above_min = true, .required = true});
}
template <class Visit>
void fields(Visit& visit, CapsuleShape& shape) {
  visit.field("radius", shape.radius, {.doc = "radius", .unit = "m", .min = 0, .above_min = true, .required = true});
  visit.field(
      "length", shape.length,
      {.doc = "length of the segment, without the caps", .unit = "m", .min = 0, .above_min = true, .required = true});
}
template <class Visit>
void fields(Visit& visit, BoxShape& shape) {
  visit.field("size", shape.size,
              {.doc = "whole edges along x, y and z", .unit = "m", .min = 0, .above_min = true, .required = true});
}
template <class Visit>
void fields(Visit& /*visit*/, PlaneShape& /*shape*/) {}

template <class Visit>
void fields(Visit& visit, BoxRegion& region) {
  visit.field("low", region.low, {.doc = "one corner", .unit = "m", .required = true});
  visit.field("high", region.high, {.doc = "the other", .unit = "m", .required = true});
}
template <class Visit>
void fields(Visit& visit, HalfSpaceRegion& region) {
  visit.field("p", region.p, {.doc = "a point of the plane", .unit = "m", .required = true});
  visit.field("n", region.n, {.doc = "its normal, of any length; behind is against it", .required = true});
}
template <class Visit>
void fields(Visit& visit, FixedRegion& region) {
  visit.one_of(region, Alternative<BoxRegion>{"box", {.doc = "the nodes in a box along the axes"}},
               Alternative<HalfSpaceRegion>{"behind", {.doc = "the nodes on a plane and behind it"}},
               MemberAlternative<NamedFaces, std::string>{
                   "faces", &NamedFaces::name, {.doc = "the nodes of the faces that a file of tetrahedra names so"}});
}
template <class Visit>
void fields(Visit& visit, Inclusion& inclusion) {
  visit.field("p", inclusion.p, {.doc = "centre, in the frame of the body", .unit = "m", .required = true});
  visit.field("radius", inclusion.radius,
              {.doc = "radius of the ball", .unit = "m", .min = 0, .above_min = true, .required = true});
  visit.field("young", inclusion.young,
              {.doc = "Young's modulus inside", .unit = "Pa", .min = 0, .above_min = true, .required = true});
}
template <class Visit>
void fields(Visit& visit, Deformable& d) {
  visit.field("young", d.young,
              {.doc = "Young's modulus of a deformable body", .unit = "Pa", .min = 0, .above_min = true});
  visit.field("poisson", d.poisson,
              {.doc = "Poisson's ratio of a deformable body",
               .min = 0,
               .max = 0.495,
               .reason = "at 0.5 a solid keeps its volume exactly, which these elements cannot compute"});
  visit.field("density", d.density,
              {.doc = "mass per volume of a deformable body", .unit = "kg/m^3", .min = 0, .above_min = true});
  visit.field("damping", d.damping,
              {.doc = "stress per rate of strain, over the stiffness (Rayleigh's beta)", .unit = "s", .min = 0});
  visit.field("drag", d.drag, {.doc = "force per velocity, over the mass (Rayleigh's alpha)", .unit = "1/s", .min = 0});
  visit.only(d.cell_size == 0, "", [&] {
    visit.field("tetrahedra", d.tetrahedra,
                {.doc = "about so many fill the shape; a file of tetrahedra has its own", .min = 6, .max = 2'000'000});
  });
  visit.only(d.cell_size > 0, "", [&] {
    visit.field("cell_size", d.cell_size,
                {.doc = "length of the edges of tetrahedra, in place of `tetrahedra`",
                 .unit = "m",
                 .min = 0,
                 .above_min = true});
  });
  visit.list_or_one("fixed", d.fixed,
                    {.doc = "what of a deformable body does not move, in its frame: a region or a list of them"});
  visit.by_name("inclusions", d.inclusions, {.doc = "balls of another stiffness in a deformable body, by name"});
}

template <class Visit>
void fields(Visit& visit, Body& body) {
  visit.one_of(
      body.shape,
      MemberAlternative<MeshShape, std::filesystem::path>{
          "mesh", &MeshShape::file, {.doc = "shape: the file of a closed triangle mesh", .files = &mesh_files}},
      Alternative<SphereShape>{"sphere", {.doc = "shape: a ball about the body's origin"}},
      Alternative<CapsuleShape>{"capsule", {.doc = "shape: all points within `radius` of a segment along z"}},
      Alternative<BoxShape>{"box", {.doc = "shape: a cuboid about the body's origin"}},
      Alternative<PlaneShape>{"plane", {.doc = "shape: the half-space z <= 0, written `{}`; it cannot move"}});
  MeshShape none;
  MeshShape* const mesh = std::get_if<MeshShape>(&body.shape);
  visit.only(mesh != nullptr, "only a mesh has a scale; give the size of the shape in metres", [&] {
    visit.field("scale", (mesh != nullptr ? *mesh : none).scale,
                {.doc = "multiplies the mesh's coordinates to give metres; where it is absent they are in m and the "
                        "size must be usual",
                 .min = 0,
                 .above_min = true});
  });
  visit.field("pose", body.X_WB, {.doc = "the body in the world at the start"});
  visit.choice("motion", body.motion, motion_words, {.doc = "how it may move"});
  const bool deforms = body.motion == Motion::deformable;
  visit.only(!deforms, "expected no mass, because the density of a deformable body gives it", [&] {
    visit.field("mass", body.mass,
                {.doc = "mass of a body that moves as a whole", .unit = "kg", .min = 0, .above_min = true});
    visit.field("inertia", body.inertia,
                {.doc = "principal moments in the body's frame; absent: by the shape",
                 .unit = "kg m^2",
                 .min = 0,
                 .above_min = true});
  });
  visit.field("material", body.material, {.doc = "its surface in contact"});
  visit.only(deforms, "only a body with motion: deformable has it", [&] { fields(visit, body.deformable); });
}

template <class Visit>
void fields(Visit& visit, Camera& camera) {
  visit.field("from", camera.from_W, {.doc = "from the middle of the scene towards the camera"});
  visit.field("up", camera.up_W, {.doc = "what is up in the picture"});
}

template <class Visit>
void fields(Visit& visit, Scene& scene) {
  visit.field("gravity", scene.gravity_W, {.doc = "in the world frame", .unit = "m/s^2"});
  visit.only(scene.camera != Camera{}, "",
             [&] { visit.field("camera", scene.camera, {.doc = "from where views and pictures look at the scene"}); });
  visit.only(!scene.tool_name.empty(), "", [&] {
    visit.field("tool", scene.tool_name,
                {.doc = "the moving body that hangs on the device; needed where several move"});
  });
  visit.by_name("bodies", scene.bodies, {.doc = "the bodies, by name"});
}

void check(PoseText& X, const FieldCheck& map);
void check(BoxRegion& region, const FieldCheck& map);
void check(HalfSpaceRegion& region, const FieldCheck& map);
void check(Body& body, const FieldCheck& map);
void check(Camera& camera, const FieldCheck& map);
void check(Scene& scene, const FieldCheck& map);

}  // namespace tactor
