// The line to a USB device that sends and takes reports of a known layout.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "devices/hardware/link.hpp"
#include "devices/usb/calibration.hpp"
#include "devices/usb/profile.hpp"
#include "devices/usb/usb_port.hpp"
#include "framework/realtime/monotonic_clock.hpp"

namespace tactor {

/// Opening waits for two reports for at most ten report timeouts each, and makes sure by it, by the endpoints and by
/// the text of the profile that the right device answers, before anything but zero is sent; nothing is sent before that
/// where the device speaks first. That first report may have lain in the device since somebody else closed it: it is
/// no sample. A cycle sends a command and takes the first report that comes after that, for which it waits for one
/// report timeout; a stalled endpoint is set free within it, for which the kernel waits for five seconds. A device that
/// sends on its own may have made the report ready a frame before the cycle began.
///
/// A device that only answers is kept two commands ahead: it takes the next one in the frame in which its report is
/// fetched, and would else answer in every other frame. After a timeout, and after a hundred slow cycles, what is still
/// on its way is let pass first, so that no queue of commands grows in the device.
///
/// Closing sends zero and waits for that to go, and for the reports by which a device that only answers shows that it
/// has gone on, for at most a tenth of a second.
///
/// Where the profile has a pose of calibration the line does not open without the record of it, and forgets the record
/// when the device goes.
class UsbLink final : public Link, private UsbListener {
 public:
  /// Makes the connection to libusb, but opens no device.
  UsbLink(UsbProfile profile, UsbChoice choice, CalibrationStore store = CalibrationStore());
  ~UsbLink() override;

  [[nodiscard]] std::string name() const override { return name_; }
  bool open(LinkFailure& failure) override;
  [[nodiscard]] LinkPace pace() const override { return LinkPace::device; }
  bool exchange(const LinkCommand& command, LinkSample& sample, LinkFailure& failure) override;
  void close() override;

  /// Reads the counters for `still`, during which the device must not be moved by more than three counts, and keeps
  /// them as those of the pose of calibration; returns them. Throws InputError where it moved, RunError where it cannot
  /// be read.
  std::vector<double> calibrate(Duration still);

 private:
  void received(std::span<const std::uint8_t> bytes) override;
  bool open_port(LinkFailure& failure);
  bool find_zero(LinkFailure& failure);
  bool wait(Duration most, LinkFailure& failure);
  bool wait_for_report(Duration most, LinkFailure& failure, const LinkCommand* again = nullptr);
  bool drain(LinkFailure& failure);
  bool ask_for_report(Duration most, LinkFailure& failure);
  void send(const LinkCommand& command);
  void read_sample(LinkSample& sample, LinkFailure& failure) const;

  UsbProfile profile_;
  UsbSelector selector_;
  CalibrationStore store_;
  std::string name_;
  UsbBus bus_;
  std::unique_ptr<UsbPort> port_;
  std::vector<double> zero_;  // counts, one an axis
  std::vector<std::uint8_t> newest_, command_;
  std::size_t wrong_size_ = 0;  // of a report that has not the size of the layout
  bool any_wrong_ = false;
  bool fresh_ = false;
  int unanswered_ = 0;        // commands that a report has still to come for, where the device only answers
  int unwanted_ = 0;          // reports that are not to be taken
  int slow_ = 0;              // cycles in a row
  bool out_of_step_ = false;  // it is not known how many commands are unanswered
  Instant ended_;             // when the last cycle did
};

}  // namespace tactor
