// source.recording: plays a recording or a CSV file back with its own stamps.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "framework/core/message_batch.hpp"
#include "framework/core/messages.hpp"
#include "framework/node/info.hpp"

namespace tactor {

/// Sends the messages of a file at the times they carry. A step sends everything due since the step before: what was
/// visible by now in the recorded run (the `produced` stamp; in a CSV file the time itself), each with its own `valid`
/// stamp. Messages of any type are sent as `message`; forces, device states and targets at the outputs of that name
/// too. The whole file is read when the node is made. Throws InputError where the file, the stream or the columns
/// cannot be used.
class RecordingSource final : public Node {
 public:
  enum class Begin { as_recorded, at_zero };
  struct Params {
    double rate = 0;  ///< Hz
    std::filesystem::path file;
    std::string stream;
    Mapping columns;
    Begin begin = Begin::as_recorded;
    std::int32_t decimate = 1;
  };

  RecordingSource(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;

  Output<Wrench> force;
  Output<DeviceState> device;
  Output<Target> target;
  AnyOutput message;

 private:
  void read_recording(const Params& params, const std::string& name);
  void begin_at_zero();
  template <class T>
  struct Track {
    std::vector<Stamped<T>> messages;
    std::size_t next = 0;
  };
  template <class T>
  static void play(Track<T>& track, Output<T>& output, Time now);
  Track<Wrench> force_;
  Track<DeviceState> device_;
  Track<Target> target_;
  std::optional<MessageBatch> messages_;  // of the stream of an .h5 file
  std::vector<std::size_t> order_;        // of its messages in time
  std::size_t next_ = 0;                  // in `order_`
};

}  // namespace tactor
