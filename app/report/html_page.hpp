// The frame of every report: one HTML file that needs nothing else.
#pragma once

#include <string>
#include <string_view>

namespace tactor {

/// The text with what HTML gives a meaning replaced.
std::string escape(std::string_view text);

/// A page of that title with its style; `body` is HTML.
std::string page(const std::string& title, const std::string& body);

}  // namespace tactor
