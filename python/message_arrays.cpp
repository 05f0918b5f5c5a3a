#include "python/message_arrays.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/core/messages.hpp"
#include "framework/core/shared_array.hpp"

namespace tactor::python {

namespace py = pybind11;

namespace {

/// An attribute as an object of its own.
py::object get(const py::handle& object, const char* name) {
  return py::getattr(object, name);
}

std::string written(const py::handle& object) {
  return py::cast<std::string>(py::str(object));
}

const char* scalar_format(FieldKind kind) {
  switch (kind) {
    case FieldKind::i8:
      return "i1";
    case FieldKind::u8:
      return "u1";
    case FieldKind::i16:
      return "i2";
    case FieldKind::u16:
      return "u2";
    case FieldKind::i32:
      return "i4";
    case FieldKind::u32:
      return "u4";
    case FieldKind::i64:
      return "i8";
    case FieldKind::u64:
      return "u8";
    case FieldKind::f32:
      return "f4";
    case FieldKind::f64:
    case FieldKind::record:
      break;
  }
  return "f8";
}

py::tuple shape_of(const Field& field) {
  py::tuple shape(field.shape.size());
  for (std::size_t i = 0; i < field.shape.size(); ++i) shape[i] = field.shape[i];
  return shape;
}

/// Names, formats and offsets of fields, of which numpy makes a dtype.
struct Columns {
  py::list names, formats, offsets;

  void add(const char* name, const py::object& format, std::size_t offset) {
    names.append(name);
    formats.append(format);
    offsets.append(offset);
  }
  void add(const std::vector<Field>& fields, std::size_t begin) {
    for (const Field& field : fields) {
      py::object format = field.changes_size ? py::dtype("O") : element_dtype(field);
      if (!field.changes_size && !field.shape.empty()) format = py::make_tuple(format, shape_of(field));
      add(field.name.c_str(), format, begin + field.offset);
    }
  }
  [[nodiscard]] py::dtype dtype(std::size_t size) const {
    py::dict made;
    made["names"] = names;
    made["formats"] = formats;
    made["offsets"] = offsets;
    made["itemsize"] = size;
    return py::dtype::from_args(made);
  }
};

void find_array_fields(const std::vector<Field>& fields, std::vector<const Field*>& found) {
  for (const Field& field : fields) {
    if (field.changes_size) {
      found.push_back(&field);
    } else if (field.kind == FieldKind::record) {
      for (std::size_t i = 0; i < count_of(field); ++i) find_array_fields(field.fields, found);
    }
  }
}

bool has_enumerators(const std::vector<Field>& fields) {
  return std::any_of(fields.begin(), fields.end(),
                     [](const Field& field) { return !field.enumerators.empty() || has_enumerators(field.fields); });
}

/// A copy of the elements, with the elements along the first dimension.
py::array elements_of(const Field& field, const SharedBytes& bytes) {
  std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(bytes.count())};
  for (const std::size_t n : field.shape) shape.push_back(static_cast<py::ssize_t>(n));
  py::array made(element_dtype(field), shape);
  const std::size_t size = bytes.count() * count_of(field) * element_size(field);
  if (size > 0) std::memcpy(made.mutable_data(), bytes.elements(), size);
  return made;
}

std::string text_of(const py::handle& object) {
  std::string text = py::cast<std::string>(py::repr(object));
  constexpr std::size_t most = 80;
  if (text.size() > most) text = text.substr(0, most) + "...";
  return text;
}

/// Reads Python objects into the bytes of a message.
class ValueReader {
 public:
  explicit ValueReader(std::string where) : where_(std::move(where)), numpy_(py::module_::import("numpy")) {}

  /// `to` is zero, and gets whatever of `source` has been read also where this throws.
  void read_fields(const std::vector<Field>& fields, const py::object& source, std::byte* to, const std::string& path,
                   bool stamped) const {
    const py::list names = names_of(source, fields, path);
    for (const py::handle& name : names) {
      const std::string text = written(name);
      const auto same = [&](const auto& field) { return field.name == text; };
      if (std::any_of(fields.begin(), fields.end(), same)) continue;
      if (stamped && std::any_of(std::begin(stamp_fields), std::end(stamp_fields),
                                 [&](const char* stamp) { return text == stamp; })) {
        continue;
      }
      refuse(path, fmt::format("expected the fields {}, found a field {}", list(fields), text));
    }
    for (const Field& field : fields) {
      if (!names.contains(field.name.c_str())) {
        refuse(path, fmt::format("expected the fields {}, found none named {}", list(fields), field.name));
      }
      const py::object value = source[field.name.c_str()];
      read(field, value, to + field.offset, path.empty() ? field.name : path + "." + field.name);
    }
  }

