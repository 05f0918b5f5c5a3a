// Profiles of USB devices. In one that is accepted every field lies in its report.
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "devices/usb/profile.hpp"
#include "framework/yaml/diagnostics.hpp"
#include "require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactor;
  using fuzz::require;
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const UsbProfile profile = parse_usb_profile(text, "p.yaml");
    std::vector<std::uint8_t> report(profile.input.size), order(profile.output.size);
    for (const ReportField& field : profile.input.fields) {
      require(field.at + field.size() <= report.size(), "a field lies in the report");
      static_cast<void>(field.read(report));
    }
    for (const auto* flags : {&profile.input.buttons, &profile.input.faults}) {
      require(flags->size() <= 32, "flags fit a word");
      for (const Flag& flag : *flags) static_cast<void>(flag.is_set(profile.input.fields, report));
    }
    require(profile.input.axes.size() == profile.output.axes.size(), "each axis has both ways");
    write_efforts(profile.output, std::vector<double>(profile.output.axes.size(), 1.0), order);
    require(profile.make_kinematics() != nullptr, "it has a geometry");
  } catch (const YamlError& error) {
    require(std::string(error.what()).rfind("p.yaml", 0) == 0, "a refusal names the file");
  }
  return 0;
}
