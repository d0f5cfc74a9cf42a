// The call that adds what a plant measures to the record of a job.
#include "server/jobs/logs/readings_log.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>

#include "proto/case_file/quality.hpp"
#include "proto/values/printable.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/service/refusals.hpp"
#include "server/service/simulation_service.hpp"
#include "server/studies/curl_forecast.hpp"

namespace dccast::service {

using Unary = SimulationService::Unary;

namespace {

/// Refuses a job that is no live one. @throws Refusal
void require_following(const Context& context, const std::string& id) {
  if (!jobs::follows_readings(context.jobs_directory / id))
    refuse(ErrorInfo::WRONG_STATE, Remedy{"`dccast follow` submits one that does"},
           "job {} follows no readings", id);
}

/// A measured value and what a plant may have.
struct Measured {
  const char* name;
  std::optional<double> value;
  double least;
  double most;
  const char* unit;
};

void check_value(const v1::Reading& reading, const Measured& measured) {
  if (!measured.value) return;
  const double value = *measured.value;
  if (std::isfinite(value) && value >= measured.least && value <= measured.most) return;
  refuse(Remedy{"check the column and its unit, or leave the value out"},
         "reading {}: {} is {:g} {}; {:g} to {:g} {} are permitted", reading.number(),
         measured.name, value, measured.unit, measured.least, measured.most, measured.unit);
}

/// The ranges are those of the same keys of a case.
void check_reading(const v1::Reading& reading) {
  const auto given = [](bool has, double value) {
    return has ? std::optional(value) : std::nullopt;
  };
  const Measured all[] = {
      {"the time", reading.time_s(), -1e6, 1e6, "s"},
      {"the casting speed",
       given(reading.has_casting_speed_m_per_s(), reading.casting_speed_m_per_s()), 0.0, 0.1,
       "m/s"},
      {"the casting temperature",
       given(reading.has_casting_temperature_c(), reading.casting_temperature_c()), 0.0, 2000.0,
       "degC"},
      {"the water flow", given(reading.has_water_flow_m2_per_s(), reading.water_flow_m2_per_s()),
       0.0, 0.1, "m2/s"},
      {"the water flow of the narrow face",
       given(reading.has_narrow_water_flow_m2_per_s(), reading.narrow_water_flow_m2_per_s()), 0.0,
       0.1, "m2/s"}};
  for (const Measured& measured : all) check_value(reading, measured);
}

/// Checks the curls of a reading against the gauges of its job.
void check_curls(const v1::Reading& reading, const v1::Following& following) {
  for (const v1::MeasuredCurl& curl : reading.curls()) {
    const auto& gauges = following.gauges();
    if (std::ranges::find(gauges, curl.monitor(), &v1::Gauge::monitor) == gauges.end())
      refuse(Remedy{"name a gauge of the job"}, "reading {}: the job has no gauge at \"{}\"",
             reading.number(), values::shortened(curl.monitor()));
    check_value(reading, {"the curl", curl.curl_m(), -1.0, 1.0, "m"});
  }
}

void check_readings(const v1::AppendReadingsRequest& request) {
  constexpr int most = 1000;
  if (request.readings_size() > most)
    refuse(Remedy{"send them in several calls"}, "a call takes at most {} readings", most);
  for (const v1::Reading& reading : request.readings()) check_reading(reading);
}

/// Adds readings to the record of a job. @throws Refusal
void append(Context& context, const v1::AppendReadingsRequest& request,
            v1::AppendReadingsResponse& response) {
  const v1::Job job = find_job(context, request.id());
  require_following(context, request.id());

  const auto record = context.readings.open(request.id());
  if (jobs::is_terminal(job.state())) {
    response = record->state();
    context.readings.close(request.id());
    if (request.readings().empty()) return;
    refuse_state(job, "it takes no readings any more");
  }

  for (const v1::Reading& reading : request.readings()) check_curls(reading, record->following());
  try {
    record->append(request.readings());
  } catch (const jobs::MissingReading& error) {
    refuse(ErrorInfo::OUT_OF_RANGE, Remedy{"send the readings after the last one"},
           "job {}: {}", request.id(), error.what());
  } catch (const jobs::UnfitReading& error) {
    refuse(Remedy{"send what was measured later"}, "job {}: {}", request.id(), error.what());
  }
  response = record->state();
}

/// The error of mesh and time steps of a study's runs, where it was measured.
v1::RelativeError mesh_error_of(const Context& context, const v1::StudyResult& ensemble) {
  for (const v1::StudyRun& run : ensemble.runs()) {
    v1::Case complete;
    if (run.job().empty() || !jobs::read_complete_case(context.jobs_directory / run.job(), complete))
      continue;
    return case_file::relative_discretisation_error(complete).value_or(v1::RelativeError());
  }
  return {};
}

/// Forecasts the casting that a job follows. @throws Refusal
v1::Forecast forecast(Context& context, const std::string& id) {
  find_job(context, id);
  require_following(context, id);
  jobs::ReadingsReader record(context.jobs_directory / id);
  const v1::Following& following = record.following();
  if (following.ensemble().empty() || following.gauges().empty())
    refuse(ErrorInfo::WRONG_STATE,
           Remedy{"`dccast follow --ensemble STUDY` with a column \"curl MONITOR\" has both"},
           "job {} has no ensemble or measures no curl", id);

  v1::EvaluateStudyRequest request;
  request.set_id(following.ensemble());
  request.set_curves(true);
  const auto ensemble = context.studies.evaluate(request);
  if (!ensemble) refuse_unknown_study(following.ensemble());

  const auto readings = record.read_new();
  try {
    return studies::forecast_curls({.ensemble = *ensemble,
                                    .mesh_error = mesh_error_of(context, *ensemble),
                                    .following = following,
                                    .readings = readings});
  } catch (const studies::CannotForecast& reason) {
    refuse(ErrorInfo::WRONG_STATE, Remedy{"ask again when more have ended"}, "{}", reason.what());
  }
}

}  // namespace

Unary* SimulationService::ForecastJob(Wire* wire, const v1::ForecastJobRequest* request,
                                      v1::Forecast* response) {
  return answer(wire, *request, lanes_.histories,
                [=, this](const Call&) { *response = forecast(context_, request->id()); });
}

Unary* SimulationService::AppendReadings(Wire* wire, const v1::AppendReadingsRequest* request,
                                         v1::AppendReadingsResponse* response) {
  return answer(wire, *request, lanes_.durable, [=, this](const Call&) {
    check_readings(*request);
    append(context_, *request, *response);
  });
}

}  // namespace dccast::service
