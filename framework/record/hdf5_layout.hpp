// The layout of recordings in HDF5, shared by writer and reader: names, record types, attributes.
//
// /                         attributes: tactor_recording (format version), graph, seed, tactor_version, complete
// /streams/<node.port>      attributes: message_type, frame, time_unit, fields, units
// /streams/<node.port>/data one row a message: valid_ns, produced_ns, sequence, then the fields of the message
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/message.hpp"
#include "framework/record/hdf5_handle.hpp"

namespace tactor::layout {

inline constexpr std::int64_t format_version = 1;
inline constexpr const char* version_attribute = "tactor_recording";
inline constexpr const char* graph_attribute = "graph";
inline constexpr const char* seed_attribute = "seed";
inline constexpr const char* tactor_version_attribute = "tactor_version";
inline constexpr const char* complete_attribute = "complete";
inline constexpr const char* streams_group = "streams";
inline constexpr const char* type_attribute = "message_type";
inline constexpr const char* frame_attribute = "frame";
inline constexpr const char* time_unit_attribute = "time_unit";
inline constexpr const char* fields_attribute = "fields";
inline constexpr const char* units_attribute = "units";
inline constexpr const char* dataset = "data";

/// Bytes of the stamps at the front of a record.
inline constexpr std::size_t stamp_size = 24;

/// Bytes of a field in a record.
std::size_t field_size(const Field& field);
/// Bytes of a record: the stamps and the fields, without the padding of the struct.
std::size_t record_size(const MessageType& type);
constexpr std::size_t chunk_bytes = std::size_t{128} << 10U;  ///< the most that a chunk of several messages has
/// Messages in a chunk: about `chunk_bytes`, at most 1024 messages.
std::uint64_t chunk_rows(const MessageType& type);

/// The compound type of a record; little-endian in the file, native in memory, otherwise the same.
Handle record_type(const MessageType& type, bool in_file);

/// Appends the record of a message to `records`, and the other way round.
void pack(const MessageType& type, const Stamp& stamp, const void* payload, std::vector<std::byte>& records);
void unpack(const MessageType& type, const std::byte* record, Stamp& stamp, std::byte* payload);

/// Write an attribute; false where HDF5 could not.
bool write_text(hid_t object, const char* name, std::string_view text);
bool write_texts(hid_t object, const char* name, const std::vector<std::string_view>& texts);
bool write_integer(hid_t object, const char* name, std::int64_t value);
bool write_unsigned(hid_t object, const char* name, std::uint64_t value);

/// Read an attribute; nothing where it is not there or of another type.
std::optional<std::string> read_text(hid_t object, const char* name);
std::optional<std::uint64_t> read_unsigned(hid_t object, const char* name);

}  // namespace tactor::layout
