#include "tests/fault_nodes/device.hpp"

#include <chrono>
#include <fstream>
#include <thread>

namespace tactor::fault {

Device::Device(const Params& params, const NodeContext& context) : DeviceNode(params, context), params_(params) {
  if (!params_.log.empty()) written_.reserve(60'000);
}

NodeInfo Device::declare() {
  Declare<Device> declaration("fault.device", "A device whose reading goes wrong.");
  declaration.input("target", &Device::target, {.doc = "where the handle is"})
      .choice("fault", &Params::fault, {{"fails", Fault::fails}, {"blocks", Fault::blocks}, {"jumps", Fault::jumps}},
              std::optional(Fault::fails),
              "fails: the reading fails; blocks: one reading does not come back; jumps: the handle is 20 mm aside")
      .text("log", &Params::log, "", "a file for the forces that were written to the device; empty: none");
  declare_when(declaration);
  declare_device(declaration);
  return declaration.info();
}

ReadResult Device::read(Time now, DeviceSample& sample) noexcept {
  if (target.latest() == nullptr) return ReadResult::not_yet;
  // Without a length it is the first reading after `at`, whichever tick that is.
  const bool first = !done_ && now >= Time{} + params_.at;
  const bool wrong = first || params_.is_now(now);
  done_ = done_ || first;
  if (wrong && params_.fault == Fault::fails) return ReadResult::failed;
  if (first && params_.fault == Fault::blocks) {
    std::this_thread::sleep_for(std::chrono::nanoseconds(params_.lasts.ns));
  }
  sample.time = now;
  sample.state.X_WD = target.latest()->value.X_WH;
  if (wrong && params_.fault == Fault::jumps) sample.state.X_WD.p.x += 0.02;
  if (any_) sample.state.V_WD.v = (1.0 / (now - last_).seconds()) * (sample.state.X_WD.p - p_WD_);
  any_ = true;
  last_ = now;
  p_WD_ = sample.state.X_WD.p;
  return ReadResult::sample;
}

bool Device::write(Time now, const Wrench& commanded_D_W) noexcept {
  if (written_.size() < written_.capacity()) written_.emplace_back(now, commanded_D_W.force);
  return true;
}

void Device::report(Report& /*report*/) const {
  if (params_.log.empty()) return;
  std::ofstream file(params_.log);
  file.precision(17);
  for (const auto& [now, force] : written_)
    file << now.ns << ' ' << force.x << ' ' << force.y << ' ' << force.z << '\n';
}

}  // namespace tactor::fault
