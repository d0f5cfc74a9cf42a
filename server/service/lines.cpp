// The calls about lines. What a line learns is in forecasts.cpp.
#include "server/studies/lines.hpp"

#include "server/service/forecasts.hpp"
#include "server/service/refusals.hpp"
#include "server/service/simulation_service.hpp"

namespace dccast::service {

using Unary = SimulationService::Unary;

Unary* SimulationService::ListLines(Wire* wire, const v1::ListLinesRequest* request,
                                    v1::ListLinesResponse* response) {
  return answer(wire, *request, pools_.histories, [=, this](const Call& call) {
    v1::ListLinesResponse listing = context_.lines.list();
    if (!context_.gate.authority().reads_own_only(call.caller)) {
      *response = std::move(listing);
      return;
    }
    for (v1::Line& line : *listing.mutable_lines())
      if (line.owner() == call.caller.name) *response->add_lines() = std::move(line);
  });
}

Unary* SimulationService::GetLine(Wire* wire, const v1::GetLineRequest* request,
                                  v1::Line* response) {
  return answer(wire, *request, pools_.histories,
                [=, this](const Call&) { *response = learned_line(context_, request->id()); });
}

Unary* SimulationService::RestartLine(Wire* wire, const v1::RestartLineRequest* request,
                                      v1::Line* response) {
  return answer(wire, *request, pools_.durable, [=, this](const Call&) {
    auto line = context_.lines.restart(request->id());
    if (!line) throw Refusal{unknown_line(request->id())};
    *response = std::move(*line);
  });
}

Unary* SimulationService::DeleteLine(Wire* wire, const v1::DeleteLineRequest* request,
                                     v1::DeleteLineResponse*) {
  return answer(wire, *request, pools_.durable, [=, this](const Call&) {
    if (!context_.lines.remove(request->id())) throw Refusal{unknown_line(request->id())};
  });
}

}  // namespace dccast::service
