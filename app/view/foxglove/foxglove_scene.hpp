// The bodies of a scene, and arrows, as scene updates of Foxglove.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

namespace tactor {

struct FoxgloveColor {
  double r = 0, g = 0, b = 0, a = 1;
};

/// An arrow from p along d, both in W; d need not be a unit vector. One without length is not drawn.
struct FoxgloveArrow {
  float p[3] = {};  ///< m
  float d[3] = {};
  double length = 0;  ///< m
};

/// The frame of the handle; no body can have this name.
inline constexpr const char* handle_frame = "device/handle";

/// `{"sec": ..., "nsec": ...}`
std::string time_text(std::int64_t time_ns);

/// The largest half extent of the bodies of `hello`, m; of planes none. 0.1 where there is nothing else.
double scene_size(const nlohmann::json& hello, std::span<const std::string> meshes);

/// All bodies: those that move in frames of their names, the others in `world`; and the handle in its frame.
std::string bodies_update(const nlohmann::json& hello, std::span<const std::string> meshes);

/// One entity in `world`, that replaces the one before.
std::string arrows_update(const std::string& id, std::int64_t time_ns, const std::vector<FoxgloveArrow>& arrows,
                          const FoxgloveColor& color);

}  // namespace tactor
