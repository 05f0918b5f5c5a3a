// A replay as a file of MCAP.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

namespace tactor {

/// Writes the file. `hello`, `meshes` and `frames` as ViewSource gives them. A write that fails is seen at the stream.
void export_mcap(std::ostream& out, const std::string& hello, const std::vector<std::string>& meshes,
                 const std::vector<std::string>& frames);

}  // namespace tactor
