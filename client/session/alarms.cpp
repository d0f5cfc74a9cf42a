#include "client/session/alarms.hpp"

namespace dccast::client {

void AlarmWatch::look(Connection& connection) {
  if (handlers_.forecast || handlers_.warning) look_at_forecast(connection);
  if (handlers_.finding || handlers_.lever) look_at_job(connection);
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
  tell(forecast.warnings(), handlers_.warning);
}

void AlarmWatch::tell(const google::protobuf::RepeatedPtrField<v1::ForecastWarning>& warnings,
                      const std::function<void(const v1::ForecastWarning&)>& handler) {
  for (const v1::ForecastWarning& warning : warnings) {
    const bool unknown =
        warnings_.emplace(warning.time_s(), warning.monitor(), warning.text()).second;
    if (unknown && handler) handler(warning);
  }
}

void AlarmWatch::look_at_job(Connection& connection) {
  v1::GetJobRequest request;
  request.set_id(id_);
  v1::Job job;
  if (!connection.try_once(&Stub::GetJob, request, job).ok()) return;
  tell(job.casting().alarms(), handlers_.lever);
  if (!handlers_.finding) return;
  for (const v1::Finding& finding : job.findings())
    if (finding.severity() > v1::Finding::NOTE && findings_.insert(finding.code()).second)
      handlers_.finding(finding);
}

}  // namespace dccast::client
