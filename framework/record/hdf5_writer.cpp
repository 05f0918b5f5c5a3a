#include "framework/record/hdf5_writer.hpp"

#include <fcntl.h>
#include <sys/resource.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "framework/core/check.hpp"
#include "framework/core/message_json.hpp"
#include "framework/record/hdf5_file.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::chrono::milliseconds flush_period{500};
/// What the index of a dataset may grow by with one more chunk: the largest of its blocks for 100 GB of chunks.
constexpr std::uint64_t index_bytes = 16384;
/// What HDF5 may keep of the indices of all datasets. Appending needs the last block of each; HDF5 would keep 2 MiB and
/// fill them over a quarter of an hour.
constexpr std::size_t kept_index_bytes = std::size_t{256} << 10U;

Handle file_access() {
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  // The first format with checksums on all metadata and with readers beside the writer.
  H5Pset_libver_bounds(access.get(), H5F_LIBVER_V110, H5F_LIBVER_V110);
  // One chunk of each dataset in memory, all that appending needs, where HDF5 would keep 1 MiB. Here and not with the
  // dataset, because H5Fstart_swmr_write opens the datasets anew with the properties of the file.
  H5Pset_cache(access.get(), 0, 1, layout::chunk_bytes, 1.0);
  H5AC_cache_config_t indices{.version = H5AC__CURR_CACHE_CONFIG_VERSION};
  TACTOR_DEMAND(H5Pget_mdc_config(access.get(), &indices) >= 0);
  indices.initial_size = indices.min_size = indices.max_size = kept_index_bytes;
  indices.incr_mode = H5C_incr__off;
  indices.flash_incr_mode = H5C_flash_incr__off;
  indices.decr_mode = H5C_decr__off;
  TACTOR_DEMAND(H5Pset_mdc_config(access.get(), &indices) >= 0);
  return access;
}

/// Writes `count` records at row `first`, the end of the dataset.
bool append(hid_t data, hid_t memory_type, std::uint64_t first, std::uint64_t count, const void* records) {
  const hsize_t extent = first + count;
  if (H5Dset_extent(data, &extent) < 0) return false;
  const hsize_t start = first;
  const hsize_t rows = count;
  const Handle in_file(H5Dget_space(data), H5Sclose);
  const Handle in_memory(H5Screate_simple(1, &rows, nullptr), H5Sclose);
  return H5Sselect_hyperslab(in_file.get(), H5S_SELECT_SET, &start, nullptr, &rows, nullptr) >= 0 &&
         H5Dwrite(data, memory_type, in_memory.get(), in_file.get(), H5P_DEFAULT, records) >= 0;
}

bool read_rows(hid_t data, hid_t memory_type, std::uint64_t first, std::uint64_t count, void* records) {
  const hsize_t start = first;
  const hsize_t rows = count;
  const Handle in_file(H5Dget_space(data), H5Sclose);
  const Handle in_memory(H5Screate_simple(1, &rows, nullptr), H5Sclose);
  return H5Sselect_hyperslab(in_file.get(), H5S_SELECT_SET, &start, nullptr, &rows, nullptr) >= 0 &&
         H5Dread(data, memory_type, in_memory.get(), in_file.get(), H5P_DEFAULT, records) >= 0;
}

std::string stream_path(const std::string& stream) {
  return std::string(layout::streams_group).append("/").append(stream);
}

}  // namespace

RecordingLock::RecordingLock(const fs::path& path, bool make, const std::string& doing)
    : file_(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC | (make ? O_CREAT : 0), 0666)) {
  if (!file_) {
    throw InputError(doing + ": " + std::strerror(errno) + "; give a file in a folder that exists and can be written");
  }
  // HDF5's own lock is released in the mode with readers beside the writer.
  if (!lock_.take(file_.number(), path, LockKind::beside)) {
    throw InputError(doing + ": another run is writing it" + lock_.holder());
  }
}

