#include "framework/engine/engine.hpp"

#include "framework/engine/live/live_library.hpp"
#include "framework/engine/replay_engine.hpp"
#include "framework/engine/virtual_engine.hpp"

namespace tactor {

std::unique_ptr<Engine> make_engine(const Plan& plan, const EngineOptions& options, const RunLog* log) {
  if (log != nullptr) return std::make_unique<ReplayEngine>(plan, *log, options);
  if (plan.graph.clock == Clock::real) return load_live_library().make(plan, options);
  return std::make_unique<VirtualEngine>(plan, options);
}

}  // namespace tactor
