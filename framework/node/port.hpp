// The typed ends of edges: inputs hold the messages that arrived, outputs collect the messages that a step sends.
#pragma once

#include <atomic>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/core/message.hpp"
#include "framework/node/edge_queue.hpp"

namespace tactor {

/// The untyped side of an input, which engines use: the reader's end of an EdgeQueue, made by `configure`.
class InputBase {
 public:
  explicit InputBase(const MessageType& type) : type_(&type) {}
  virtual ~InputBase() = default;
  InputBase(const InputBase&) = delete;
  InputBase& operator=(const InputBase&) = delete;

  [[nodiscard]] const MessageType& type() const { return *type_; }
  /// True where an edge ends here.
  [[nodiscard]] bool connected() const { return queue_ != nullptr; }
  /// Messages not taken yet.
  [[nodiscard]] std::size_t unread() const { return connected() ? queue_->unread() : 0; }
  /// True where a further message would have to wait (policy `block`).
  [[nodiscard]] bool full() const {
    return queue_->queue().policy == QueuePolicy::block && queue_->unread() == queue_->queue().capacity;
  }
  /// Connects the input with this queue and makes its storage.
  void configure(Queue queue) { queue_ = std::make_unique<EdgeQueue>(*type_, queue); }
  /// The queue of a connected input.
  [[nodiscard]] EdgeQueue& queue() { return *queue_; }
  [[nodiscard]] const EdgeQueue& queue() const { return *queue_; }

  /// Takes a message in by the queue's policy, and shows it to the reader at once. With `block` the caller asks
  /// `full()` first.
  void push(const Stamp& stamp, const void* value) {
    TACTOR_ASSERT(connected());
    TACTOR_DEMAND(!full());
    queue_->push(stamp, value);
    queue_->admit();
  }

  /// Hands over the messages that arrived at this port in the reference run, for sinks that compare with them.
  virtual void set_reference(std::span<const Stamp> stamps, std::span<const std::byte> payloads) = 0;

 protected:
  const MessageType* type_;
  std::unique_ptr<EdgeQueue> queue_;
};

/// An input of messages T.
template <Message T>
class Input final : public InputBase {
 public:
  Input() : InputBase(message_type<T>()) {}

  /// The newest message that has arrived, taken or not; null before the first. Until the end of the step.
  [[nodiscard]] const Stamped<T>* latest() const { return connected() ? message(queue_->newest()) : nullptr; }

  /// Takes the oldest message not taken yet into `out`; false where there is none.
  bool pop(Stamped<T>& out) {
    const Stamped<T>* oldest = connected() ? message(queue_->take()) : nullptr;
    if (oldest != nullptr) out = *oldest;
    return oldest != nullptr;
  }

  /// The messages that arrived here in the reference run, in order of time; empty if there was no reference run.
  [[nodiscard]] std::span<const Stamped<T>> reference() const { return reference_; }

  void set_reference(std::span<const Stamp> stamps, std::span<const std::byte> payloads) override {
    TACTOR_DEMAND(payloads.size() == stamps.size() * sizeof(T) && type_->arrays.empty());
    reference_.resize(stamps.size());
    for (std::size_t i = 0; i < stamps.size(); ++i) {
      reference_[i].stamp = stamps[i];
      std::memcpy(static_cast<void*>(&reference_[i].value), payloads.data() + i * sizeof(T), sizeof(T));
    }
  }

 private:
  /// The queue keeps stamp and value as Stamped<T> has them.
  static const Stamped<T>* message(const MessageView& view) { return reinterpret_cast<const Stamped<T>*>(view.stamp); }

  std::vector<Stamped<T>> reference_;
};

/// An input whose message type is known when the node is made, such as that of a class in Python.
class AnyInput final : public InputBase {
 public:
  explicit AnyInput(const MessageType& type) : InputBase(type) {}

  /// The newest message that has arrived, taken or not; none before the first. Until the end of the step.
  [[nodiscard]] MessageView latest() const { return connected() ? queue_->newest() : MessageView{}; }
  /// Takes the oldest message not taken yet; none where there is none. Until the next call.
  [[nodiscard]] MessageView take() { return connected() ? queue_->take() : MessageView{}; }

  void set_reference(std::span<const Stamp> /*stamps*/, std::span<const std::byte> /*payloads*/) override {
    TACTOR_DEMAND(!"it asks for a reference");
  }
};

/// The untyped side of an output: the messages that the running step has sent so far.
class OutputBase {
 public:
  explicit OutputBase(const MessageType& type) : type_(&type) {}
  virtual ~OutputBase() = default;
  OutputBase(const OutputBase&) = delete;
  OutputBase& operator=(const OutputBase&) = delete;

  [[nodiscard]] const MessageType& type() const { return *type_; }
  [[nodiscard]] std::size_t pending() const { return valid_.size(); }
  [[nodiscard]] Time pending_valid(std::size_t i) const { return valid_[i]; }
  [[nodiscard]] virtual const void* pending_value(std::size_t i) const = 0;
  virtual void clear_pending() = 0;
  /// False where no edge, recording or sink wants this output; a node may skip the work for it.
  [[nodiscard]] bool wanted() const { return wanted_.load(std::memory_order_relaxed); }
  /// From any thread, while the node steps.
  void set_wanted(bool wanted) { wanted_.store(wanted, std::memory_order_relaxed); }

 protected:
  const MessageType* type_;
  std::vector<Time> valid_;
  std::atomic<bool> wanted_{true};
};

/// An output of messages T.
template <Message T>
class Output final : public OutputBase {
 public:
  Output() : OutputBase(message_type<T>()) {
    values_.reserve(4);
    valid_.reserve(4);
  }

  /// Sends a value that holds for the time `valid`; it becomes visible when the step's cost has passed.
  void send(Time valid, const T& value) {
    if (!wanted()) return;
    values_.push_back(value);
    valid_.push_back(valid);
  }

  [[nodiscard]] const void* pending_value(std::size_t i) const override { return &values_[i]; }
  void clear_pending() override {
    values_.clear();
    valid_.clear();
  }

 private:
  std::vector<T> values_;
};

/// An output whose message type is known when the node is made, such as that of a recorded stream.
class AnyOutput final : public OutputBase {
 public:
  AnyOutput() : OutputBase(any_message()) {}
  ~AnyOutput() override { clear_pending(); }

  /// Before anything is sent; `type` outlives the node.
  void set_type(const MessageType& type) { type_ = &type; }
  /// Sends a message of the type.
  void send(Time valid, const void* value) {
    if (!wanted()) return;
    const std::size_t at = bytes_.size();
    bytes_.resize(at + type_->size);
    std::memcpy(bytes_.data() + at, value, type_->size);
    retain(*type_, value);
    valid_.push_back(valid);
  }

  [[nodiscard]] const void* pending_value(std::size_t i) const override { return bytes_.data() + i * type_->size; }
  void clear_pending() override {
    for (std::size_t i = 0; i < pending(); ++i) release(*type_, bytes_.data() + i * type_->size);
    bytes_.clear();
    valid_.clear();
  }

 private:
  std::vector<std::byte> bytes_;
};

}  // namespace tactor
