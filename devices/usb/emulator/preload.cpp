// Loaded in front of the C library by tactor-emulate-usb: makes the device that TACTOR_EMULATED_USB describes.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <sstream>

#include "devices/usb/emulator/emulator.hpp"
#include "devices/usb/emulator/interposition.hpp"

namespace {

/// The one device of this process; null where the environment asks for none.
class Preloaded {
 public:
  Preloaded() {
    const char* file = std::getenv("TACTOR_EMULATED_USB");
    if (file == nullptr) return;
    std::ifstream in(file);
    std::ostringstream text;
    text << in.rdbuf();
    tactor::Emulation emulation;
    const std::string wrong = in ? tactor::read_emulation(text.str(), emulation) : "cannot be read";
    if (!wrong.empty()) {
      std::fprintf(stderr, "tactor-emulate-usb: %s: %s\n", file, wrong.c_str());
      std::_Exit(2);
    }
    path_ = emulation.path;
    emulation_ = std::make_unique<tactor::Emulation>(std::move(emulation));
    tactor::interpose_when_opened(path_.c_str(), [] { return preloaded().start(); });
  }
  static Preloaded& preloaded();

 private:
  tactor::UsbfsNode* start() {
    if (!emulator_) {
      emulator_ = std::make_unique<tactor::UsbEmulator>(*emulation_);
      emulator_->run();
    }
    return &emulator_->node();
  }

  std::string path_;
  std::unique_ptr<tactor::Emulation> emulation_;
  std::unique_ptr<tactor::UsbEmulator> emulator_;
};

Preloaded& Preloaded::preloaded() {
  // Never taken down: the program's own last calls may still pass through it.
  static auto* instance = new Preloaded;
  return *instance;
}

[[gnu::constructor]] void begin() {
  Preloaded::preloaded();
}

}  // namespace
