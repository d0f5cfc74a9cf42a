#include "client/session/alarms.hpp"

namespace dccast::client {

void AlarmWatch::look(Connection& connection) {
  if (handlers_.forecast || handlers_.warning) look_at_forecast(connection);
  if (handlers_.finding) look_at_findings(connection);
}

void AlarmWatch::look_at_forecast(Connection& connection) {
  v1::ForecastJobRequest request;
  request.set_id(id_);
  v1::Forecast forecast;
  if (!connection.try_once(&Stub::ForecastJob, request, forecast).ok()) return;

  const bool is_new = !last_forecast_s_ || forecast.time_s() > *last_forecast_s_;
  last_forecast_s_ = forecast.time_s();
  if (is_new && handlers_.forecast) handlers_.forecast(forecast);

  // Every forecast repeats the warnings so far; each is passed on once.
  for (const v1::ForecastWarning& warning : forecast.warnings()) {
    const bool unknown =
        warnings_.emplace(warning.time_s(), warning.monitor(), warning.text()).second;
    if (unknown && handlers_.warning) handlers_.warning(warning);
  }
}

void AlarmWatch::look_at_findings(Connection& connection) {
  v1::GetJobRequest request;
  request.set_id(id_);
  v1::Job job;
  if (!connection.try_once(&Stub::GetJob, request, job).ok()) return;
  for (const v1::Finding& finding : job.findings())
    if (finding.severity() > v1::Finding::NOTE && findings_.insert(finding.code()).second)
      handlers_.finding(finding);
}

}  // namespace dccast::client
