// The JSON schemas of the messages that Foxglove and its kin are given.
#pragma once

#include <span>
#include <string>

namespace tactor {

/// `foxglove.SceneUpdate`: entities that are drawn. As Foxglove publishes it, without its remarks.
std::string scene_update_schema();

/// An object of a time stamp, of texts and of numbers. A name with a dot, `force.x`, is a member of an object.
/// `units`: of each number, or what its values mean.
std::string row_schema(const std::string& title, std::span<const std::string> texts,
                       std::span<const std::string> numbers, std::span<const std::string> units);

}  // namespace tactor
