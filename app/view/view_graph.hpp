// Runs a graph live while pages look at it and lead its device.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "framework/graph/spec.hpp"

namespace tactor {

class Registry;

struct ViewOptions {
  std::uint16_t port = 0;   ///< 0: any that is free
  bool own_device = false;  ///< the graph's device stays
  bool reference = true;    ///< a reference runs beside it, where the graph has a sink that compares
  std::optional<std::filesystem::path> recording;  ///< where the run is recorded, for a replay
  std::function<void(const std::string& note)> note;
  std::function<void(const std::string& url)> opened;  ///< called when pages may come
  std::function<bool()> stop_asked;                    ///< ends the run; asked on another thread
};

/// Runs the graph live until it is stopped or its duration has passed. Returns why it failed, where it did. Throws
/// InputError before anything moves.
std::optional<std::string> view_graph(GraphSpec graph, Registry& registry, const ViewOptions& options);

}  // namespace tactor
