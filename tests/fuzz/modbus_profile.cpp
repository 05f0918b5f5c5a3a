// Profiles of Modbus devices. One that is accepted has a cycle within the bounds of Modbus and a fence of its own, and
// an emulated device can be made of it; one that is refused is told with its place.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "devices/modbus/cycle_plan.hpp"
#include "devices/modbus/emulator/device.hpp"
#include "require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactor;
  using namespace tactor::modbus;
  using fuzz::require;
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const Profile profile = parse_profile(text, "p.yaml");
    const CyclePlan plan = plan_cycle(profile);
    for (const auto* part : {&plan.each, &plan.seldom}) {
      for (const Transaction& t : *part) {
        require(t.read_count >= 0 && t.read_count <= 125 && t.write_count >= 0 && t.write_count <= 123, "counts fit");
        require(t.read_count + t.write_count > 0, "a transaction has words");
        require(t.read_address >= 0 && t.read_address + t.read_count <= 65536, "what is read is there");
        require(t.write_address >= 0 && t.write_address + t.write_count <= 65536, "what is written is there");
        require(t.function != plan.fence.function || t.read_count != plan.fence.count, "no read looks like the fence");
      }
    }
    const LineRate rate = line_rate(plan, profile.line, true);
    require(std::isfinite(rate.rate) && rate.rate > 0 && rate.cycle_s > 0, "the line carries some cycles");
    EmulatedDevice device(profile);
    device.advance(Time{});
    device.advance(Time{5'000'000});
    require(std::isfinite(device.state().position), "the device is somewhere");
  } catch (const YamlError& error) {
    require(std::string(error.what()).rfind("p.yaml", 0) == 0, "a refusal names the file");
  }
  return 0;
}