bool is_being_written(const fs::path& path) {
  if (hdf5_lock_of(path, LockKind::shared) == LockAnswer::busy) return true;
  const FileDescriptor file(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
  WriteLock lock;
  return file && !lock.take(file.number(), path, LockKind::beside);
}

Hdf5Recorder::Hdf5Recorder(fs::path path, RecordingHeader header)
    : path_(std::move(path)), header_(std::move(header)), lock_(path_, true, "cannot record to " + path_.string()) {
  silence_hdf5();
  // Created at once, so that a path that cannot be written is found before the run starts.
  file_ = create_hdf5(path_, file_access());
  if (file_) return;
  const std::string why = hdf5_error();
  throw InputError("cannot record to " + path_.string() + ": " +
                   (hdf5_lock_of(path_, LockKind::whole) == LockAnswer::busy
                        ? "another program has it open; end that one first"
                        : why));
}

Hdf5Recorder::~Hdf5Recorder() {
  if (state_ == State::writing) {
    // What can be saved is saved; an error here has no one to be told to.
    try {
      flush();
    } catch (const RunError&) {
    }
  }
  streams_.clear();
}

void Hdf5Recorder::fail(const char* doing) const {
  throw RunError(std::string(doing) + " the recording " + path_.string() + " failed: " + hdf5_error());
}

std::size_t Hdf5Recorder::add_stream(std::string_view name, const MessageType& type) {
  TACTOR_DEMAND(state_ == State::declaring);
  TACTOR_DEMAND(!name.empty() && name.find('/') == std::string_view::npos);
  for (const Stream& stream : streams_) TACTOR_DEMAND(stream.name != name);
  Stream stream{.name = std::string(name), .type = &type, .layout = PackedLayout(type.fields)};
  const std::string path = stream_path(stream.name) + "/";
  const auto make_rows = [](std::string to, Handle file_type, Handle memory_type) {
    Rows rows{.path = std::move(to), .file_type = std::move(file_type), .memory_type = std::move(memory_type)};
    rows.row_bytes = H5Tget_size(rows.memory_type.get());
    rows.bytes.reserve(layout::chunk_rows(rows.row_bytes) * rows.row_bytes);
    return rows;
  };
  stream.messages = make_rows(path + layout::dataset, layout::row_type(type, true), layout::row_type(type, false));
  TACTOR_DEMAND(stream.messages.row_bytes == layout::stamp_size + stream.layout.size());
  for (std::size_t i = 0; i < stream.layout.arrays().size(); ++i) {
    const Field& field = *stream.layout.arrays()[i];
    stream.arrays.push_back(make_rows(path + layout::arrays_group + "/" + stream.layout.array_paths()[i],
                                      layout::element_type(field, true), layout::element_type(field, false)));
    stream.elements.emplace_back(std::vector<Field>{element_of(field)});
  }
  streams_.push_back(std::move(stream));
  return streams_.size() - 1;
}

void Hdf5Recorder::make_groups(hid_t file, const Stream& stream) const {
  const Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation.get(), false);
  const std::string path = stream_path(stream.name);
  const Handle group(H5Gcreate2(file, path.c_str(), H5P_DEFAULT, creation.get(), H5P_DEFAULT), H5Gclose);
  if (!group || !layout::write_text(group.get(), layout::type_attribute, stream.type->name) ||
      !layout::write_text(group.get(), layout::frame_attribute, stream.type->frame) ||
      !layout::write_text(group.get(), layout::time_unit_attribute, "ns") ||
      !layout::write_text(group.get(), layout::description_attribute, to_json(*stream.type))) {
    fail("writing");
  }
  if (stream.arrays.empty()) return;
  const Handle arrays(H5Gcreate2(group.get(), layout::arrays_group, H5P_DEFAULT, creation.get(), H5P_DEFAULT),
                      H5Gclose);
  if (!arrays) fail("writing");
}

Handle Hdf5Recorder::make_data(hid_t file, const Rows& rows, bool final) const {
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties.get(), false);
  const hsize_t chunk = layout::chunk_rows(rows.row_bytes);
  H5Pset_chunk(properties.get(), 1, &chunk);
  if (final) {
    // Level 1: most of the gain for a tenth of the time; the checksum tells a damaged disk from data.
    H5Pset_shuffle(properties.get());
    H5Pset_deflate(properties.get(), 1);
    H5Pset_fletcher32(properties.get());
  }
  const hsize_t none = 0;
  const hsize_t unlimited = H5S_UNLIMITED;
  const Handle space(H5Screate_simple(1, &none, &unlimited), H5Sclose);
  Handle data(H5Dcreate2(file, rows.path.c_str(), rows.file_type.get(), space.get(), H5P_DEFAULT, properties.get(),
                         H5P_DEFAULT),
              H5Dclose);
  if (!data) fail("writing");
  return data;
}

