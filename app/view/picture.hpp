// Pictures of a show, drawn by the page in a browser without a window.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/view/show.hpp"

namespace tactor {

struct PictureOptions {
  int width = 960, height = 600;  ///< pixels
  std::optional<double> time;     ///< s, of the moment shown; none: where the commanded force is largest
  bool whole_page = false;        ///< with charts and graph, else the scene alone
};

/// Writes a PNG file. Throws InputError where no browser is installed or the build has no view, RunError where the
/// browser draws nothing.
void write_picture(const Show& show, const std::filesystem::path& png, const PictureOptions& options);

/// Writes the whole run as an SVG file that moves: `count` frames over `seconds` s, each the scene with the force
/// below. Throws as write_picture.
void write_animation(const Show& show, const std::filesystem::path& svg, int count, double seconds,
                     const PictureOptions& options);

}  // namespace tactor
