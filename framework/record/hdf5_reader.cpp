#include "framework/record/hdf5_reader.hpp"

#include <unistd.h>

#include <array>
#include <fstream>
#include <limits>

#include "framework/core/check.hpp"
#include "framework/core/input_file.hpp"
#include "framework/core/messages.hpp"
#include "framework/record/hdf5_writer.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// True where the superblock says that a writer has the file in the mode that allows readers beside it.
bool marked_as_being_written(const fs::path& path) {
  constexpr std::size_t flags_at = 11;
  constexpr int writing_beside_readers = 0x01 | 0x04;
  std::array<char, flags_at + 1> head{};
  std::ifstream in(path, std::ios::binary);
  return in.read(head.data(), head.size()) && (head[flags_at] & writing_beside_readers) == writing_beside_readers;
}

/// The most rows that the bytes of a dataset in the file can hold.
std::uint64_t rows_with_room(hid_t data, const MessageType& type, std::uint64_t file_size) {
  // What a writer that was killed had given out and not written yet.
  constexpr std::uint64_t unwritten = std::uint64_t{16} << 20U;
  if (H5Dget_storage_size(data) > file_size + unwritten) return 0;
  // What HDF5 unpacks at once; ours are an eighth of a megabyte.
  constexpr std::uint64_t most_chunk_bytes = std::uint64_t{64} << 20U;
  const std::uint64_t record = layout::record_size(type);
  const Handle properties(H5Dget_create_plist(data), H5Pclose);
  if (!properties || H5Pget_external_count(properties.get()) != 0) return 0;
  switch (H5Pget_layout(properties.get())) {
    case H5D_CHUNKED: {
      const Handle space(H5Dget_space(data), H5Sclose);
      hsize_t rows = 0, chunks = 0;
      if (H5Pget_chunk(properties.get(), 1, &rows) != 1 || rows == 0 || rows > most_chunk_bytes / record) return 0;
      if (!space || H5Dget_num_chunks(data, space.get(), &chunks) < 0) return 0;
      return chunks > std::numeric_limits<std::uint64_t>::max() / rows ? 0 : chunks * rows;
    }
    case H5D_CONTIGUOUS:
    case H5D_COMPACT:
      return H5Dget_storage_size(data) / record;
    default:
      return 0;
  }
}

}  // namespace

namespace {

/// How a file is opened that a writer may be at. HDF5 reads what fails its checksum again, because it may be half
/// written, 100 times and each time after twice the wait: on a damaged file for ever. 24 times are 17 ms.
Handle few_attempts() {
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  TACTOR_DEMAND(H5Pset_metadata_read_attempts(access.get(), 24) >= 0);
  return access;
}

}  // namespace

Hdf5Reader::Hdf5Reader(fs::path path) : path_(std::move(path)) {
  silence_hdf5();
  // HDF5 opens it by its name; it would wait for ever for the writer of a pipe.
  const InputFile input = open_input(path_);
  if (input.is_missing) throw InputError("there is no recording " + path_.string());
  if (!input.file) throw InputError(path_.string() + ": " + input.error);
  if (H5Fis_hdf5(path_.c_str()) <= 0) {
    throw InputError(path_.string() +
                     " is no HDF5 file (or its beginning is damaged); a recording of tactor is expected");
  }
  file_ = Handle(H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file_) {
    const std::string why = hdf5_error();
    if (marked_as_being_written(path_)) {
      file_ = Handle(H5Fopen(path_.c_str(), H5F_ACC_RDONLY | H5F_ACC_SWMR_READ, few_attempts().get()), H5Fclose);
    }
    if (!file_) refuse(why);
  }
  read_header();
}

void Hdf5Reader::refuse(const std::string& why) const {
  throw InputError("the recording " + path_.string() + " is damaged or incomplete: " + why);
}

void Hdf5Reader::read_header() {
  const std::optional<std::uint64_t> version = layout::read_unsigned(file_.get(), layout::version_attribute);
  if (!version) throw InputError(path_.string() + " is an HDF5 file and no recording of tactor");
  if (*version != layout::format_version) {
    throw InputError(path_.string() + " is a recording of format " + std::to_string(*version) +
                     ", this program reads " + std::to_string(layout::format_version));
  }
  const std::optional<std::string> graph = layout::read_text(file_.get(), layout::graph_attribute);
  const std::optional<std::uint64_t> seed = layout::read_unsigned(file_.get(), layout::seed_attribute);
  const std::optional<std::string> program = layout::read_text(file_.get(), layout::tactor_version_attribute);
  const std::optional<std::uint64_t> complete = layout::read_unsigned(file_.get(), layout::complete_attribute);
  if (!graph || !seed || !program || !complete) refuse("its graph, seed or version is missing");
  header_ = {*graph, *seed, *program};
  complete_ = *complete != 0;

  const Handle group(H5Gopen2(file_.get(), layout::streams_group, H5P_DEFAULT), H5Gclose);
  H5G_info_t info{};
  if (!group || H5Gget_info(group.get(), &info) < 0) refuse("its streams are missing: " + hdf5_error());
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    std::array<char, 256> name{};
    if (H5Lget_name_by_idx(group.get(), ".", H5_INDEX_NAME, H5_ITER_INC, i, name.data(), name.size(), H5P_DEFAULT) <
        0) {
      refuse(hdf5_error());
    }
    add_stream(group.get(), name.data());
  }
}