Handle Hdf5Recorder::make_file(const fs::path& path, bool final) const {
  const Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation.get(), false);
  Handle file = create_hdf5(path, file_access(), creation.get());
  if (!file) fail("writing");
  const Handle group_creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
  H5Pset_obj_track_times(group_creation.get(), false);
  const Handle group(H5Gcreate2(file.get(), layout::streams_group, H5P_DEFAULT, group_creation.get(), H5P_DEFAULT),
                     H5Gclose);
  if (!group || !layout::write_integer(file.get(), layout::version_attribute, layout::format_version) ||
      !layout::write_text(file.get(), layout::graph_attribute, header_.graph) ||
      !layout::write_unsigned(file.get(), layout::seed_attribute, header_.seed) ||
      !layout::write_text(file.get(), layout::tactor_version_attribute, header_.version) ||
      !layout::write_integer(file.get(), layout::complete_attribute, final ? 1 : 0)) {
    fail("writing");
  }
  if (!header_.provenance.empty() &&
      !layout::write_text(file.get(), layout::provenance_attribute, header_.provenance)) {
    fail("writing");
  }
  return file;
}

void Hdf5Recorder::start() {
  file_.reset();
  file_ = make_file(path_, false);
  for (Stream& stream : streams_) {
    make_groups(file_.get(), stream);
    stream.messages.data = make_data(file_.get(), stream.messages, false);
    for (Rows& array : stream.arrays) array.data = make_data(file_.get(), array, false);
  }
  if (H5Fstart_swmr_write(file_.get()) < 0) fail("writing");
  state_ = State::writing;
  flushed_ = std::chrono::steady_clock::now();
}

void Hdf5Recorder::reserve(std::uint64_t more) {
  const std::uint64_t bytes = unflushed_ + more;
  hsize_t size = 0;
  if (H5Fget_filesize(file_.get(), &size) < 0) return;
  int error = 0;
  rlimit limit{};
  if (getrlimit(RLIMIT_FSIZE, &limit) == 0 && size + bytes > limit.rlim_cur) {
    error = EFBIG;
  } else {
    do {
      const auto begin = static_cast<off_t>(size);
      error = ::fallocate(lock_.file(), FALLOC_FL_KEEP_SIZE, begin, static_cast<off_t>(bytes)) == 0 ? 0 : errno;
    } while (error == EINTR);
  }
  // Any other answer is of a file system that cannot reserve; there a full disk is found out in the middle of writing.
  if (error != ENOSPC && error != EDQUOT && error != EFBIG) {
    unflushed_ = bytes;
    return;
  }
  throw RunError("writing the recording " + path_.string() + " failed: " + std::strerror(error) +
                 "; what came before is in it");
}

void Hdf5Recorder::write_buffered(Stream& stream) {
  // The elements first, so that a message in the file has its arrays there too.
  for (Rows& array : stream.arrays) write_rows(array);
  write_rows(stream.messages);
}

void Hdf5Recorder::write_rows(Rows& rows) {
  if (rows.buffered == 0) return;
  const std::uint64_t chunk = layout::chunk_rows(rows.row_bytes);
  const std::uint64_t chunks = (rows.written + rows.buffered - 1) / chunk - rows.written / chunk + 1;
  reserve(chunks * (chunk * rows.row_bytes + index_bytes));
  if (!append(rows.data.get(), rows.memory_type.get(), rows.written, rows.buffered, rows.bytes.data())) fail("writing");
  rows.written += rows.buffered;
  rows.buffered = 0;
  rows.bytes.clear();
}

std::uint64_t Hdf5Recorder::add_elements(Rows& rows, const PackedLayout& layout, std::size_t stride,
                                         const SharedBytes& elements) {
  const std::uint64_t first = rows.written + rows.buffered;
  const auto no_array = [](std::size_t, const SharedBytes&) -> std::uint64_t { return 0; };
  for (std::size_t i = 0; i < elements.count(); ++i) {
    rows.bytes.resize(rows.bytes.size() + rows.row_bytes);
    layout.pack(elements.elements() + i * stride, rows.bytes.data() + rows.bytes.size() - rows.row_bytes, no_array);
  }
  rows.buffered += elements.count();
  return first;
}

