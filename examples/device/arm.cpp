// A device with three axes at right angles, on a line of its own.
#include "devices/hardware/declare_hardware.hpp"
#include "framework/node/register_nodes.hpp"
#include "udp_link.hpp"

namespace example_nodes {

class Arm final : public tactor::HardwareDevice {
 public:
  struct Params : tactor::HardwareParams {
    std::int32_t port = 5005;
  };
  Arm(const Params& params, const tactor::NodeContext& context) : HardwareDevice(params, context, parts(params)) {}

  static tactor::NodeInfo declare() {
    tactor::Declare<Arm> declaration("example.arm", "An arm of three axes at right angles, on UDP.");
    declaration.integer("port", &Params::port,
                        {.doc = "of the machine, on this computer", .default_value = 5005, .min = 1, .max = 65535});
    tactor::declare_hardware(declaration);
    return declaration.info();
  }

 private:
  static tactor::HardwareParts parts(const Params& params) {
    tactor::HardwareParts parts;
    parts.link = std::make_unique<UdpLink>(params.port);
    parts.kinematics =
        std::make_unique<tactor::LinearKinematics>(std::vector<tactor::Vec3>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
    parts.limits.axes = 3;
    parts.limits.effort_max = {5, 5, 5};                  // N, what the motors can do
    parts.limits.speed_max = {2, 2, 2};                   // m/s, faster than any hand
    parts.limits.jump_tolerance = {0.001, 0.001, 0.001};  // m
    parts.rate = 1000;
    parts.resolution = 1e-6;  // m, a step of the encoder
    return parts;
  }
};

}  // namespace example_nodes

TACTOR_NODES(registry) {
  registry.add<example_nodes::Arm>();
}
