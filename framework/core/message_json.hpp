// Message types as JSON: what recordings keep of each stream, and what programs that know no C++ struct read.
#pragma once

#include <string>
#include <string_view>

#include "framework/core/message.hpp"

namespace tactor {

/// `f64`, `record`.
std::string_view name_of(FieldKind kind);

/// The type on one line:
///
///     {"name":"Wrench","frame":"W","fields":[{"name":"force","unit":"N","kind":"f64","shape":[3]}, ...]}
///
/// A field tells its frame where it is another than the type's, `"changes_size":true` for a SharedArray,
/// `"enumerators":{"none":0, ...}` for an enumeration, and for kind "record" the name in `record` and its `fields`.
/// A time is an i64 in ns. Docs are left out, so that recordings do not change with a sentence.
std::string to_json(const MessageType& type);
/// The same with the docs, for readers of the schema: `doc` of the type and of each field, and `docs` of enumerators by
/// their names; those that are empty are left out.
std::string to_documented_json(const MessageType& type);

/// The type that such a text describes, laid out, without docs. Throws InputError with what is wrong where it describes
/// none.
MessageType message_type_from_json(std::string_view text);

}  // namespace tactor