 private:
  [[noreturn]] void refuse(const std::string& path, const std::string& what) const {
    throw InputError(fmt::format("{}{}{}: {}", where_, path.empty() ? "" : ": ", path, what));
  }

  static std::string list(const std::vector<Field>& fields) {
    std::string text;
    for (const Field& field : fields) text += (text.empty() ? "" : ", ") + field.name;
    return text;
  }

  [[nodiscard]] py::list names_of(const py::object& source, const std::vector<Field>& fields,
                                  const std::string& path) const {
    if (py::isinstance<py::dict>(source)) return {source};
    if (py::hasattr(source, "dtype") && !source.attr("dtype").attr("names").is_none() &&
        py::len(source.attr("shape")) == 0) {
      return {source.attr("dtype").attr("names")};
    }
    refuse(path, fmt::format("expected a dict or one structured element with the fields {}, found {}", list(fields),
                             text_of(source)));
  }

  void read(const Field& field, const py::object& value, std::byte* to, const std::string& path) const {
    if (field.changes_size) {
      *reinterpret_cast<SharedBytes*>(to) = read_array(field, value, path);
    } else if (field.kind == FieldKind::record) {
      read_records(field, value, 0, to, path);
    } else {
      const py::array numbers = numbers_of(field, value, path);
      if (!get(numbers, "shape").equal(shape_of(field))) {
        refuse(path, fmt::format("expected the shape {}, found {}", written(shape_of(field)),
                                 written(get(numbers, "shape"))));
      }
      std::memcpy(to, numbers.data(), count_of(field) * element_size(field));
    }
  }

  /// Along the dimension `depth` of the field's shape.
  void read_records(const Field& field, const py::object& value, std::size_t depth, std::byte* to,
                    const std::string& path) const {
    if (depth == field.shape.size()) return read_fields(field.fields, value, to, path, false);
    if (!py::hasattr(value, "__len__") || py::len(value) != field.shape[depth]) {
      refuse(path,
             fmt::format("expected {} elements of {}, found {}", field.shape[depth], field.record, text_of(value)));
    }
    std::size_t stride = element_size(field);
    for (std::size_t d = depth + 1; d < field.shape.size(); ++d) stride *= field.shape[d];
    for (std::size_t i = 0; i < field.shape[depth]; ++i) {
      read_records(field, value[py::int_(i)], depth + 1, to + i * stride, fmt::format("{}[{}]", path, i));
    }
  }

  [[nodiscard]] SharedBytes read_array(const Field& field, const py::object& value, const std::string& path) const {
    const std::size_t size = count_of(field) * element_size(field);
    if (field.kind == FieldKind::record) {
      if (!py::hasattr(value, "__len__")) {
        refuse(path, fmt::format("expected elements of {}, found {}", field.record, text_of(value)));
      }
      const std::size_t count = py::len(value);
      SharedBytes bytes(allocate_array(count, size));
      auto* to = const_cast<std::byte*>(bytes.elements());
      if (count > 0) std::memset(to, 0, count * size);
      for (std::size_t i = 0; i < count; ++i) {
        read_records(field, value[py::int_(i)], 0, to + i * size, fmt::format("{}[{}]", path, i));
      }
      return bytes;
    }
    const py::array numbers = numbers_of(field, value, path);
    bool fits = static_cast<std::size_t>(numbers.ndim()) == field.shape.size() + 1;
    for (std::size_t d = 0; fits && d < field.shape.size(); ++d) {
      fits = static_cast<std::size_t>(numbers.shape(static_cast<py::ssize_t>(d) + 1)) == field.shape[d];
    }
    if (!fits) {
      refuse(path, fmt::format("expected elements of the shape {} along the first dimension, found the shape {}",
                               written(shape_of(field)), written(get(numbers, "shape"))));
    }
    const auto count = static_cast<std::size_t>(numbers.shape(0));
    SharedBytes bytes(allocate_array(count, size));
    if (count > 0) std::memcpy(const_cast<std::byte*>(bytes.elements()), numbers.data(), count * size);
    return bytes;
  }

