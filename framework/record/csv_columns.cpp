#include "framework/record/csv_columns.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

class Columns {
 public:
  std::vector<CsvValue> take() { return std::move(values_); }

  void add_fields(const std::vector<Field>& fields, const std::string& path, CsvValue at) {
    for (const Field& field : fields) {
      CsvValue here = at;
      here.offset = at.offset + field.offset;
      std::string name = path;
      if (!name.empty()) name += '.';
      name += field.name;
      if (field.changes_size) {
        here.in_array = true;
        here.array_offset = here.offset;
        here.array_stride = count_of(field) * element_size(field);
        here.offset = 0;
      }
      add_elements(field, name, here);
    }
  }

 private:
  void add_elements(const Field& field, const std::string& name, const CsvValue& at) {
    const std::size_t size = element_size(field);
    for (std::size_t i = 0; i < count_of(field); ++i) {
      CsvValue one = at;
      one.offset += i * size;
      if (field.kind == FieldKind::record) {
        add_fields(field.fields, name + index_text(field, i), one);
        continue;
      }
      one.field = &field;
      one.heading = name + suffix(field, i) + " [" + unit_text(field) + "]";
      if (values_.size() == most_csv_columns) {
        throw InputError("expected a message of at most " + std::to_string(most_csv_columns) +
                         " numbers for CSV, found more");
      }
      values_.push_back(std::move(one));
    }
  }

  /// `[3]`, `[1][3]` of the element, row-major.
  static std::string index_text(const Field& field, std::size_t element) {
    std::string text;
    for (auto n = field.shape.rbegin(); n != field.shape.rend(); ++n) {
      text.insert(0, "[" + std::to_string(element % *n) + "]");
      element /= *n;
    }
    return text;
  }
  /// `_x` of a vector, `_w` of a quaternion, else the index.
  static std::string suffix(const Field& field, std::size_t element) {
    constexpr std::array<std::string_view, 2> axes{"xyz", "wxyz"};
    if (field.shape.empty()) return "";
    const std::size_t last = field.shape.back();
    if (field.kind != FieldKind::f64 || last < 3 || last > 4) return numbers(field, element);
    std::string text;
    if (field.shape.size() > 1) {
      Field leading = field;
      leading.shape.pop_back();
      text = numbers(leading, element / last);
    }
    return text + "_" + axes[last - 3][element % last];
  }
  static std::string numbers(const Field& field, std::size_t element) {
    std::string text;
    for (auto n = field.shape.rbegin(); n != field.shape.rend(); ++n) {
      text.insert(0, "_" + std::to_string(element % *n));
      element /= *n;
    }
    return text;
  }
  /// Commas would split the heading.
  static std::string unit_text(const Field& field) {
    std::string unit = field.unit;
    std::replace(unit.begin(), unit.end(), ',', ';');
    return unit;
  }

  std::vector<CsvValue> values_;
};

}  // namespace

std::vector<CsvValue> csv_values(const MessageType& type) {
  Columns columns;
  columns.add_fields(type.fields, "", {});
  return columns.take();
}

}  // namespace tactor