void Hdf5Recorder::write(std::size_t index, const Stamp& stamp, const void* payload) {
  TACTOR_DEMAND(state_ != State::closed && index < streams_.size());
  if (state_ == State::declaring) start();
  Stream& stream = streams_[index];
  Rows& messages = stream.messages;
  const std::size_t at = messages.bytes.size();
  messages.bytes.resize(at + messages.row_bytes);
  std::byte* row = messages.bytes.data() + at;
  std::memcpy(row, &stamp.valid.ns, 8);
  std::memcpy(row + 8, &stamp.produced.ns, 8);
  std::memcpy(row + 16, &stamp.sequence, 8);
  bool large = false;
  const auto add = [&](std::size_t array, const SharedBytes& elements) {
    const Field& field = *stream.layout.arrays()[array];
    const std::uint64_t first =
        add_elements(stream.arrays[array], stream.elements[array], count_of(field) * element_size(field), elements);
    large = large || stream.arrays[array].bytes.size() >= layout::chunk_bytes;
    return first;
  };
  stream.layout.pack(static_cast<const std::byte*>(payload), row + layout::stamp_size, add);
  ++messages.buffered;
  if (large || (messages.written + messages.buffered) % layout::chunk_rows(messages.row_bytes) == 0) {
    write_buffered(stream);
  }
  if (std::chrono::steady_clock::now() - flushed_ >= flush_period) flush();
}

void Hdf5Recorder::flush() {
  TACTOR_DEMAND(state_ != State::closed);
  if (state_ == State::declaring) start();
  for (Stream& stream : streams_) write_buffered(stream);
  if (H5Fflush(file_.get(), H5F_SCOPE_LOCAL) < 0) fail("writing");
  unflushed_ = 0;
  flushed_ = std::chrono::steady_clock::now();
}

void Hdf5Recorder::copy_rows(hid_t from, hid_t to, Rows& rows) const {
  const std::uint64_t chunk = layout::chunk_rows(rows.row_bytes);
  const Handle source(H5Dopen2(from, rows.path.c_str(), H5P_DEFAULT), H5Dclose);
  if (!source) fail("reading back");
  Handle data = make_data(to, rows, true);
  rows.bytes.resize(chunk * rows.row_bytes);
  for (std::uint64_t first = 0; first < rows.written; first += chunk) {
    const std::uint64_t count = std::min(chunk, rows.written - first);
    if (!read_rows(source.get(), rows.memory_type.get(), first, count, rows.bytes.data())) fail("reading back");
    if (!append(data.get(), rows.memory_type.get(), first, count, rows.bytes.data())) fail("compressing");
  }
  if (!data.reset()) fail("compressing");
}

void Hdf5Recorder::rewrite_compressed(const fs::path& to) {
  const Handle from = open_hdf5(path_, H5F_ACC_RDONLY, usual_access());
  if (!from) fail("reading back");
  Handle file = make_file(to, true);
  for (Stream& stream : streams_) {
    make_groups(file.get(), stream);
    copy_rows(from.get(), file.get(), stream.messages);
    for (Rows& array : stream.arrays) copy_rows(from.get(), file.get(), array);
  }
  if (!file.reset()) fail("compressing");
}

void Hdf5Recorder::close() {
  flush();
  state_ = State::closed;
  bool closed = true;
  for (Stream& stream : streams_) {
    closed = stream.messages.data.reset() && closed;
    for (Rows& array : stream.arrays) closed = array.data.reset() && closed;
  }
  if (!file_.reset() || !closed) fail("closing");
  fs::path temporary = path_;
  temporary += ".tmp";
  try {
    rewrite_compressed(temporary);
    fs::rename(temporary, path_);
  } catch (const fs::filesystem_error& e) {
    throw RunError("finishing the recording " + path_.string() + " failed: " + e.code().message());
  } catch (const RunError&) {
    // The uncompressed file is whole and stays.
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw;
  }
}

}  // namespace tactor