  /// The value as a contiguous array of the field's kind, of whatever shape.
  [[nodiscard]] py::array numbers_of(const Field& field, const py::object& value, const std::string& path) const {
    const py::dtype dtype = element_dtype(field);
    if (!field.enumerators.empty() && py::isinstance<py::str>(value)) {
      return numpy_.attr("asarray")(enumerator(field, value.cast<std::string>(), path), dtype);
    }
    const auto expected = [&] {
      return fmt::format("expected {} ({}), found {}", written(dtype),
                         field.unit == "1" ? "a plain number" : field.unit, text_of(value));
    };
    py::array given;
    try {
      given = numpy_.attr("asarray")(value);
      if (given.size() == 0) return py::array(given.attr("astype")(dtype));
      if (!numpy_.attr("can_cast")(given.attr("dtype"), dtype, "same_kind").cast<bool>() &&
          !(given.dtype().kind() == 'i' && dtype.kind() == 'u')) {
        refuse(path, expected());
      }
      const py::array cast = numpy_.attr("ascontiguousarray")(given, dtype).attr("reshape")(given.attr("shape"));
      // A number that an integer field cannot hold would come round at its other end.
      const bool integer = dtype.kind() == 'i' || dtype.kind() == 'u';
      if (integer && !numpy_.attr("array_equal")(cast, given).cast<bool>()) refuse(path, expected());
      if (field.enumerators.empty()) return cast;
      for (const py::handle& one : cast.attr("ravel")()) known(field, one.cast<std::int64_t>(), path);
      return cast;
    } catch (const py::error_already_set& error) {
      if (!error.matches(PyExc_TypeError) && !error.matches(PyExc_ValueError) && !error.matches(PyExc_OverflowError)) {
        throw;
      }
      refuse(path, expected());
    }
  }

  static std::string names(const Field& field) {
    std::string text;
    for (const Enumerator& one : field.enumerators) {
      text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", one.name, one.value);
    }
    return text;
  }
  [[nodiscard]] std::int64_t enumerator(const Field& field, const std::string& name, const std::string& path) const {
    for (const Enumerator& one : field.enumerators) {
      if (one.name == name) return one.value;
    }
    refuse(path, fmt::format("expected {}, found {}", names(field), name));
  }
  void known(const Field& field, std::int64_t value, const std::string& path) const {
    const auto same = [&](const Enumerator& one) { return one.value == value; };
    if (std::any_of(field.enumerators.begin(), field.enumerators.end(), same)) return;
    refuse(path, fmt::format("expected {}, found {}", names(field), value));
  }

  std::string where_;
  py::module_ numpy_;
};

/// Throws InputError where a count or an index of the message would lead its readers out of its arrays.
void refuse_unreadable(const MessageType& type, const void* value, const std::string& where) {
  const auto refuse = [&](const std::string& field, int low, int high, int found) {
    if (found >= low && found <= high) return;
    throw InputError(fmt::format("{}: {}.{}: expected {} to {}, found {}", where, type.name, field, low, high, found));
  };
  if (same_type(type, message_type<Forecast>())) {
    refuse("count", 1, Forecast::capacity, static_cast<const Forecast*>(value)->count);
  } else if (same_type(type, message_type<BodyStates>())) {
    refuse("count", 0, BodyStates::capacity, static_cast<const BodyStates*>(value)->count);
  } else if (same_type(type, message_type<ContactSet>())) {
    const auto& set = *static_cast<const ContactSet*>(value);
    refuse("bodies.count", 0, BodyStates::capacity, set.bodies.count);
    refuse("count", 0, ContactSet::capacity, set.count);
    for (int i = 0; i < set.count; ++i) {
      const ContactPair& pair = set.pair[static_cast<std::size_t>(i)];
      refuse(fmt::format("pair[{}].body", i), 0, BodyStates::capacity - 1, pair.body);
      refuse(fmt::format("pair[{}].other", i), ContactPair::fixed, BodyStates::capacity - 1, pair.other);
    }
  }
}

}  // namespace

py::dtype element_dtype(const Field& field) {
  if (field.kind != FieldKind::record) return py::dtype(scalar_format(field.kind));
  Columns columns;
  columns.add(field.fields, 0);
  return columns.dtype(element_size(field));
}

std::size_t value_offset(const MessageType& type) {
  static_assert(sizeof(Stamp) == 24 && offsetof(Stamp, produced) == 8 && offsetof(Stamp, sequence) == 16);
  return (sizeof(Stamp) + type.alignment - 1) / type.alignment * type.alignment;
}

std::size_t message_size(const MessageType& type) {
  const std::size_t alignment = std::max(alignof(Stamp), type.alignment);
  return (value_offset(type) + type.size + alignment - 1) / alignment * alignment;
}

std::vector<const Field*> array_fields(const MessageType& type) {
  std::vector<const Field*> found;
  find_array_fields(type.fields, found);
  TACTOR_DEMAND(found.size() == type.arrays.size());
  return found;
}

