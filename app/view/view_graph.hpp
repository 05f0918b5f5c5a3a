// Runs a graph live while pages look at it and lead its device.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "app/view/view_server.hpp"
#include "framework/graph/spec.hpp"

namespace tactor {

class Registry;

struct ViewOptions {
  ViewPorts ports;
  bool own_device = false;  ///< the graph's device stays
  bool reference = true;    ///< a reference runs beside it, where the graph has a sink that compares
  std::optional<std::filesystem::path> recording;  ///< where the run is recorded, for a replay
  Ask without_dead_man;                            ///< see EngineOptions::without_dead_man
  std::function<void(const std::string& note)> note;
  /// Called when pages may come. `foxglove`: what a Foxglove viewer connects to; empty where none may.
  std::function<void(const std::string& url, const std::string& foxglove)> opened;
  std::function<bool()> stop_asked;  ///< ends the run; asked on another thread
};

/// Runs the graph live until it is stopped or its duration has passed. Returns why it failed, where it did. Throws
/// InputError before anything moves.
std::optional<std::string> view_graph(GraphSpec graph, Registry& registry, const ViewOptions& options);

}  // namespace tactor
