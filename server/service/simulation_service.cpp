#include "server/service/simulation_service.hpp"

#include <utility>

#include "server/service/refusals.hpp"

namespace dccast::service {

SimulationService::SimulationService(Context& context)
    : context_(context),
      pools_(context.settings.checks().workers(), context.settings.queries().workers(),
             context.settings.checks().maximum_waiting()) {}

/// A call on its way through its stages.
struct SimulationService::UnaryCall {
  Wire* wire;
  Unary* reactor;
  CallOrigin origin;
  std::size_t bytes;  ///< of its request
  std::vector<Stage> stages;
  Call call{};  ///< set when admitted, before the first stage

  void finish(const grpc::Status& status) {
    origin.record(call, status);
    reactor->Finish(status);
  }
};

SimulationService::Unary* SimulationService::answer(Wire* wire,
                                                    const google::protobuf::Message& request,
                                                    std::vector<Stage> stages) {
  Unary* reactor = wire->DefaultReactor();
  CallOrigin origin = origin_of(wire, request);
  if (!origin.refusal().ok())
    reactor->Finish(origin.refusal());
  else
    do_stage(std::make_shared<UnaryCall>(UnaryCall{wire, reactor, std::move(origin),
                                                   request.ByteSizeLong(), std::move(stages)}),
             0);
  return reactor;
}

void SimulationService::do_stage(std::shared_ptr<UnaryCall> call, std::size_t number) {
  if (number == call->stages.size()) return call->finish(grpc::Status::OK);
  const auto work = [this, call, number] {
    // Without admit(), which would throw: a peer may cancel ten thousand calls a second.
    bool admitted = number > 0;
    if (!admitted && call->wire->IsCancelled())
      return call->reactor->Finish(grpc::Status::CANCELLED);

    // The first stage admits the call in the thread of its pool, because that may block.
    const grpc::Status status = guarded([&] {
      if (!admitted) {
        call->call = call->origin.admit([wire = call->wire] { return wire->IsCancelled(); });
        admitted = true;
        call->origin.check_id();
      }
      check_wanted(call->call);
      call->stages[number].work(call->call);
    });

    // A refusal of admit() is recorded already.
    if (!admitted) return call->reactor->Finish(status);
    if (!status.ok()) return call->finish(status);
    do_stage(call, number + 1);
  };

  if (call->stages[number].pool.post(work, call->bytes)) return;
  call->origin.count(too_many_waiting());
  call->reactor->Finish(too_many_waiting());
}

}  // namespace dccast::service
