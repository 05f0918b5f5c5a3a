#include "app/run/record.hpp"

#include "framework/session/run_log.hpp"

namespace tactor {

std::shared_ptr<bool> record(Session& session, Recorder& recorder) {
  const auto failed = std::make_shared<bool>(false);
  const Write write = [&recorder, failed](std::size_t stream, const Stamp& stamp, const void* value) {
    if (*failed) return;
    *failed = true;
    recorder.write(stream, stamp, value);
    *failed = false;
  };
  const Plan& plan = session.plan();
  for (const PlannedStream& stream : plan.streams) {
    const MessageType& type = *plan.nodes[stream.node].info->outputs[stream.output].type;
    session.on_message(stream.name, [write, index = recorder.add_stream(stream.name, type)](
                                        const Stamp& stamp, const void* value) { write(index, stamp, value); });
  }
  if (plan.graph.clock == Clock::real) record_run(session, recorder, write);
  return failed;
}

}  // namespace tactor
