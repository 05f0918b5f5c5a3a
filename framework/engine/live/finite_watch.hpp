// Finds the step from which on a node sends values that are not finite.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstring>
#include <optional>
#include <vector>

#include "framework/node/info.hpp"

namespace tactor {

/// Looks at the numbers of fixed place in the messages of one node. On the thread of its steps; allocates nothing after
/// it was made.
class FiniteWatch {
 public:
  /// Outputs with more numbers than `most` are left out, because looking at them takes too long.
  FiniteWatch(const std::vector<OutputInfo>& outputs, std::size_t most) {
    for (const OutputInfo& output : outputs) {
      places_.emplace_back();
      add(output.type->fields, 0, places_.back());
      if (places_.back().size() > most) places_.back().clear();
    }
  }

  /// A message that the step sent by an output.
  void look(std::size_t output, const void* value) noexcept {
    if (found_) return;
    const auto* bytes = static_cast<const std::byte*>(value);
    for (const Place& place : places_[output]) {
      if (!place.is_finite(bytes)) found_ = output;
    }
  }
  /// The step has ended: the output at which it began to send what is not finite; none where it sent only what is, or
  /// the step before did so already.
  std::optional<std::size_t> take() noexcept {
    const std::optional<std::size_t> begun = was_found_ ? std::nullopt : found_;
    was_found_ = found_.has_value();
    found_.reset();
    return begun;
  }

 private:
  struct Place {
    std::size_t offset = 0;
    bool is_double = true;
    [[nodiscard]] bool is_finite(const std::byte* message) const noexcept {
      if (is_double) return std::isfinite(at<double>(message));
      return std::isfinite(at<float>(message));
    }
    template <class Number>
    [[nodiscard]] Number at(const std::byte* message) const noexcept {
      Number number{};
      std::memcpy(&number, message + offset, sizeof number);
      return number;
    }
  };

  static void add(const std::vector<Field>& fields, std::size_t base, std::vector<Place>& places) {
    for (const Field& field : fields) {
      const bool is_real = field.kind == FieldKind::f64 || field.kind == FieldKind::f32;
      if (field.changes_size || (!is_real && field.kind != FieldKind::record)) continue;
      const std::size_t size = element_size(field);
      for (std::size_t i = 0; i < count_of(field); ++i) {
        const std::size_t offset = base + field.offset + i * size;
        if (is_real) {
          places.push_back({offset, field.kind == FieldKind::f64});
        } else {
          add(field.fields, offset, places);
        }
      }
    }
  }

  std::vector<std::vector<Place>> places_;  // by output
  std::optional<std::size_t> found_;        // in the step under way
  bool was_found_ = false;                  // in the step before
};

}  // namespace tactor
