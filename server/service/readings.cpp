// The calls about what a plant measures.
#include "server/jobs/logs/readings_log.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "proto/case_file/schema.hpp"
#include "proto/values/printable.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/service/forecasts.hpp"
#include "server/service/refusals.hpp"
#include "server/service/simulation_service.hpp"

namespace dccast::service {

using Unary = SimulationService::Unary;

namespace {

/// @param permitted  as text: "0 to 0.1 m/s"
[[noreturn]] void refuse_value(const v1::Reading& reading, const std::string& name, double value,
                               const std::string& unit, const std::string& permitted) {
  refuse(Remedy{"check the column and its unit, or leave the value out"},
         "reading {}: the {} is {:g} {}; permitted: {}", reading.number(), name, value, unit,
         permitted);
}

/// Refuses a value that is farther from zero than any plant has.
void check_size(const v1::Reading& reading, const std::string& name, double value, double most,
                const std::string& unit) {
  if (std::abs(value) <= most) return;
  refuse_value(reading, name, value, unit, fmt::format("{:g} to {:g} {}", -most, most, unit));
}

/// A lever has the range of the key of a case with the same name.
void check_levers(const v1::Reading& reading) {
  for (const auto* const field : case_file::fields_of(*v1::Reading::descriptor())) {
    const auto* const key = v1::Schedule::descriptor()->FindFieldByName(field->name());
    const auto value = key ? case_file::number_of(reading, *field) : std::nullopt;
    if (!value || !case_file::range_fault(*key, *value, {}, {}, {})) continue;

    std::string name = case_file::toml_key(*key);
    std::ranges::replace(name, '_', ' ');
    refuse_value(reading, name, *value, case_file::key_of(*key).unit(),
                 case_file::range_text(*key));
  }
}

/// Checks the curls of a reading against the gauges of its job.
void check_curls(const v1::Reading& reading, const std::set<std::string_view>& gauges) {
  std::set<std::string_view> measured;
  for (const v1::MeasuredCurl& curl : reading.curls()) {
    if (!measured.insert(curl.monitor()).second)
      refuse(Remedy{"give one curl a gauge"}, "reading {}: the gauge at \"{}\" has two curls",
             reading.number(), values::shortened(curl.monitor()));
    if (!gauges.contains(curl.monitor()))
      refuse(Remedy{"name a gauge of the job"}, "reading {}: the job has no gauge at \"{}\"",
             reading.number(), values::shortened(curl.monitor()));
    check_size(reading, "curl", curl.curl_m(), 1.0, "m");
  }
}

void check_readings(const v1::AppendReadingsRequest& request) {
  constexpr int most = 1000;
  if (request.readings_size() > most)
    refuse(Remedy{"send them in several calls"}, "a call takes at most {} readings", most);
  for (const v1::Reading& reading : request.readings()) {
    check_size(reading, "time", reading.time_s(), 1e6, "s");
    check_levers(reading);
  }
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

  std::set<std::string_view> gauges;
  for (const v1::Gauge& gauge : record->following().gauges()) gauges.insert(gauge.monitor());
  for (const v1::Reading& reading : request.readings()) check_curls(reading, gauges);
  try {
    record->append(request.readings());
  } catch (const jobs::MissingReading& error) {
    refuse(ErrorInfo::OUT_OF_RANGE, Remedy{"send the readings after the last one"}, "job {}: {}",
           request.id(), error.what());
  } catch (const jobs::UnfitReading& error) {
    refuse(Remedy{"send what was measured later, in short readings"}, "job {}: {}", request.id(),
           error.what());
  }
  response = record->state();
}

}  // namespace

Unary* SimulationService::ForecastJob(Wire* wire, const v1::ForecastJobRequest* request,
                                      v1::Forecast* response) {
  return answer(wire, *request, pools_.histories,
                [=, this](const Call&) { *response = forecast_job(context_, request->id()); });
}

Unary* SimulationService::AppendReadings(Wire* wire, const v1::AppendReadingsRequest* request,
                                         v1::AppendReadingsResponse* response) {
  return answer(wire, *request, pools_.durable, [=, this](const Call&) {
    check_readings(*request);
    append(context_, *request, *response);
  });
}

}  // namespace dccast::service
