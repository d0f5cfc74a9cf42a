#include "server/worker/reporting_observer.hpp"

#include <utility>

#include "server/translate/step_to_proto.hpp"

namespace dccast::worker {

casting::Order ReportingObserver::on_step(const results::StepReport& report) {
  v1::JobEvent event;
  *event.mutable_step() = translate::to_proto(report, case_.monitors);
  link_.send(std::move(event));
  return link_.order();
}

std::vector<results::StepReport> ReportingObserver::reported_steps(std::int64_t step) {
  std::vector<results::StepReport> reports;
  for (const v1::StepReport& each : link_.steps(static_cast<std::size_t>(step)))
    reports.push_back(translate::to_core(each, mesh::dimension_of(case_.section.kind)));
  return reports;
}

void ReportingObserver::on_resumed(std::int64_t step, double time) {
  v1::JobEvent event;
  event.mutable_resumed()->set_step(step);
  event.mutable_resumed()->set_time_s(time);
  link_.send(std::move(event));
}

void ReportingObserver::on_validity_lost(const results::ValidityLoss& loss) {
  v1::JobEvent event;
  *event.mutable_validity_lost() = translate::to_proto(loss);
  link_.send(std::move(event));
}

void ReportingObserver::on_finding(const results::Finding& finding) {
  v1::JobEvent event;
  *event.mutable_finding() = translate::to_proto(finding);
  link_.send(std::move(event));
}

void ReportingObserver::on_message(std::string_view text) {
  v1::JobEvent event;
  event.mutable_message()->set_level(v1::JobEvent::Message::INFO);
  event.mutable_message()->set_text(std::string(text));
  link_.send(std::move(event));
}

}  // namespace dccast::worker
