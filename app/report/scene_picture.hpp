// The picture of a scene in a report: its bodies, and a force on the tool, without a browser.
#pragma once

#include <optional>
#include <string>

#include "app/view/drawn_scene.hpp"
#include "framework/core/check.hpp"

namespace tactor {

/// The scene from its camera, in parallel projection, as the bytes of a PNG file on a transparent ground. An arrow
/// along `force_W`, on the tool, lies over all bodies; its length tells nothing. Empty where there is no body but
/// planes. Throws InputError where a mesh cannot be read.
std::string scene_png(const DrawnScene& drawn, int width, int height, const std::optional<Vec3>& force_W = {});

/// The same as a figure of a page with its caption, which is HTML; empty where there is nothing to draw. Where a
/// mesh cannot be read any more, a line that says so.
std::string scene_figure(const DrawnScene& drawn, const std::string& caption, const std::optional<Vec3>& force_W = {});

/// A line that says why there is no picture.
std::string no_scene_figure(const InputError& why);

}  // namespace tactor
