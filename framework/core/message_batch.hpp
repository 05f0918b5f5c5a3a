// Messages of one type in a row, which a reader of recordings fills.
#pragma once

#include <cstddef>
#include <cstring>
#include <utility>
#include <vector>

#include "framework/core/message.hpp"

namespace tactor {

/// Owns its messages and their SharedArrays.
class MessageBatch {
 public:
  /// `type` must outlive the batch.
  explicit MessageBatch(const MessageType& type) : type_(&type) {}
  MessageBatch(MessageBatch&& other) noexcept
      : type_(other.type_), stamps_(std::move(other.stamps_)), values_(std::move(other.values_)) {
    other.stamps_.clear();
  }
  MessageBatch& operator=(MessageBatch&& other) noexcept {
    std::swap(type_, other.type_);
    stamps_.swap(other.stamps_);
    values_.swap(other.values_);
    return *this;
  }
  MessageBatch(const MessageBatch&) = delete;
  MessageBatch& operator=(const MessageBatch&) = delete;
  ~MessageBatch() { clear(); }

  [[nodiscard]] const MessageType& type() const { return *type_; }
  [[nodiscard]] std::size_t size() const { return stamps_.size(); }
  [[nodiscard]] bool empty() const { return stamps_.empty(); }
  [[nodiscard]] const Stamp& stamp(std::size_t i) const { return stamps_[i]; }
  [[nodiscard]] Stamp& stamp(std::size_t i) { return stamps_[i]; }
  [[nodiscard]] const std::byte* value(std::size_t i) const { return values_.data() + i * type_->size; }
  [[nodiscard]] std::byte* value(std::size_t i) { return values_.data() + i * type_->size; }

  void reserve(std::size_t messages) {
    stamps_.reserve(messages);
    values_.reserve(messages * type_->size);
  }
  /// Adds a message of zeros.
  void add(const Stamp& stamp) {
    values_.resize(values_.size() + type_->size);
    stamps_.push_back(stamp);
  }
  void add(const Stamp& stamp, const void* value) {
    add(stamp);
    std::memcpy(this->value(size() - 1), value, type_->size);
    retain(*type_, this->value(size() - 1));
  }
  void clear() {
    for (std::size_t i = 0; i < size(); ++i) release(*type_, value(i));
    stamps_.clear();
    values_.clear();
  }

 private:
  const MessageType* type_;
  std::vector<Stamp> stamps_;
  std::vector<std::byte> values_;
};

}  // namespace tactor
