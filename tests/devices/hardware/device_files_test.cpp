// Where profiles are found, and which serial ports are listed.
#include <boost/test/unit_test.hpp>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "devices/hardware/profile_files.hpp"
#include "devices/hardware/serial_ports.hpp"
#include "framework/core/temporary_folder.hpp"

BOOST_AUTO_TEST_SUITE(device_files_test)

using namespace tactor;
namespace fs = std::filesystem;

namespace {

void write(const fs::path& file, const std::string& text = "") {
  fs::create_directories(file.parent_path());
  std::ofstream(file) << text << "\n";
}

}  // namespace

BOOST_AUTO_TEST_CASE(profiles_are_found_by_path_or_name_and_the_first_folder_wins) {
  const TemporaryFolder folder;
  const fs::path first = folder.path() / "first", second = folder.path() / "second";
  for (const char* name : {"b.yaml", "a.yaml", "c.txt"}) write(first / "usb" / name);
  for (const char* name : {"a.yaml", "d.yaml"}) write(second / "usb" / name);
  write(second / "modbus/e.yaml");
  setenv("TACTOR_PROFILE_PATH", (first.string() + "::" + second.string() + ":/does/not/exist").c_str(), 1);
  const auto found = [](const std::string& line, const std::string& name) {
    return find_file(name, {""}, profiles_of(line)).file;
  };
  BOOST_TEST(found("usb", "a") == first / "usb/a.yaml");
  BOOST_TEST(found("usb", "usb/d.yaml") == second / "usb/d.yaml");
  BOOST_TEST(found("modbus", "e") == second / "modbus/e.yaml");
  BOOST_TEST(found("usb", (second / "usb/a.yaml").string()) == second / "usb/a.yaml");
  BOOST_TEST(found("usb", "e").empty());
  BOOST_TEST(found("usb", "c").empty());
  const std::vector<fs::path> files = files_of(profiles_of("usb"));
  BOOST_TEST_REQUIRE(files.size() >= 3U);
  BOOST_TEST(files[0] == first / "usb/a.yaml");
  BOOST_TEST(files[1] == first / "usb/b.yaml");
  BOOST_TEST(files[2] == second / "usb/d.yaml");
  unsetenv("TACTOR_PROFILE_PATH");
}

BOOST_AUTO_TEST_CASE(what_is_wrong_with_a_profile_is_one_line_with_its_file) {
  const std::runtime_error placed("/p.yaml:1:2: a\n/p.yaml:3:4: b\n/p.yaml:5:6: c");
  BOOST_TEST(broken_profile("/p.yaml", placed) == "/p.yaml:1:2: a (and 2 more)");
  BOOST_TEST(broken_profile("/p.yaml", std::runtime_error("no fence\n")) == "/p.yaml: no fence");
}

BOOST_AUTO_TEST_CASE(serial_ports_with_hardware_behind_them_are_listed) {
  const TemporaryFolder folder;
  const fs::path classes = folder.path() / "sys/class/tty", files = folder.path() / "dev";
  const fs::path adapter = folder.path() / "sys/devices/usb1/1-2";
  write(adapter / "idVendor", "0403");
  write(adapter / "idProduct", "6001");
  write(adapter / "manufacturer", "FTDI");
  write(adapter / "product", "Adapter");
  fs::create_directories(adapter / "1-2:1.0/ttyUSB1");
  for (const char* name : {"ttyUSB1", "ttyAMA0", "ttyACM7", "ttyS0", "tty1", "console"}) {
    fs::create_directories(classes / name);
    // One is known to the system and has no file here, as in a container.
    if (std::string(name) != "ttyACM7") write(files / name);
  }
  fs::create_directory_symlink(adapter / "1-2:1.0/ttyUSB1", classes / "ttyUSB1/device");
  const std::vector<SerialPort> ports = serial_ports(classes, files);
  BOOST_TEST_REQUIRE(ports.size() == 2U);
  BOOST_TEST(ports[0].file == files / "ttyAMA0");
  BOOST_TEST(ports[0].adapter == "a serial card");
  BOOST_TEST(ports[1].file == files / "ttyUSB1");
  BOOST_TEST(ports[1].adapter == "FTDI Adapter (0403:6001)");
  BOOST_TEST(ports[1].may_open);
}

BOOST_AUTO_TEST_SUITE_END()
