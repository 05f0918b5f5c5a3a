// Stands in front of the C library's open, ioctl, read, lseek and close, for the paths of emulated USB nodes alone.
#pragma once

#include "devices/usb/emulator/usbfs_node.hpp"

namespace tactor {

/// From now on the calls of this process that concern the node's path, or its descriptor, go to the node; all others
/// go on to the C library. At most 8 nodes; the node stays until `withdraw`.
void interpose(UsbfsNode& node);
void withdraw(UsbfsNode& node);

/// The same for a node that is made when its path is opened first: programs that never do have no emulator in them.
/// `path` and what `make` returns stay for good.
void interpose_when_opened(const char* path, UsbfsNode* (*make)());

}  // namespace tactor
