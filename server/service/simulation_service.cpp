#include "server/service/simulation_service.hpp"

#include <utility>

#include "server/service/status.hpp"

namespace dccast::service {

SimulationService::SimulationService(Context& context, const std::string& address)
    : context_(context),
      users_(address),
      lanes_(context.checks_at_once, context.queries_at_once, context.maximum_waiting_checks) {}

/// A call on its way through its lanes.
struct SimulationService::UnaryCall {
  Wire* wire;
  Unary* reactor;
  CallOrigin origin;
  std::size_t bytes;  ///< of its request
  std::vector<Stage> stages;
};

SimulationService::Unary* SimulationService::answer(Wire* wire,
                                                    const google::protobuf::Message& request,
                                                    std::vector<Stage> stages) {
  Unary* reactor = wire->DefaultReactor();
  do_stage(std::make_shared<const UnaryCall>(wire, reactor, origin_of(wire), request.ByteSizeLong(),
                                             std::move(stages)),
           0);
  return reactor;
}

void SimulationService::do_stage(std::shared_ptr<const UnaryCall> call, std::size_t number) {
  if (number == call->stages.size()) return call->reactor->Finish(grpc::Status::OK);
  const auto work = [this, call, number] {
    const grpc::Status status = guarded([&] {
      const Call asked = call->origin.call([&] { return call->wire->IsCancelled(); });
      const auto unwanted = no_longer_wanted(asked);
      return unwanted ? *unwanted : call->stages[number].work(asked);
    });
    if (!status.ok()) return call->reactor->Finish(status);
    do_stage(call, number + 1);
  };
  if (!call->stages[number].lane.post(work, call->bytes)) call->reactor->Finish(too_many_waiting());
}

}  // namespace dccast::service
