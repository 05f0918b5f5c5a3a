#include "app/machine/device_access.hpp"

#include <fmt/format.h>
#include <grp.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "devices/hardware/serial_ports.hpp"
#include "framework/core/installation.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

Finding ports_finding(const std::vector<SerialPort>& ports) {
  Finding finding{"ports", "serial ports", Grade::ok, "", "", ""};
  std::string closed;
  for (const SerialPort& port : ports) {
    finding.found += (finding.found.empty() ? "" : ", ") + port.file.string();
    if (!port.may_open) closed += (closed.empty() ? "" : ", ") + port.file.string();
  }
  if (ports.empty()) finding.found = "no serial adapter or card is attached";
  if (closed.empty()) return finding;
  finding.grade = Grade::bad;
  finding.cost = "this user may not open " + closed;
  // As the ports have it: it is not called dialout everywhere.
  for (const SerialPort& port : ports) {
    const std::string group = group_of(port.file);
    if (!port.may_open && !group.empty()) finding.remedy = "sudo usermod -aG " + group + " $USER # then log in anew";
  }
  if (finding.remedy.empty()) finding.remedy = "give the ports a group such as dialout by a udev rule";
  return finding;
}

bool in_group(const char* name) {
  const group* entry = getgrnam(name);
  if (entry == nullptr) return false;
  std::vector<gid_t> groups(static_cast<std::size_t>(std::max(0, getgroups(0, nullptr))));
  const int count = getgroups(static_cast<int>(groups.size()), groups.data());
  groups.resize(static_cast<std::size_t>(std::max(0, count)));
  return getegid() == entry->gr_gid || std::find(groups.begin(), groups.end(), entry->gr_gid) != groups.end();
}

Finding group_finding() {
  Finding finding{"serial_group", "serial group", Grade::ok, "", "", ""};
  if (geteuid() == 0) {
    finding.found = "root may open every port";
  } else if (in_group("dialout")) {
    finding.found = "this user is in the group dialout, which owns serial ports";
  } else {
    finding.grade = Grade::degraded;
    finding.found = "this user is not in the group dialout, which owns serial ports";
    finding.cost = "Modbus on a serial line cannot be opened";
    finding.remedy = "sudo usermod -aG dialout $USER # then log in anew";
  }
  return finding;
}

/// The rule as it was built or installed.
std::string shipped_rule() {
  return installation_prefix() / "lib" / "udev" / "rules.d" / "70-tactor.rules";
}

Finding rule_finding() {
  Finding finding{"udev_rule", "udev rule", Grade::ok, "", "", ""};
  for (const char* folder :
       {"/etc/udev/rules.d", "/usr/local/lib/udev/rules.d", "/usr/lib/udev/rules.d", "/lib/udev/rules.d"}) {
    const fs::path rule = fs::path(folder) / "70-tactor.rules";
    std::error_code error;
    if (!fs::exists(rule, error)) continue;
    finding.found = rule.string();
    return finding;
  }
  if (geteuid() == 0) {
    finding.found = "none, but root needs none";
    return finding;
  }
  finding.grade = Grade::degraded;
  finding.found = "none";
  finding.cost = "only root can open USB devices";
  finding.remedy = "sudo cp " + shipped_rule() +
                   " /etc/udev/rules.d/ && sudo udevadm control --reload # then plug the device in anew";
  return finding;
}

}  // namespace

std::vector<Finding> device_findings() {
  return {ports_finding(serial_ports()), group_finding(), rule_finding()};
}

}  // namespace tactor
