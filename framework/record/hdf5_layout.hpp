// The layout of recordings in HDF5, shared by writer and reader: names, record types, attributes.
//
// - `/`: attributes tactor_recording (format version), graph, seed, tactor_version, provenance (JSON; may be missing),
//   complete
// - `/streams/<node.port>`: attributes message_type, frame, time_unit, description (see message_json.hpp)
// - `/streams/<node.port>/data`: one row a message: valid_ns, produced_ns, sequence, then the fields of the message
// - `/streams/<node.port>/arrays/<path>`: the elements of a field that changes size, of all messages one after the
//   other; the row holds `first` and `count`
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/message.hpp"
#include "framework/record/hdf5_handle.hpp"

namespace tactor::layout {

inline constexpr std::int64_t format_version = 2;
inline constexpr const char* version_attribute = "tactor_recording";
inline constexpr const char* graph_attribute = "graph";
inline constexpr const char* seed_attribute = "seed";
inline constexpr const char* tactor_version_attribute = "tactor_version";
inline constexpr const char* provenance_attribute = "provenance";
inline constexpr const char* complete_attribute = "complete";
inline constexpr const char* streams_group = "streams";
inline constexpr const char* type_attribute = "message_type";
inline constexpr const char* frame_attribute = "frame";
inline constexpr const char* time_unit_attribute = "time_unit";
inline constexpr const char* description_attribute = "description";
inline constexpr const char* dataset = "data";
inline constexpr const char* arrays_group = "arrays";

/// Bytes of the stamps at the front of a record.
inline constexpr std::size_t stamp_size = 24;

constexpr std::size_t chunk_bytes = std::size_t{128} << 10U;  ///< the most that a chunk of several rows has
/// Rows of `row_bytes` in a chunk: about `chunk_bytes`, at most 1024.
std::uint64_t chunk_rows(std::size_t row_bytes);

/// The compound type of a row of messages; little-endian in the file, native in memory, otherwise the same.
/// Enumerations have their names in it.
Handle row_type(const MessageType& type, bool in_file);
/// The type of a row of elements of a field that changes size.
Handle element_type(const Field& field, bool in_file);

/// Write an attribute; false where HDF5 could not.
bool write_text(hid_t object, const char* name, std::string_view text);
bool write_integer(hid_t object, const char* name, std::int64_t value);
bool write_unsigned(hid_t object, const char* name, std::uint64_t value);

/// Read an attribute; nothing where it is not there or of another type.
std::optional<std::string> read_text(hid_t object, const char* name);
std::optional<std::uint64_t> read_unsigned(hid_t object, const char* name);

}  // namespace tactor::layout
