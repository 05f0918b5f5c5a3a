#include "framework/record/hdf5_reader.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <limits>

#include "framework/core/check.hpp"
#include "framework/core/input_file.hpp"
#include "framework/core/message_json.hpp"
#include "framework/record/hdf5_file.hpp"
#include "framework/record/hdf5_writer.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// Bytes that one reading may take of a file of any size: a million messages of the kinds that devices have.
constexpr std::uint64_t most_packed = std::uint64_t{512} << 20U;

/// True where the superblock says that a writer has the file in the mode that allows readers beside it.
bool marked_as_being_written(const fs::path& path) {
  constexpr std::size_t flags_at = 11;
  constexpr int writing_beside_readers = 0x01 | 0x04;
  std::array<char, flags_at + 1> head{};
  std::ifstream in(path, std::ios::binary);
  return in.read(head.data(), head.size()) && (head[flags_at] & writing_beside_readers) == writing_beside_readers;
}

/// Streams of a recording at most; a link that leads to one takes few bytes.
constexpr hsize_t most_streams = 1024;

/// Whether each step of the path is in this file. Others lead to files, or to pipes, that are not ours to open.
bool is_inside(hid_t parent, const std::string& path) {
  for (std::size_t end = 0; end != std::string::npos;) {
    end = path.find('/', end + 1);
    H5L_info_t link{};
    if (H5Lget_info(parent, path.substr(0, end).c_str(), &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
      return false;
  }
  return true;
}

/// Whether a dataset is packed as ours are, or not at all: a packed text that is packed again grows a millionfold.
bool is_packed_once(hid_t properties) {
  int packed = 0;
  for (int i = 0; i < H5Pget_nfilters(properties); ++i) {
    unsigned flags = 0, config = 0;
    std::size_t values = 0;
    const H5Z_filter_t filter =
        H5Pget_filter2(properties, static_cast<unsigned>(i), &flags, &values, nullptr, 0, nullptr, &config);
    if (filter != H5Z_FILTER_DEFLATE && filter != H5Z_FILTER_SHUFFLE && filter != H5Z_FILTER_FLETCHER32) return false;
    packed += filter == H5Z_FILTER_DEFLATE ? 1 : 0;
  }
  return packed <= 1;
}

/// The most rows that the bytes of a dataset in the file can hold. `chunk_rows`: those of a chunk, 0 without chunks.
std::uint64_t rows_with_room(hid_t data, std::uint64_t record, std::uint64_t file_size, std::uint64_t& chunk_rows) {
  // What a writer that was killed had given out and not written yet.
  constexpr std::uint64_t unwritten = std::uint64_t{16} << 20U;
  if (H5Dget_storage_size(data) > file_size + unwritten) return 0;
  const Handle properties(H5Dget_create_plist(data), H5Pclose);
  if (!properties || H5Pget_external_count(properties.get()) != 0) return 0;
  switch (H5Pget_layout(properties.get())) {
    case H5D_CHUNKED: {
      const Handle space(H5Dget_space(data), H5Sclose);
      hsize_t rows = 0, chunks = 0;
      if (H5Pget_chunk(properties.get(), 1, &rows) != 1 || rows == 0) return 0;
      // HDF5 unpacks a whole chunk for a row, again and again where it is larger than what is kept.
      if (rows > layout::chunk_rows(record)) return 0;
      if (!is_packed_once(properties.get())) return 0;
      chunk_rows = rows;
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

/// True where a field, or one of a record, is an enumeration.
bool has_enumerations(const std::vector<Field>& fields) {
  return std::any_of(fields.begin(), fields.end(),
                     [](const Field& f) { return !f.enumerators.empty() || has_enumerations(f.fields); });
}

std::int64_t integer_at(FieldKind kind, const std::byte* at) {
  const auto read = [at]<class T>(T value) {
    std::memcpy(&value, at, sizeof value);
    return static_cast<std::int64_t>(value);
  };
  switch (kind) {
    case FieldKind::i8:
      return read(std::int8_t{});
    case FieldKind::u8:
      return read(std::uint8_t{});
    case FieldKind::i16:
      return read(std::int16_t{});
    case FieldKind::u16:
      return read(std::uint16_t{});
    case FieldKind::i32:
      return read(std::int32_t{});
    case FieldKind::u32:
      return read(std::uint32_t{});
    default:
      return read(std::int64_t{});
  }
}

/// The first field of an enumeration whose value is none of its own; null where there is none.
const Field* field_without_name(const std::vector<Field>& fields, const std::byte* value) {
  for (const Field& field : fields) {
    const std::byte* at = value + field.offset;
    std::size_t count = count_of(field);
    if (field.changes_size) {
      const auto& elements = *reinterpret_cast<const SharedBytes*>(at);
      at = elements.elements();
      count *= elements.count();
    }
    if (field.enumerators.empty() && !has_enumerations(field.fields)) continue;
    const std::size_t size = element_size(field);
    for (std::size_t i = 0; i < count; ++i, at += size) {
      if (field.kind == FieldKind::record) {
        if (const Field* found = field_without_name(field.fields, at)) return found;
        continue;
      }
      const std::int64_t number = integer_at(field.kind, at);
      const auto named = [number](const Enumerator& one) { return one.value == number; };
      if (std::none_of(field.enumerators.begin(), field.enumerators.end(), named)) return &field;
    }
  }
  return nullptr;
}

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
    if (is_being_written(path_)) refuse({});
    throw InputError(path_.string() +
                     " is not an HDF5 file (or its beginning is damaged); a recording of tactor is expected");
  }
  file_ = open_hdf5(path_, H5F_ACC_RDONLY, usual_access());
  if (!file_) {
    const std::string why = hdf5_error();
    if (marked_as_being_written(path_)) {
      file_ = open_hdf5(path_, H5F_ACC_RDONLY | H5F_ACC_SWMR_READ, few_attempts());
    }
    if (!file_) refuse(why);
  }
  read_header();
}

void Hdf5Reader::refuse(const std::string& why) const {
  if (is_being_written(path_)) {
    throw InputError("the recording " + path_.string() +
                     " is being written by another program; read it when that one has ended");
  }
  throw InputError("the recording " + path_.string() + " is damaged or incomplete: " + why);
}

void Hdf5Reader::read_header() {
  const std::optional<std::uint64_t> version = layout::read_unsigned(file_.get(), layout::version_attribute);
  if (!version) throw InputError(path_.string() + " is an HDF5 file, but not a recording of tactor");
  if (*version != layout::format_version) {
    throw InputError(path_.string() + " is a recording of format " + std::to_string(*version) +
                     ", this program reads " + std::to_string(layout::format_version));
  }
  const std::optional<std::string> graph = layout::read_text(file_.get(), layout::graph_attribute);
  const std::optional<std::uint64_t> seed = layout::read_unsigned(file_.get(), layout::seed_attribute);
  const std::optional<std::string> program = layout::read_text(file_.get(), layout::tactor_version_attribute);
  const std::optional<std::uint64_t> complete = layout::read_unsigned(file_.get(), layout::complete_attribute);
  if (!graph || !seed || !program || !complete) refuse("its graph, seed or version is missing");
  header_ = {*graph, *seed, *program, layout::read_text(file_.get(), layout::provenance_attribute).value_or("")};
  complete_ = *complete != 0;

  if (!is_inside(file_.get(), layout::streams_group)) refuse("its streams are missing or in another file");
  const Handle group(H5Gopen2(file_.get(), layout::streams_group, H5P_DEFAULT), H5Gclose);
  H5G_info_t info{};
  if (!group || H5Gget_info(group.get(), &info) < 0) refuse("its streams are missing: " + hdf5_error());
  if (info.nlinks > most_streams) {
    refuse("it has " + std::to_string(info.nlinks) + " streams, more than " + std::to_string(most_streams));
  }
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    std::array<char, 256> name{};
    if (H5Lget_name_by_idx(group.get(), ".", H5_INDEX_NAME, H5_ITER_INC, i, name.data(), name.size(), H5P_DEFAULT) <
        0) {
      refuse(hdf5_error());
    }
    add_stream(group.get(), name.data());
  }
}

Hdf5Reader::Rows Hdf5Reader::open_rows(hid_t group, const std::string& path, const std::string& stream,
                                       Handle file_type, Handle memory_type) const {
  if (!is_inside(group, path)) refuse("stream " + stream + ": its " + path + " is missing or in another file");
  Rows rows{.data = Handle(H5Dopen2(group, path.c_str(), H5P_DEFAULT), H5Dclose),
            .memory_type = std::move(memory_type)};
  if (!rows.data) refuse("stream " + stream + ": " + hdf5_error());
  const Handle found(H5Dget_type(rows.data.get()), H5Tclose);
  if (!found || H5Tequal(found.get(), file_type.get()) <= 0) {
    refuse("stream " + stream + ": its " + path + " has fields that differ from its description");
  }
  rows.row_bytes = H5Tget_size(rows.memory_type.get());
  const Handle space(H5Dget_space(rows.data.get()), H5Sclose);
  hsize_t count = 0;
  if (!space || H5Sget_simple_extent_ndims(space.get()) != 1 ||
      H5Sget_simple_extent_dims(space.get(), &count, nullptr) < 0) {
    refuse("stream " + stream + ": its " + path + " is no list");
  }
  // A file of a few bytes may say that it holds any number; what was never written would be read as zeros.
  const std::uint64_t room = rows_with_room(rows.data.get(), rows.row_bytes, fs::file_size(path_), rows.chunk_rows);
  if (count > room) {
    refuse("stream " + stream + " says that it holds " + std::to_string(count) +
           " messages, and the file has room for " + std::to_string(room));
  }
  rows.count = count;
  return rows;
}

void Hdf5Reader::add_stream(hid_t parent, const std::string& name) {
  if (!is_inside(parent, name)) refuse("stream " + name + " is in another file");
  const Handle group(H5Gopen2(parent, name.c_str(), H5P_DEFAULT), H5Gclose);
  if (!group) refuse(hdf5_error());
  const std::optional<std::string> description = layout::read_text(group.get(), layout::description_attribute);
  if (!description) refuse("stream " + name + " does not describe its messages");
  MessageType type;
  try {
    type = message_type_from_json(*description);
  } catch (const InputError& error) {
    refuse("stream " + name + ": " + error.what());
  }
  // The layouts point at the fields of the type, which stay where they are when the list grows.
  static_assert(std::is_nothrow_move_constructible_v<RecordedStream>);
  streams_.push_back({name, std::move(type), 0});
  const MessageType& messages = streams_.back().type;
  Stream stream{.messages = open_rows(group.get(), layout::dataset, name, layout::row_type(messages, true),
                                      layout::row_type(messages, false)),
                .layout = PackedLayout(messages.fields),
                .has_enumerations = has_enumerations(messages.fields)};
  for (std::size_t i = 0; i < stream.layout.arrays().size(); ++i) {
    const Field& field = *stream.layout.arrays()[i];
    const std::string path = std::string(layout::arrays_group) + "/" + stream.layout.array_paths()[i];
    stream.arrays.push_back(
        {open_rows(group.get(), path, name, layout::element_type(field, true), layout::element_type(field, false)),
         PackedLayout({element_of(field)}), count_of(field) * element_size(field)});
  }
  streams_.back().count = whole_messages(name, stream);
  open_.push_back(std::move(stream));
}

std::uint64_t Hdf5Reader::whole_messages(const std::string& name, const Stream& stream) {
  std::uint64_t count = stream.messages.count;
  if (complete_ || stream.arrays.empty()) return count;
  std::vector<std::byte> message(streams_.back().type.size);
  for (; count > 0; --count) {
    read_rows(name, stream.messages, count - 1, 1, bytes_);
    bool whole = true;
    const auto check = [&](std::size_t array, std::uint64_t first, std::uint64_t elements) {
      const std::uint64_t there = stream.arrays[array].rows.count;
      whole = whole && first <= there && elements <= there - first;
      return SharedBytes();
    };
    stream.layout.unpack(bytes_.data() + layout::stamp_size, message.data(), check);
    if (whole) break;
  }
  return count;
}

void Hdf5Reader::read_rows(const std::string& name, const Rows& rows, std::uint64_t first, std::uint64_t count,
                           std::vector<std::byte>& bytes) const {
  bytes.resize(count * rows.row_bytes);
  if (count == 0) return;
  const hsize_t start = first;
  const hsize_t length = count;
  if (rows.chunk_rows > 0) {
    // HDF5 unpacks all that the bytes of a chunk hold, however much that is. Packing never makes them many more.
    const std::uint64_t bytes_of_chunk = rows.chunk_rows * rows.row_bytes;
    for (hsize_t chunk = first / rows.chunk_rows * rows.chunk_rows; chunk < first + count; chunk += rows.chunk_rows) {
      unsigned filters = 0;
      haddr_t at = 0;
      hsize_t packed = 0;
      if (H5Dget_chunk_info_by_coord(rows.data.get(), &chunk, &filters, &at, &packed) < 0) {
        refuse("stream " + name + ": " + hdf5_error());
      }
      if (packed > bytes_of_chunk + bytes_of_chunk / 100 + 1024) {
        refuse("stream " + name + ": a part of it holds more than its rows");
      }
    }
  }
  const Handle in_file(H5Dget_space(rows.data.get()), H5Sclose);
  const Handle in_memory(H5Screate_simple(1, &length, nullptr), H5Sclose);
  if (H5Sselect_hyperslab(in_file.get(), H5S_SELECT_SET, &start, nullptr, &length, nullptr) < 0 ||
      H5Dread(rows.data.get(), rows.memory_type.get(), in_memory.get(), in_file.get(), H5P_DEFAULT, bytes.data()) < 0) {
    refuse("stream " + name + ": " + hdf5_error());
  }
}

void Hdf5Reader::take(ReadBudget& budget, const std::string& name, std::uint64_t count,
                      std::uint64_t bytes_each) const {
  // Divided, because the product of what a file says may wrap.
  const bool fits = count == 0 || (bytes_each <= budget.bytes() / count && budget.holds(count * bytes_each));
  if (!fits) throw InputError("the recording " + path_.string() + ": stream " + name + ": " + budget.refusal());
}

SharedBytes Hdf5Reader::read_array(const std::string& name, const ArrayRows& array, std::uint64_t first,
                                   std::uint64_t count, ReadBudget& budget) const {
  if (first > array.rows.count || count > array.rows.count - first) {
    refuse("stream " + name + ": a message has elements " + std::to_string(first) + " to " +
           std::to_string(first + count) + " of " + std::to_string(array.rows.count));
  }
  if (count == 0) return {};
  take(budget, name, count, array.rows.row_bytes + array.stride);
  std::vector<std::byte> packed;
  read_rows(name, array.rows, first, count, packed);
  ArrayBlock* block = allocate_array(count, array.stride);
  SharedBytes elements(block);
  const auto no_array = [](std::size_t, std::uint64_t, std::uint64_t) { return SharedBytes(); };
  for (std::uint64_t i = 0; i < count; ++i) {
    // Padding is zero.
    std::memset(block->elements() + i * array.stride, 0, array.stride);
    array.element.unpack(packed.data() + i * array.rows.row_bytes, block->elements() + i * array.stride, no_array);
  }
  return elements;
}

void Hdf5Reader::read(std::size_t index, std::uint64_t first, std::uint64_t count, MessageBatch& out) {
  TACTOR_DEMAND(index < streams_.size() && first + count <= streams_[index].count);
  const RecordedStream& info = streams_[index];
  const Stream& stream = open_[index];
  TACTOR_DEMAND(same_type(out.type(), info.type));
  // Many messages may name the same elements, and zeros pack a thousandfold.
  ReadBudget budget(path_.string(), fs::file_size(path_), most_packed);
  take(budget, info.name, count, stream.messages.row_bytes + sizeof(Stamp) + info.type.size);
  read_rows(info.name, stream.messages, first, count, bytes_);
  out.reserve(out.size() + count);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::byte* row = bytes_.data() + i * stream.messages.row_bytes;
    Stamp stamp;
    std::memcpy(&stamp.valid.ns, row, 8);
    std::memcpy(&stamp.produced.ns, row + 8, 8);
    std::memcpy(&stamp.sequence, row + 16, 8);
    out.add(stamp);
    std::byte* value = out.value(out.size() - 1);
    stream.layout.unpack(row + layout::stamp_size, value,
                         [&](std::size_t array, std::uint64_t begin, std::uint64_t elements) {
                           return read_array(info.name, stream.arrays[array], begin, elements, budget);
                         });
    if (!stream.has_enumerations) continue;
    if (const Field* field = field_without_name(info.type.fields, value)) {
      refuse("stream " + info.name + ": " + field->name + " has a value that its enumeration does not have");
    }
  }
}

void repair_recording(const fs::path& path) {
  // Reading it first keeps this away from files that are no recordings.
  { const Hdf5Reader reader(path); }
  if (!marked_as_being_written(path)) return;
  const RecordingLock lock(path, false, "cannot repair " + path.string());
  // The property that HDF5's own h5clear sets.
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  const hbool_t clear = true;
  const bool set = H5Pset(access.get(), "clear_status_flags", &clear) >= 0;
  Handle file = set ? open_hdf5(path, H5F_ACC_RDWR, access) : Handle();
  const bool opened = static_cast<bool>(file);
  // A writer killed amid a flush leaves a length in the superblock that is older than the data, and closing cuts the
  // file to it.
  const bool repaired = opened && H5Fincrement_filesize(file.get(), 0) >= 0 && file.reset();
  const std::string why = repaired ? std::string() : hdf5_error();
  if (repaired) return;
  throw InputError("cannot repair " + path.string() + ": " +
                   (!opened && hdf5_lock_of(path, LockKind::whole) == LockAnswer::busy
                        ? "another program has it open; end that one first"
                        : why));
}

}  // namespace tactor
