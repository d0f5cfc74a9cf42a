#include "server/worker/reporting_observer.hpp"

#include <utility>

#include "server/translate/step_to_proto.hpp"

namespace dccast::worker {

void ReportingObserver::send(const results::StepReport& report) {
  v1::JobEvent event;
  *event.mutable_step() = translate::to_proto(report, monitors_);
  link_.send(std::move(event));
}

casting::Order ReportingObserver::on_step(const results::StepReport& report) {
  send(report);
  return link_.order();
}

void ReportingObserver::on_missed_step(const results::StepReport& report) {
  send(report);
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
