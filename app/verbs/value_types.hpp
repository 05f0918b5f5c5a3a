// What options and arguments take, by the words that help, reference and completion show: `GRAPH`. Several kinds stand
// side by side with `|` between them; a word in lower case stands for itself: `mouse|graph`.
#pragma once

namespace tactor::value_type {

inline constexpr const char* graph = "GRAPH";                ///< a graph file, or the name of a shipped one
inline constexpr const char* study = "STUDY";                ///< a study file, or the name of a shipped one
inline constexpr const char* method = "METHOD";              ///< a file that is laid over a graph, or a shipped one
inline constexpr const char* mesh = "MESH";                  ///< a mesh file, or the name of a shipped one
inline constexpr const char* recording = "RECORDING";        ///< an HDF5 file
inline constexpr const char* results = "RESULT";             ///< a folder of results, or its page
inline constexpr const char* node_type = "NODE_TYPE";        ///< `prediction.ar`
inline constexpr const char* message_type = "MESSAGE_TYPE";  ///< `Wrench`
inline constexpr const char* file = "FILE";
inline constexpr const char* folder = "FOLDER";
inline constexpr const char* name = "NAME";
inline constexpr const char* port = "PORT";
inline constexpr const char* address = "ADDRESS";  ///< an IPv4 address
inline constexpr const char* origin = "ORIGIN";    ///< of a web page: `https://app.foxglove.dev`

}  // namespace tactor::value_type
