// The typed ends of edges: inputs that hold what arrived, outputs that collect what a step sends.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/core/message.hpp"

namespace tactor {

/// What an edge does with messages that its reader has not taken yet.
enum class QueuePolicy : std::uint8_t {
  latest,       ///< one slot; a newer message replaces an older one
  drop_oldest,  ///< a bounded queue; when full the oldest goes
  drop_newest,  ///< a bounded queue; when full the arriving one goes
  block,        ///< a bounded queue; when full the writer waits
};

/// A policy with its bound.
struct Queue {
  QueuePolicy policy = QueuePolicy::latest;
  std::uint32_t capacity = 1;
};

/// The untyped side of an input, which engines use. Storage is allocated once, by `configure`.
class InputBase {
 public:
  explicit InputBase(const MessageType& type) : type_(&type) {}
  virtual ~InputBase() = default;
  InputBase(const InputBase&) = delete;
  InputBase& operator=(const InputBase&) = delete;

  [[nodiscard]] const MessageType& type() const { return *type_; }
  /// True where an edge ends here.
  [[nodiscard]] bool connected() const { return connected_; }
  /// Messages not taken yet.
  [[nodiscard]] std::size_t unread() const { return unread_; }
  /// Messages lost because the queue was full.
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }
  /// Messages of a `latest` edge that a newer one replaced before they were looked at.
  [[nodiscard]] std::uint64_t superseded() const { return superseded_; }
  /// True where a further message would have to wait (policy `block`).
  [[nodiscard]] bool full() const { return queue_.policy == QueuePolicy::block && unread_ == queue_.capacity; }

  /// Connects the input with this queue and makes its storage.
  void configure(Queue queue) {
    TACTOR_DEMAND(queue.capacity >= 1);
    queue_ = queue;
    connected_ = true;
    allocate(queue.capacity);
  }

  /// Takes a message in by the queue's policy. With `block` the caller asks `full()` first.
  void push(const Stamp& stamp, const void* payload) {
    TACTOR_ASSERT(connected_);
    if (queue_.policy == QueuePolicy::latest) {
      if (unread_ > 0) ++superseded_;
      head_ = 0;
      unread_ = 1;
      store(0, stamp, payload);
      any_ = true;
      return;
    }
    if (unread_ == queue_.capacity) {
      TACTOR_DEMAND(queue_.policy != QueuePolicy::block);
      ++dropped_;
      if (queue_.policy == QueuePolicy::drop_newest) return;
      head_ = (head_ + 1) % queue_.capacity;
      --unread_;
    }
    newest_ = (head_ + unread_) % queue_.capacity;
    ++unread_;
    store(newest_, stamp, payload);
    any_ = true;
  }

  /// Marks a `latest` message as looked at; engines call it when a step begins.
  void mark_seen() {
    if (queue_.policy == QueuePolicy::latest) unread_ = 0;
  }

  /// Hands over what arrived at this port in the reference run, for sinks that judge against it.
  virtual void set_reference(std::span<const Stamp> stamps, std::span<const std::byte> payloads) = 0;

 protected:
  virtual void allocate(std::size_t capacity) = 0;
  virtual void store(std::size_t slot, const Stamp& stamp, const void* payload) = 0;

  const MessageType* type_;
  Queue queue_{};
  std::size_t head_ = 0;
  std::size_t newest_ = 0;
  std::size_t unread_ = 0;
  std::uint64_t dropped_ = 0;
  std::uint64_t superseded_ = 0;
  bool connected_ = false;
  bool any_ = false;
};

/// An input of messages T.
template <Message T>
class Input final : public InputBase {
 public:
  Input() : InputBase(message_type<T>()) {}

  /// The newest message that has arrived, taken or not; null before the first.
  [[nodiscard]] const Stamped<T>* latest() const { return any_ ? &slots_[newest_] : nullptr; }

  /// Takes the oldest message not taken yet into `out`; false where there is none.
  bool pop(Stamped<T>& out) {
    if (unread_ == 0) return false;
    out = slots_[head_];
    if (queue_.policy != QueuePolicy::latest) head_ = (head_ + 1) % queue_.capacity;
    --unread_;
    return true;
  }

  /// What arrived here in the reference run, in order of time; empty where there was none.
  [[nodiscard]] std::span<const Stamped<T>> reference() const { return reference_; }

  void set_reference(std::span<const Stamp> stamps, std::span<const std::byte> payloads) override {
    TACTOR_DEMAND(payloads.size() == stamps.size() * sizeof(T));
    reference_.resize(stamps.size());
    for (std::size_t i = 0; i < stamps.size(); ++i) {
      reference_[i].stamp = stamps[i];
      std::memcpy(&reference_[i].value, payloads.data() + i * sizeof(T), sizeof(T));
    }
  }

 private:
  void allocate(std::size_t capacity) override { slots_.resize(capacity); }
  void store(std::size_t slot, const Stamp& stamp, const void* payload) override {
    slots_[slot].stamp = stamp;
    std::memcpy(&slots_[slot].value, payload, sizeof(T));
  }

  std::vector<Stamped<T>> slots_;
  std::vector<Stamped<T>> reference_;
};

/// The untyped side of an output: what the running step has sent so far.
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
  [[nodiscard]] bool wanted() const { return wanted_; }
  void set_wanted(bool wanted) { wanted_ = wanted; }

 protected:
  const MessageType* type_;
  std::vector<Time> valid_;
  bool wanted_ = true;
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
    if (!wanted_) return;
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

}  // namespace tactor
