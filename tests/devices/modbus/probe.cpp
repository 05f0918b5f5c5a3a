// modbus_probe ENDPOINT PROFILE [NAME=VALUE ...]: writes registers of a profile and reads all that can be read, for the
// tests against independent servers. Prints `NAME VALUE`, or `NAME error KIND TEXT`, a line each.
// modbus_probe ENDPOINT PROFILE --cycle EFFORT: opens the line as a run does, commands the effort (N) of the first axis
// in one cycle, prints `q POSITION` (m) and closes.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "devices/modbus/modbus_link.hpp"

using namespace tactor;
using namespace tactor::modbus;

namespace {

int one_cycle(const Profile& profile, const char* endpoint, double effort) {
  ModbusLink link(profile, parse_endpoint(endpoint));
  LinkFailure failure;
  LinkSample sample;
  const bool opened = link.open(failure);
  if (opened && link.exchange({{effort}}, sample, failure)) {
    std::printf("q %.9g\n", sample.q[0]);
    return 0;
  }
  std::printf("%s error %s %s\n", opened ? "cycle" : "connect", std::string(name_of(failure.error)).c_str(),
              failure.text.c_str());
  return 1;
}

int run(int argc, char** argv) {
  const Profile profile = read_profile(argv[2]);
  if (argc == 5 && std::string(argv[3]) == "--cycle") return one_cycle(profile, argv[1], std::atof(argv[4]));
  const CyclePlan plan = plan_cycle(profile);
  Client client(parse_endpoint(argv[1]), profile.line, plan.fence, plan.longest_answer);
  LinkFailure failure;
  if (!client.connect(failure)) {
    std::printf("connect error %s %s\n", std::string(name_of(failure.error)).c_str(), failure.text.c_str());
    return 1;
  }
  const auto told = [&](const std::string& name) {
    std::printf("%s error %s %s\n", name.c_str(), std::string(name_of(failure.error)).c_str(), failure.text.c_str());
  };
  for (int i = 3; i < argc; ++i) {
    const std::string word = argv[i];
    const std::string name = word.substr(0, word.find('='));
    for (const RegisterInfo& info : profile.registers) {
      if (info.name != name) continue;
      std::uint16_t words[2] = {};
      encode(info, std::atof(word.c_str() + name.size() + 1), words);
      const int function = info.write_function == 6 ? 6 : 16;
      if (!client.transfer({.function = function, .write_address = info.address, .write_count = info.width()}, words,
                           nullptr, failure)) {
        told(name);
      }
    }
  }
  for (const RegisterInfo& info : profile.registers) {
    if (!info.readable) continue;
    std::uint16_t words[2] = {};
    if (client.transfer({.function = info.read_function, .read_address = info.address, .read_count = info.width()},
                        nullptr, words, failure)) {
      std::printf("%s %.9g\n", info.name.c_str(), decode(info, words));
    } else {
      told(info.name);
    }
  }
  // Function 23: writes the first register that can be written that way and reads the first block.
  for (const RegisterInfo& info : profile.registers) {
    if (!info.writable || info.write_function != 23) continue;
    std::uint16_t words[2] = {}, read[2] = {};
    encode(info, 21, words);
    const RegisterInfo& from = profile.registers.front();
    if (client.transfer({.function = 23,
                         .read_address = from.address,
                         .read_count = from.width(),
                         .write_address = info.address,
                         .write_count = info.width()},
                        words, read, failure)) {
      std::printf("combined %.9g\n", decode(from, read));
    } else {
      told("combined");
    }
    break;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
