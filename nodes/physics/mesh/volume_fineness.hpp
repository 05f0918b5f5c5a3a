// How fine a mesh of tetrahedra is to be.
#pragma once

#include <cstddef>

namespace tactor {

struct VolumeFineness {
  std::size_t tetrahedra = 3000;  ///< about so many; not used where `edge` is given
  double edge = 0;                ///< m, the mean length of edges; 0: by `tetrahedra`
};

}  // namespace tactor
