// The calls about what a plant measures.
#include "server/jobs/logs/readings_log.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "proto/case_file/schema.hpp"
#include "proto/values/printable.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/job_description.hpp"
#include "server/jobs/queue/queue_hold.hpp"
#include "server/levers/sound_levers.hpp"
#include "server/service/forecasts.hpp"
#include "server/service/refusals.hpp"
#include "server/service/simulation_service.hpp"

namespace dccast::service {

using Unary = SimulationService::Unary;

namespace {

/// The zero of a sensor drifts: speeds down to -5 mm/min [m/s] and flows down to -5 l/min/m [m2/s]
/// are those of a block that stands and of a closed valve.
constexpr double drift_of_zero = 5e-3 / 60.0;

constexpr double longest_time = 1e6;  // [s]
constexpr double largest_curl = 1.0;  // [m]

/// Whether a lever is one that cannot be negative in a plant: a speed or a flow.
bool is_rate(const google::protobuf::FieldDescriptor& key) {
  const std::string& unit = case_file::key_of(key).unit();
  return unit == "m/s" || unit == "m2/s";
}

/// The key of a case that a lever of a reading moves; null: the field is no lever.
const google::protobuf::FieldDescriptor* key_of_lever(const std::string& lever) {
  if (lever == "water_temperature_c")
    return v1::Water::descriptor()->FindFieldByName("temperature_c");
  return v1::Schedule::descriptor()->FindFieldByName(lever);
}

void add_left_out(const v1::Reading& reading, const std::string& name, double value,
                  const std::string& reason, v1::AppendReadingsResponse& response) {
  v1::LeftOutValue& left_out = *response.add_left_out();
  left_out.set_number(reading.number());
  left_out.set_name(name);
  left_out.set_value(value);
  left_out.set_reason(reason);
}

/// Takes out levers beyond the range of the key of the case that they move, and what no lever of
/// this casting can be.
void clean_levers(const levers::SoundLevers& sound, v1::Reading& reading,
                  v1::AppendReadingsResponse& response) {
  const auto& reflection = *v1::Reading::GetReflection();
  for (const auto* const field : case_file::fields_of(*v1::Reading::descriptor())) {
    const auto* const key = key_of_lever(field->name());
    const auto value = key ? case_file::number_of(reading, *field) : std::nullopt;
    if (!value) continue;
    if (is_rate(*key) && *value < 0.0 && *value >= -drift_of_zero) {
      reflection.SetDouble(&reading, field, 0.0);
      continue;
    }

    std::string permitted = sound.limit_passed(field->name(), *value);
    if (case_file::range_fault(*key, *value, {}, {}, {})) permitted = case_file::range_text(*key);
    if (permitted.empty()) continue;

    reflection.ClearField(&reading, field);
    std::string name = case_file::toml_key(*key);
    if (name == "temperature") name = "water temperature";
    std::ranges::replace(name, '_', ' ');
    add_left_out(reading, field->name(), *value,
                 fmt::format("the {} is {:g} {}; permitted: {}{}", name, *value,
                             case_file::key_of(*key).unit(), permitted,
                             sound.explanation(field->name(), *value)),
                 response);
  }
}

/// Takes out curls that are farther from zero than any butt lifts.
/// @throws Refusal  the job has no such gauge, or a gauge has two curls
void clean_curls(const std::set<std::string_view>& gauges, v1::Reading& reading,
                 v1::AppendReadingsResponse& response) {
  std::set<std::string_view> seen;
  const auto measured = reading.curls();
  reading.clear_curls();
  for (const v1::MeasuredCurl& curl : measured) {
    if (!seen.insert(curl.monitor()).second)
      refuse(Remedy{"give one curl a gauge"}, "reading {}: the gauge at \"{}\" has two curls",
             reading.number(), values::shortened(curl.monitor()));
    if (!gauges.contains(curl.monitor()))
      refuse(Remedy{"name a gauge of the job"}, "reading {}: the job has no gauge at \"{}\"",
             reading.number(), values::shortened(curl.monitor()));
    if (std::abs(curl.curl_m()) <= largest_curl)
      *reading.add_curls() = curl;
    else
      add_left_out(reading, curl.monitor() + "_curl_m", curl.curl_m(),
                   fmt::format("the curl is {:g} m; permitted: {:g} to {:g} m", curl.curl_m(),
                               -largest_curl, largest_curl),
                   response);
  }
}

void check_readings(const v1::AppendReadingsRequest& request) {
  constexpr int most = 1000;
  if (request.readings_size() > most)
    refuse(Remedy{"send them in several calls"}, "a call takes at most {} readings", most);
  for (const v1::Reading& reading : request.readings()) {
    if (std::abs(reading.time_s()) <= longest_time) continue;
    refuse(Remedy{"check the column of the time and its unit, or leave the reading out"},
           "reading {}: the time is {:g} s; permitted: {:g} to {:g} s", reading.number(),
           reading.time_s(), -longest_time, longest_time);
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
  v1::Case plan;
  // Without its plan a casting is still recorded.
  if (!jobs::read_complete_case(context.jobs_directory / request.id(), plan)) plan.Clear();
  const levers::SoundLevers sound(plan);
  auto readings = request.readings();
  v1::AppendReadingsResponse cleaned;
  for (v1::Reading& reading : readings) {
    clean_levers(sound, reading, cleaned);
    clean_curls(gauges, reading, cleaned);
  }
  if (!readings.empty())
    jobs::require_free_space(context.jobs_directory,
                             std::llround(context.settings.limits().minimum_free_bytes()));
  try {
    record->append(readings);
  } catch (const jobs::MissingReading& error) {
    refuse(ErrorInfo::OUT_OF_RANGE, Remedy{"send the readings after the last one"}, "job {}: {}",
           request.id(), error.what());
  } catch (const jobs::UnfitReading& error) {
    refuse(Remedy{"send what was measured later, in short readings"}, "job {}: {}", request.id(),
           error.what());
  } catch (const jobs::RecordFull& error) {
    refuse(ErrorInfo::LIMIT_REACHED,
           Remedy{"close it, and follow a further casting with readings at larger intervals"},
           "job {}: {}, as many as it may have", request.id(), error.what());
  } catch (const jobs::TooManyAtOnce& error) {
    refuse(ErrorInfo::BUSY, Remedy{"try again in a moment"}, "job {}: {}", request.id(),
           error.what());
  }
  response = record->state();
  *response.mutable_left_out() = std::move(*cleaned.mutable_left_out());
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
