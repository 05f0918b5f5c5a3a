#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"

namespace tactor {

class MyNode final : public Node {
 public:
  struct Params {
    double spacing = 1e-3;
  };
  MyNode(const Params&, const NodeContext&);
  void step(StepContext&) override;
  static NodeInfo declare() { BLOCK; }
};

}  // namespace tactor
