// The builder of message types: member pointers in, a description out that is checked against the struct.
#pragma once

#include <array>
#include <concepts>
#include <cstdio>
#include <initializer_list>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/core/message.hpp"
#include "framework/core/shared_array.hpp"
#include "framework/core/spatial.hpp"

namespace tactor {

/// A name for a value of an enumeration in a message.
template <class E>
struct NamedValue {
  std::string name;
  E value;
  std::string doc = {};
};

/// A name and a doc for a field that comes from a record.
struct NamedField {
  std::string name;
  std::string doc = {};
};

namespace description {

template <class M>
struct Element;

template <class M>
requires std::is_arithmetic_v<M>
struct Element<M> {
  static_assert(!std::same_as<M, bool>, "describe a flag as an integer or as an enumeration");
  static void describe(Field& field) {
    constexpr std::array<FieldKind, 4> sints{FieldKind::i8, FieldKind::i16, FieldKind::i32, FieldKind::i64};
    constexpr std::array<FieldKind, 4> uints{FieldKind::u8, FieldKind::u16, FieldKind::u32, FieldKind::u64};
    constexpr std::size_t index = sizeof(M) == 1 ? 0 : sizeof(M) == 2 ? 1 : sizeof(M) == 4 ? 2 : 3;
    if constexpr (std::floating_point<M>) {
      static_assert(sizeof(M) == 4 || sizeof(M) == 8);
      field.kind = sizeof(M) == 4 ? FieldKind::f32 : FieldKind::f64;
    } else {
      field.kind = std::signed_integral<M> ? sints[index] : uints[index];
    }
  }
};

template <class E>
requires std::is_enum_v<E>
struct Element<E> {
  static void describe(Field& field) {
    TACTOR_DEMAND(!field.enumerators.empty());
    Element<std::underlying_type_t<E>>::describe(field);
  }
};

template <>
struct Element<Time> {
  static void describe(Field& field) {
    field.kind = FieldKind::i64;
    field.unit = "ns";
  }
};

template <>
struct Element<Duration> : Element<Time> {};

template <>
struct Element<Vec3> {
  static void describe(Field& field) {
    field.kind = FieldKind::f64;
    field.shape.push_back(3);
  }
};

template <>
struct Element<Quat> {
  static void describe(Field& field) {
    field.kind = FieldKind::f64;
    field.shape.push_back(4);
  }
};

template <class M, std::size_t n>
struct Element<std::array<M, n>> {
  static void describe(Field& field) {
    field.shape.push_back(n);
    Element<M>::describe(field);
  }
};

template <class M>
struct Element<SharedArray<M>> {
  static void describe(Field& field) {
    TACTOR_DEMAND(field.shape.empty());
    field.changes_size = true;
    Element<M>::describe(field);
  }
};

/// Any other struct is a record, which has a description of its own.
template <class M>
requires std::is_class_v<M>
struct Element<M> {
  static void describe(Field& field) {
    const MessageType& type = message_type<M>();
    TACTOR_DEMAND(!field.changes_size || type.arrays.empty());
    field.kind = FieldKind::record;
    field.record = type.name;
    field.fields = type.fields;
    if (field.doc.empty()) field.doc = type.doc;
  }
};

}  // namespace description

/// Describes message type or record T, every member in the order of the struct:
///
///     template <>
///     inline const MessageType& message_type<Scan>() {
///       static const MessageType type =
///           Describe<Scan>("mylab.Scan", "S", "One turn of a scanner. Stamped valid for the middle of the turn.")
///               .field("range", "m", &Scan::range, "Largest distance that it sees, from the origin of S.")
///               .field("points", &Scan::points, "Points in the order in which they were seen.")
///               .type();
///       return type;
///     }
///
/// Members are numbers, times, Vec3, Quat, enumerations, described records, std::arrays and SharedArrays of these. A
/// member that is left out, or told in another order, ends the program when the type is first used. A doc is one or
/// more sentences on what the name, the unit and the frame do not say; a record without one gets that of its type.
template <class T>
class Describe {
  static_assert(Message<T>);

 public:
  /// `frame`: the frame its vectors are expressed in, or empty. `doc`: of the type and of the stamps of its messages.
  explicit Describe(std::string name, std::string frame = "", std::string doc = "") {
    type_.name = std::move(name);
    type_.frame = std::move(frame);
    type_.doc = std::move(doc);
  }

  /// A member with the unit of its numbers; "1" for plain ones.
  template <class M>
  Describe& field(std::string name, std::string unit, M T::*member, std::string doc = "") {
    Field field;
    field.name = std::move(name);
    field.unit = std::move(unit);
    field.doc = std::move(doc);
    return add<M>(std::move(field), offset_of(member));
  }
  /// A record, which knows the units of its fields, or a time.
  template <class M>
  Describe& field(std::string name, M T::*member, std::string doc = "") {
    return field(std::move(name), "1", member, std::move(doc));
  }
  /// A member that holds one of the named values.
  template <class E>
  requires std::is_enum_v<E> Describe& choice(std::string name, E T::*member,
                                              const std::vector<NamedValue<std::type_identity_t<E>>>& values,
                                              std::string doc = "") {
    Field field;
    field.name = std::move(name);
    field.doc = std::move(doc);
    for (const auto& one : values) {
      field.enumerators.push_back({one.name, static_cast<std::int64_t>(one.value), one.doc});
    }
    return add<E>(std::move(field), offset_of(member));
  }
  /// The fields of a record, as fields of this one under the given names; one without a doc keeps that of the record.
  template <class M>
  Describe& flat(std::initializer_list<NamedField> names, M T::*member) {
    const MessageType& record = message_type<M>();
    TACTOR_DEMAND(names.size() == record.fields.size());
    auto name = names.begin();
    for (Field field : record.fields) {
      field.name = name->name;
      if (!name->doc.empty()) field.doc = name->doc;
      ++name;
      offsets_.push_back(offset_of(member) + field.offset);
      type_.fields.push_back(std::move(field));
    }
    return *this;
  }
  /// The frame of the field just described, where it is another than the message's.
  Describe& frame(std::string name) {
    type_.fields.back().frame = std::move(name);
    return *this;
  }

  /// The finished description.
  [[nodiscard]] MessageType type() {
    lay_out(type_);
    for (std::size_t i = 0; i < type_.fields.size(); ++i) {
      if (type_.fields[i].offset != offsets_[i]) wrong(type_.fields[i].name);
    }
    if (type_.size != sizeof(T) || type_.alignment != alignof(T)) wrong("its end");
    return std::move(type_);
  }

 private:
  template <class M>
  Describe& add(Field field, std::size_t offset) {
    description::Element<M>::describe(field);
    offsets_.push_back(offset);
    type_.fields.push_back(std::move(field));
    return *this;
  }
  template <class M>
  std::size_t offset_of(M T::*member) {
    // Of a real object, because there is no other way that the language defines. Only while types are described.
    if (!sample_) sample_ = std::make_unique<T>();
    return static_cast<std::size_t>(reinterpret_cast<const std::byte*>(&((*sample_).*member)) -
                                    reinterpret_cast<const std::byte*>(sample_.get()));
  }
  [[noreturn]] void wrong(const std::string& where) const {
    std::fprintf(stderr, "message type %s: describe every member in the order of the struct; wrong at %s\n",
                 type_.name.c_str(), where.c_str());
    std::abort();
  }

  MessageType type_;
  std::vector<std::size_t> offsets_;
  std::unique_ptr<T> sample_;
};

}  // namespace tactor
