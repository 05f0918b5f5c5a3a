#include "framework/record/hdf5_table.hpp"

#include <algorithm>

#include "framework/core/check.hpp"
#include "framework/record/hdf5_file.hpp"

namespace tactor {

namespace {

Handle text_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.get(), H5T_VARIABLE);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  return type;
}

bool write_attribute(hid_t object, const std::string& name, const std::string& value) {
  const Handle type = text_type();
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(H5Acreate2(object, name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const char* text = value.c_str();
  return attribute && H5Awrite(attribute.get(), type.get(), &text) >= 0;
}

bool write_column(hid_t file, const TableColumn& column) {
  const bool texts = !column.texts.empty();
  std::vector<const char*> pointers;
  for (const std::string& text : column.texts) pointers.push_back(text.c_str());
  const Handle strings = text_type();
  const hid_t type = texts ? strings.get() : H5T_IEEE_F64LE;
  const hsize_t size = texts ? column.texts.size() : column.numbers.size();
  const Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose);
  const Handle settings(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(settings.get(), false);
  std::string name = column.name;
  std::replace(name.begin(), name.end(), '/', '|');
  const Handle data(H5Dcreate2(file, name.c_str(), type, space.get(), H5P_DEFAULT, settings.get(), H5P_DEFAULT),
                    H5Dclose);
  if (!data) return false;
  for (const auto& [key, value] : column.attributes) {
    if (!write_attribute(data.get(), key, value)) return false;
  }
  const void* values = texts ? static_cast<const void*>(pointers.data()) : column.numbers.data();
  return H5Dwrite(data.get(), texts ? strings.get() : H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0;
}

}  // namespace

void write_hdf5_table(const std::filesystem::path& path, const TableFile& table) {
  silence_hdf5();
  const auto check = [&](bool good) {
    if (!good) throw RunError("cannot write " + path.string() + ": " + hdf5_error());
  };
  Handle file = create_hdf5(path, usual_access());
  check(static_cast<bool>(file));
  for (const auto& [name, value] : table.attributes) check(write_attribute(file.get(), name, value));
  for (const TableColumn& column : table.columns) check(write_column(file.get(), column));
  check(file.reset());
}

}  // namespace tactor