MessageArrays::MessageArrays(const MessageType& type)
    : type_(&type),
      value_offset_(python::value_offset(type)),
      message_size_(python::message_size(type)),
      array_fields_(python::array_fields(type)) {
  Columns value;
  value.add(type.fields, 0);
  value_ = value.dtype(type.size);
  Columns message;
  message.add(stamp_fields[0], py::dtype("i8"), 0);
  message.add(stamp_fields[1], py::dtype("i8"), 8);
  message.add(stamp_fields[2], py::dtype("u8"), 16);
  message.add(type.fields, value_offset_);
  message_ = message.dtype(message_size_);
  copied_whole_ = type.arrays.empty() && !has_enumerators(type.fields);
}

void MessageArrays::copy_to(const std::byte* value, std::byte* element) const {
  std::vector<PyObject*> before(type_->arrays.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    std::memcpy(&before[i], element + type_->arrays[i], sizeof(PyObject*));
  }
  std::memcpy(element, value, type_->size);
  for (std::size_t i = 0; i < before.size(); ++i) {
    // What stood here goes where another stands in its place; an exception leaves nothing that is no object.
    std::memset(element + type_->arrays[i], 0, sizeof(PyObject*));
    Py_XDECREF(before[i]);
  }
  for (std::size_t i = 0; i < before.size(); ++i) {
    const auto& bytes = *reinterpret_cast<const SharedBytes*>(value + type_->arrays[i]);
    PyObject* made = elements_of(*array_fields_[i], bytes).release().ptr();
    std::memcpy(element + type_->arrays[i], &made, sizeof made);
  }
}

py::array MessageArrays::copy(const std::byte* value) const {
  py::array made(value_, std::vector<py::ssize_t>{});
  copy_to(value, static_cast<std::byte*>(made.mutable_data()));
  return made;
}

py::array MessageArrays::view(const std::byte* value, const py::object& owner) const {
  if (!type_->arrays.empty()) return copy(value);
  py::array made(value_, std::vector<py::ssize_t>{}, std::vector<py::ssize_t>{}, value, owner);
  made.attr("setflags")(py::arg("write") = false);
  return made;
}

py::array MessageArrays::take(std::vector<std::byte>&& messages) const {
  TACTOR_DEMAND(messages.size() % message_size_ == 0);
  const std::size_t count = messages.size() / message_size_;
  const std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(count)};
  if (type_->arrays.empty()) {
    auto kept = std::make_unique<std::vector<std::byte>>(std::move(messages));
    std::byte* data = kept->data();
    const py::capsule owner(kept.get(), [](void* bytes) { delete static_cast<std::vector<std::byte>*>(bytes); });
    static_cast<void>(kept.release());
    // numpy makes memory of its own where there are no bytes.
    if (count == 0) return py::array(message_, shape);
    return py::array(message_, shape, {static_cast<py::ssize_t>(message_size_)}, data, owner);
  }
  const std::vector<std::byte> held = std::move(messages);
  const auto release_all = [&](std::byte* first) {
    for (std::size_t i = 0; i < count; ++i) release(*type_, first + i * message_size_ + value_offset_);
  };
  const std::unique_ptr<std::byte, decltype(release_all)> releasing(const_cast<std::byte*>(held.data()), release_all);
  py::array made(message_, shape);
  auto* to = static_cast<std::byte*>(made.mutable_data());
  for (std::size_t i = 0; i < count; ++i, to += message_size_) {
    const std::byte* from = held.data() + i * message_size_;
    std::memcpy(to, from, value_offset_);
    copy_to(from + value_offset_, to + value_offset_);
  }
  return made;
}

OwnedValue MessageArrays::value_of(const py::object& object, const std::string& where) const {
  OwnedValue made(*type_);
  py::object source = object;
  if (py::hasattr(source, "dtype") && py::len(source.attr("shape")) > 0 && get(source, "size").equal(py::int_(1))) {
    source = source.attr("reshape")(py::tuple());
  }
  // The same layout: the bytes as they are.
  if (copied_whole_ && py::hasattr(source, "dtype") && get(source, "dtype").equal(value_)) {
    const py::array one = py::module_::import("numpy").attr("asarray")(source);
    if (one.size() == 1) {
      std::memcpy(made.data(), one.data(), type_->size);
      refuse_unreadable(*type_, made.data(), where);
      return made;
    }
  }
  ValueReader(where).read_fields(type_->fields, source, made.data(), "", true);
  refuse_unreadable(*type_, made.data(), where);
  return made;
}

}  // namespace tactor::python
