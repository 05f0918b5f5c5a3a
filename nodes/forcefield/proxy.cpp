#include "nodes/forcefield/proxy.hpp"

#include <algorithm>

#include "framework/core/segment.hpp"
#include "framework/core/value_error.hpp"
#include "nodes/forcefield/supported_scene.hpp"

namespace tactor {

namespace {

constexpr const char* proxy_type = "forcefield.proxy";

GodObject::Options options_of(const ProxyForceField::Params& params, const NodeContext& context) {
  check_static_scene(proxy_type, *context.scene);
  GodObject::Options options{.friction = params.friction,
                             .crease = params.crease,
                             .most_casts = params.most_casts,
                             .most_looks = params.most_looks};
  if (params.probe == ProxyForceField::Probe::point) return options;
  const Body& tool = *context.scene->tool();
  const auto* ball = std::get_if<SphereShape>(&tool.shape);
  if (ball == nullptr) {
    throw ValueError("probe", std::string(proxy_type) + ": the proxy is a ball or a point, and the tool '" + tool.name +
                                  "' is no sphere; set probe: point, which leaves the tool's shape out");
  }
  options.radius = ball->radius;
  return options;
}

}  // namespace

void ProxyForceField::declare_metrics(Declare<ProxyForceField>& d) {
  d.metric("proxy.contacts_most", "1", "planes that pushed at once, most", Better::neither,
           &ProxyForceField::contacts_most_)
      .metric("proxy.lost_samples", "1", "samples without a place outside of all bodies", Better::lower,
              &ProxyForceField::lost_)
      .metric("proxy.unfinished_moves", "1", "samples at which `most_casts` ended the move", Better::lower,
              &ProxyForceField::unfinished_)
      .metric("proxy.starved_moves", "1", "samples at which `most_looks` ended the move", Better::lower,
              &ProxyForceField::starved_)
      .metric("proxy.rejected_samples", "1", "samples that were not finite, or too late", Better::lower,
              [](const ProxyForceField& self) { return self.refused_.refused(); })
      .metric("proxy.casts_mean", "1", "ways looked along at a sample, mean", Better::lower,
              [](const ProxyForceField& self) {
                return self.moves_ > 0 ? static_cast<double>(self.casts_) / static_cast<double>(self.moves_) : 0.0;
              })
      .metric("proxy.casts_most", "1", "ways looked along at a sample, most", Better::lower,
              &ProxyForceField::casts_most_)
      .metric("proxy.looks_most", "1", "faces and boxes about them looked at for a sample, most", Better::lower,
              &ProxyForceField::looks_most_);
}

NodeInfo ProxyForceField::declare() {
  Declare<ProxyForceField> d(proxy_type, "A spring to a proxy that the fixed bodies of the scene keep outside.");
  d.details(
       "The standard renderer of 3-DOF haptics (god-object, virtual proxy). The proxy follows the handle and stops at "
       "surfaces. At each sample it goes to the place nearest to the handle that up to three planes allow, and "
       "continues while surfaces end and others begin. F = stiffness (p_proxy - p_handle), plus a damper along the "
       "surfaces' push. The proxy cannot get through a thin wall, however deep the handle is. Friction is Coulomb "
       "friction from the materials: the proxy stays while the handle is in the friction cone. Shading turns the "
       "normal force to the surface's interpolated normal, so that a mesh feels as smooth as it looks; such a field is "
       "not conservative.\nConnect `segment` to the device, and the proxy runs at the device's rate. Or use it in "
       "place of physics: connect `force` to prediction, and give it a cost or a thread. It goes through all samples "
       "since its last step. It renders neither moving bodies nor torque.\nAfter Ruspini, Kolarov, Khatib, The haptic "
       "display of complex graphical environments (1997), and, for the shading, Morgenbesser and Srinivasan, Force "
       "Shading for Shape Perception in Haptic Virtual Environments (1996).")
      .realtime_safe()
      .input("device", &ProxyForceField::device,
             {.doc = "every sample of the handle", .queue = {QueuePolicy::drop_oldest, 64}})
      .output("segment", &ProxyForceField::segment, "the force at the newest sample, held")
      .output("force", &ProxyForceField::force, "the same, for a predictor")
      .output("state", &ProxyForceField::state, "the proxy as the tool, and the force on it")
      .real("stiffness", &Params::stiffness,
            {.doc = "stiffness of the spring between proxy and handle; the stiffness of the surfaces does not count",
             .unit = "N/m",
             .default_value = 500,
             .min = 0,
             .max = 1e6,
             .above_min = true})
      .real("damping", &Params::damping,
            {.doc = "damping of the handle's velocity along the surfaces' push, while they push; it never pulls",
             .unit = "N s/m",
             .default_value = 0,
             .min = 0,
             .max = 1e4})
      .choice("probe", &Params::probe, {{"tool", Probe::tool}, {"point", Probe::point}}, std::optional(Probe::tool),
              "tool: the proxy is the tool, which must be a sphere; point: the proxy is the handle's point")
      .boolean("friction", &Params::friction, true, "the friction of tool and bodies; false: none")
      .boolean("shading", &Params::shading, true, "interpolate the normals of meshes")
      .real("crease", &Params::crease,
            {.doc = "faces that meet at a larger angle are not shaded into each other",
             .unit = "rad",
             .default_value = 0.6,
             .min = 0,
             .max = 3.141592653589793})
      .integer(
          "most_casts", &Params::most_casts,
          {.doc = "most paths that the proxy searches at a sample; if more are needed, it continues at the next sample",
           .default_value = 64,
           .min = 4,
           .max = 100'000})
      .integer("most_looks", &Params::most_looks,
               {.doc = "most faces, and boxes about them, that these searches look at; if more are needed, it "
                       "continues at the next sample sample",
                .default_value = 20'000,
                .min = 100,
                .max = 100'000'000})
      .real("force_max", &Params::force_max,
            {.doc = "the device's largest force; longer forces are shortened to it",
             .unit = "N",
             .default_value = 8,
             .min = 0,
             .above_min = true})
      .haptic_rate(&Params::rate, {.doc = "ticks per second"})
      .role(Role::force_field);
  declare_metrics(d);
  d.unread_when({"crease"},
                [](const Params& p, const ParamUse&) { return std::string(p.shading ? "" : "shading is false"); });
  return d.info();
}

ProxyForceField::ProxyForceField(const Params& params, const NodeContext& context)
    : params_(params),
      proxy_(*context.scene, options_of(params, context), context.notes),
      R_WT_(context.scene->tool()->X_WB.R) {}

void ProxyForceField::go_to(const Stamped<DeviceState>& sample) {
  proxy_.move(sample.value.X_WD.p);
  const double interval = any_ ? (sample.stamp.valid - newest_.stamp.valid).seconds() : 0;
  v_ = interval > 0 ? (proxy_.position() - last_p_) / interval : Vec3{};
  last_p_ = proxy_.position();
  newest_ = sample;
  any_ = true;
  ++moves_;
  casts_ += proxy_.casts();
  if (proxy_.lost()) ++lost_;
  if (proxy_.casts() >= params_.most_casts) ++unfinished_;
  if (proxy_.starved()) ++starved_;
  contacts_most_ = std::max(contacts_most_, proxy_.contacts());
  casts_most_ = std::max(casts_most_, proxy_.casts());
  looks_most_ = std::max(looks_most_, proxy_.looked());
}

Vec3 ProxyForceField::shown_force() const {
  Vec3 F = params_.stiffness * proxy_.stretch(params_.shading);
  const Vec3& v = newest_.value.V_WD.v;
  if (params_.damping > 0 && is_finite(v)) {
    const Vec3& n = proxy_.normal();
    F += std::max(-params_.damping * dot(v, n), -std::max(0.0, dot(F, n))) * n;
  }
  return limited(F, params_.force_max);
}

void ProxyForceField::step(StepContext& context) {
  Stamped<DeviceState> sample;
  bool moved = false;
  while (samples_.next(device, sample)) {
    const bool later = !any_ || sample.stamp.valid > newest_.stamp.valid;
    const RefusalReason refusal = !is_finite(sample.value.X_WD.p) ? RefusalReason::not_finite
                                  : later                         ? RefusalReason::none
                                                                  : RefusalReason::late;
    refused_.count(refusal);
    if (refusal != RefusalReason::none) continue;
    go_to(sample);
    moved = true;
  }
  if (!moved) return;
  context.add_work(proxy_.contacts());
  const Time valid = newest_.stamp.valid;
  const Wrench shown{shown_force(), {}};
  segment.send(valid, constant_segment(context.now(), shown));
  force.send(valid, shown);
  PhysicsState told;
  told.X_WT = {proxy_.position(), R_WT_};
  told.V_WT.v = v_;
  told.X_WD = newest_.value.X_WD;
  told.V_WD = newest_.value.V_WD;
  told.contact_T_W = shown;
  told.contacts = proxy_.contacts();
  state.send(valid, told);
}

}  // namespace tactor