void Hdf5Reader::add_stream(hid_t parent, const std::string& name) {
  const Handle group(H5Gopen2(parent, name.c_str(), H5P_DEFAULT), H5Gclose);
  if (!group) refuse(hdf5_error());
  const std::optional<std::string> type_name = layout::read_text(group.get(), layout::type_attribute);
  if (!type_name) refuse("stream " + name + " does not name its message type");
  const MessageType* type = find_message_type(*type_name);
  if (type == nullptr)
    refuse("stream " + name + " holds messages " + *type_name + ", which this program does not know");
  Handle data(H5Dopen2(group.get(), layout::dataset, H5P_DEFAULT), H5Dclose);
  if (!data) refuse("stream " + name + ": " + hdf5_error());
  const Handle found(H5Dget_type(data.get()), H5Tclose);
  const Handle expected = layout::record_type(*type, true);
  if (!found || H5Tequal(found.get(), expected.get()) <= 0) {
    refuse("stream " + name + " has other fields than " + *type_name + " of this program");
  }
  const Handle space(H5Dget_space(data.get()), H5Sclose);
  hsize_t count = 0;
  if (!space || H5Sget_simple_extent_ndims(space.get()) != 1 ||
      H5Sget_simple_extent_dims(space.get(), &count, nullptr) < 0) {
    refuse("stream " + name + " is no list of messages");
  }
  // A file of a few bytes may say that it holds any number; what was never written would be read as zeros.
  const std::uint64_t room = rows_with_room(data.get(), *type, fs::file_size(path_));
  if (count > room) {
    refuse("stream " + name + " says that it holds " + std::to_string(count) + " messages, and the file has room for " +
           std::to_string(room));
  }
  streams_.push_back({name, type, count});
  data_.push_back(std::move(data));
}

void Hdf5Reader::read(std::size_t stream, std::uint64_t first, std::uint64_t count, std::vector<Stamp>& stamps,
                      std::vector<std::byte>& payloads) {
  TACTOR_DEMAND(stream < streams_.size() && first + count <= streams_[stream].count);
  const MessageType& type = *streams_[stream].type;
  const std::size_t size = layout::record_size(type);
  stamps.resize(count);
  payloads.resize(count * type.size);
  records_.resize(count * size);
  if (count == 0) return;
  const hsize_t start = first;
  const hsize_t rows = count;
  const Handle memory_type = layout::record_type(type, false);
  const Handle in_file(H5Dget_space(data_[stream].get()), H5Sclose);
  const Handle in_memory(H5Screate_simple(1, &rows, nullptr), H5Sclose);
  if (H5Sselect_hyperslab(in_file.get(), H5S_SELECT_SET, &start, nullptr, &rows, nullptr) < 0 ||
      H5Dread(data_[stream].get(), memory_type.get(), in_memory.get(), in_file.get(), H5P_DEFAULT, records_.data()) <
          0) {
    refuse("stream " + streams_[stream].name + ": " + hdf5_error());
  }
  for (std::uint64_t i = 0; i < count; ++i) {
    layout::unpack(type, records_.data() + i * size, stamps[i], payloads.data() + i * type.size);
  }
}

void repair_recording(const fs::path& path) {
  // Reading it first keeps this away from files that are no recordings.
  { const Hdf5Reader reader(path); }
  if (!marked_as_being_written(path)) return;
  const int lock = lock_recording(path);
  if (lock < 0)
    throw InputError("cannot repair " + path.string() + ": it is not writable, or a run is still writing it");
  // The property that HDF5's own h5clear sets.
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  const hbool_t clear = true;
  const bool set = H5Pset(access.get(), "clear_status_flags", &clear) >= 0;
  Handle file(set ? H5Fopen(path.c_str(), H5F_ACC_RDWR, access.get()) : -1, H5Fclose);
  const bool opened = static_cast<bool>(file);
  // A writer killed amid a flush leaves a length in the superblock that is older than the data, and closing cuts the
  // file to it.
  const bool repaired = opened && H5Fincrement_filesize(file.get(), 0) >= 0 && file.reset();
  const std::string why = repaired ? std::string() : hdf5_error();
  ::close(lock);
  if (!repaired) throw InputError("cannot repair " + path.string() + ": " + why);
}

}  // namespace tactor
