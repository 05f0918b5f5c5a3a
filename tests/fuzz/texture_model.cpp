// Texture models. In one that is accepted every filter is stable, and every vibration finite.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "framework/yaml/diagnostics.hpp"
#include "nodes/effect/texture_model.hpp"
#include "require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactor;
  using fuzz::require;
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const TextureModel model = TextureModel::parse(text, "t.yaml");
    require(model.rate() > 0, "there are samples");
    for (const double speed : {0.0, 0.01, 0.5 * (model.speeds().front() + model.speeds().back()), 1e9}) {
      for (const double force : {0.0, 0.01, 0.5 * (model.forces().front() + model.forces().back()), 1e9}) {
        const TextureState state = model.at(speed, force);
        require(std::isfinite(state.deviation) && state.deviation >= 0, "a vibration is finite");
        NormalisedLattice lattice;
        for (const double k : state.reflection.k) require(std::abs(k) < 1, "a filter is stable");
        for (int i = 0; i < 8; ++i) require(std::isfinite(lattice.next(state.reflection, 1)), "a sample is finite");
      }
    }
  } catch (const YamlError& error) {
    require(std::string(error.what()).rfind("t.yaml", 0) == 0, "a refusal names the file");
  }
  return 0;
}
