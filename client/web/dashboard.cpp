#include "client/web/dashboard.hpp"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/util/json_util.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <utility>

#include "client/html/html_parts.hpp"
#include "client/html/judgement_parts.hpp"
#include "client/html/pages.hpp"
#include "client/model/json.hpp"
#include "client/session/byte_call.hpp"
#include "client/session/case_faults.hpp"
#include "client/session/jobs.hpp"
#include "client/session/plan_requests.hpp"
#include "client/session/queries.hpp"
#include "client/web/connect_entry.hpp"
#include "client/web/resources.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/remedies.hpp"
#include "proto/case_file/shipped.hpp"
#include "proto/figures/plant_units.hpp"
#include "proto/figures/rounding.hpp"
#include "proto/refusal/refusal.hpp"

namespace dccast::client {
namespace {

/// A judgement as pages show it: its sentences, and its parts as HTML.
Json shown_json(const v1::Judgement& judgement) {
  Json parts = Json::array();
  for (const v1::JudgementPart& part : judgement.parts())
    if (part.place() != v1::JudgementPart::TERMINAL)
      parts.push_back({{"key", part.has_table() ? part.table().key() : part.chart().key()},
                       {"html", part_of_card(part)}});
  return {
      {"heading", judgement.heading()},
      {"sentences", json_list(judgement.sentences(), [](const auto& text) { return Json(text); })},
      {"parts", parts}};
}

/// The call of the service that a request names, whose response has a judgement: pages get it with
/// its parts as HTML.
Reply drawn_call(Connection& connection, const Request& request) {
  const auto* const method = find_method(request.name);
  const auto* const field =
      method == nullptr ? nullptr : method->output_type()->FindFieldByName("judgement");
  if (field == nullptr)
    throw CommandFailed(ExitCode::not_found, request.name + " gives no judgement");

  Reply error;
  const auto response = call_json(connection, request, error);
  if (!response) return error;
  const auto& reflection = *response->GetReflection();
  const Json shown =
      shown_json(dynamic_cast<const v1::Judgement&>(reflection.GetMessage(*response, field)));
  reflection.ClearField(response.get(), field);

  Json json = to_json(*response);
  json["judgement"] = shown;
  return {json.dump()};
}

// ---- Results evaluated by the client.

/// What a page draws of a step, named as in StepReport.
Json step_json(const v1::StepReport& step) {
  const auto shown = [](v1::MonitorValue monitor) {
    monitor.clear_displacement_m();
    return to_json(monitor);
  };
  return {{"step", step.step()},
          {"time_s", step.time_s()},
          {"cast_length_m", step.cast_length_m()},
          {"monitors", json_list(step.monitors(), shown)}};
}

/// The range of curl that the case accepts [m]; a missing limit is null.
Json wanted_json(const v1::Case& description) {
  const auto& limits = description.plausibility();
  return {{"least_m", limits.has_least_curl_m() ? Json(limits.least_curl_m()) : Json()},
          {"greatest_m", limits.has_greatest_curl_m() ? Json(limits.greatest_curl_m()) : Json()}};
}

/// The levers of a followed casting, now and as planned, in plant units.
Json levers_json(const v1::CastingNow& casting) {
  struct Lever {
    const char* name;
    const char* field;  ///< of v1::Reading
    const char* unit;
    int decimals;
  };
  static constexpr Lever levers[] = {
      {"Speed", "casting_speed_m_per_s", "m/s", 1},
      {"Water", "water_flow_m2_per_s", "m2/s", 0},
      {"Narrow water", "narrow_water_flow_m2_per_s", "m2/s", 0},
      {"Second water", "second_water_flow_m2_per_s", "m2/s", 0},
      {"Metal", "casting_temperature_c", "degC", 0},
      {"Water temperature", "water_temperature_c", "degC", 0},
      {"Metal level", "metal_level_m", "m", 0},
  };

  static constexpr const char* unknown = "–";
  Json json = Json::array();
  for (const Lever& lever : levers) {
    const auto* const field = v1::Reading::descriptor()->FindFieldByName(lever.field);
    const v1::PlantUnit unit = figures::plant_unit(lever.unit);
    const auto text = [&](const v1::Reading& reading) {
      const auto& reflection = *v1::Reading::GetReflection();
      if (!reflection.HasField(reading, field)) return std::string(unknown);
      return figures::fixed(unit.factor() * reflection.GetDouble(reading, field), lever.decimals);
    };
    const std::string now = text(casting.measured()), plan = text(casting.planned());
    if (now != unknown || plan != unknown)
      json.push_back({{"name", lever.name}, {"now", now}, {"plan", plan}, {"unit", unit.name()}});
  }
  return json;
}

/// A job with its curl, the error of mesh and steps, and the times of its stored frames.
Json job_json(Connection& connection, const std::string& id) {
  const v1::Job job = connection.call(&Stub::GetJob, id);
  const v1::QueryResultResponse result = query_result(connection, job.id());
  return {{"job", to_json(job)},
          {"has_levers", !case_file::advice_against(job.findings()).empty()},
          {"steps", json_list(result.steps(), step_json)},
          {"wanted", wanted_json(result.case_())},
          {"levers", levers_json(job.casting())},
          {"dimension", result.case_().section().kind() == v1::Section::QUARTER_SLAB ? 3 : 2},
          {"case", case_file::to_toml(result.case_())}};
}

/// The judged curl of a job at some instants, for a thumbnail in a list.
Json sketch_json(Connection& connection, const std::string& id) {
  constexpr int points = 60;
  const v1::Job job = connection.call(&Stub::GetJob, id);
  const auto steps = query_result(connection, job.id()).steps();
  const v1::MonitorValue* const judged =
      steps.empty() ? nullptr : figures::judged_curl(*steps.rbegin());
  if (judged == nullptr) return {{"time_s", Json::array()}, {"curl_m", Json::array()}};

  std::vector<double> time_s, curl_m;
  const auto add = [&](const v1::StepReport& step) {
    time_s.push_back(step.time_s());
    curl_m.push_back(figures::curl_of(figures::monitor_of(step, judged->name())));
  };
  const int stride = steps.size() / points + 1;
  for (int i = 0; i < steps.size(); i += stride) add(steps[i]);
  // The end is what a list is read for, whatever the stride.
  add(*steps.rbegin());
  return {{"time_s", time_s}, {"curl_m", curl_m}};
}

/// The times of all stored frames and the fields of the last one. A job without frames is no fault:
/// then `reason` states why there are none.
Json frames_json(Connection& connection, const std::string& id) {
  Json json{{"times", Json::array()}, {"fields", Json::array()}, {"reason", ""}};
  try {
    const auto result = stored_frame(connection, id, 0);
    for (const double time_s : result.frame_time_s()) json["times"].push_back(time_s);
    for (const v1::FrameField& field : result.frame().fields())
      json["fields"].push_back(to_json(field));
  } catch (const CommandFailed& failure) {
    if (failure.code() == ExitCode::not_found) throw;
    json["reason"] = failure.what();
  }
  return json;
}

Reply comparison(Connection& connection, const std::vector<std::string>& ids) {
  v1::CompareRunsRequest request;
  for (const std::string& id : ids) request.add_runs()->set_job(id);
  return {.body = comparison_page(connection.call(&Stub::CompareRuns, request)),
          .type = html_type,
          .stands_alone = true};
}

// ---- Cases, which pages hold as text

/// The cases that pages begin with: files named when the dashboard was started, whose further files
/// the server then has, and names of shipped ones. A page can read no others.
Json cases_json(Connection& connection, const std::vector<std::string>& files) {
  Json given = Json::array();
  std::map<std::string, int> times;
  for (const std::string& file : files) {
    const CaseUnderCheck checked = read_case(file);
    const v1::SubmitJobRequest named = submission_of(checked, connection);

    // Pages get names without folders.
    std::string name = std::filesystem::path(file).filename();
    if (const int n = ++times[name]; n > 1) name = fmt::format("{} ({})", name, n);
    given.push_back({{"name", name},
                     {"text", checked.text},
                     {"attachments", json_list(named.attachments(), to_json)}});
  }
  return {{"given", given}, {"shipped", shipped::names_of(shipped::case_templates())}};
}

/// What the levers of the page what-if are in a case: first and last value in the unit of a plant.
Json lever_values_json(const v1::Case& input) {
  const v1::Schedule& recipe = input.schedule();
  const v1::Cooling& cooling = input.cooling();
  Json json = Json::object();
  const auto add = [&](const char* key, const char* unit, std::vector<double> values) {
    const v1::PlantUnit plant = figures::plant_unit(unit);
    if (values.empty()) return;
    for (double& value : values) value *= plant.factor();
    json[key] = {{"values", {values.front(), values.back()}}, {"unit", plant.name()}};
  };
  const auto add_curve = [&](const char* key, const char* unit, const v1::Curve& curve) {
    add(key, unit, {curve.value().begin(), curve.value().end()});
  };

  add_curve("schedule.casting_speed.scale", "m/s", recipe.casting_speed_m_per_s());
  add_curve("schedule.water_flow.scale", "m2/s", recipe.water_flow_m2_per_s());
  add_curve("schedule.casting_temperature.offset", "degC", recipe.casting_temperature_c());
  add_curve("cooling.water.temperature.offset", "degC", cooling.water().temperature_c());
  add_curve("cooling.bottom_block.temperature.offset", "degC",
            cooling.bottom_block().temperature_c());
  add("schedule.filling.scale", "s", {recipe.filling_s()});
  add("schedule.hold.scale", "s", {recipe.hold_s()});
  return json;
}

/// Refuses a case with values out of range, as the server does, which alone can judge the rest.
void check_ranges(const v1::Case& input) {
  v1::ValidateCaseResponse verdict;
  for (v1::Fault& fault : case_file::check_ranges(input)) *verdict.add_faults() = std::move(fault);
  if (verdict.faults_size() == 0) return;

  const v1::Fault& first = verdict.faults(0);
  const refusal::Facts facts{
      .reason = v1::ErrorInfo::INVALID_CASE,
      .cause = fmt::format("the case has {} fault{}; first: {}: {}", verdict.faults_size(),
                           verdict.faults_size() == 1 ? "" : "s", first.field(), first.message())};
  throw CommandFailed(ExitCode::invalid, facts.message(),
                      {grpc::INVALID_ARGUMENT, facts.message(),
                       refusal::write_details(grpc::INVALID_ARGUMENT, facts, &verdict)});
}

/// A case as a page shows it, from its JSON: drawing, levers, and the file.
Reply shown_case(const Request& request) {
  v1::Case input;
  const auto status = google::protobuf::util::JsonStringToMessage(request.body, &input);
  if (!status.ok()) throw invalid(std::string(status.message()));
  check_ranges(input);

  v1::Case complete = input;
  case_file::apply_defaults(complete);
  return {Json{{"drawing", casting_drawing(complete)},
               {"levers", lever_values_json(complete)},
               {"text", case_file::to_toml(input)}}
              .dump()};
}

std::string type_of(const std::string& name) {
  if (name.ends_with(".js")) return "text/javascript; charset=utf-8";
  if (name.ends_with(".css")) return "text/css; charset=utf-8";
  if (name.ends_with(".svg")) return "image/svg+xml";
  if (name.ends_with(".json")) return "application/json";
  return html_type;
}

void add_pages(WebServer& server) {
  for (const Asset& asset : assets())
    server.file(asset.name == "index.html" ? "/" : "/" + asset.name, type_of(asset.name),
                asset.text);
  for (const PageAsset& asset : page_assets())
    server.file("/" + asset.name, type_of(asset.name), asset.text);
}

/// Jobs as pages show them, alone or beside each other.
void add_results(WebServer& server, const Connect& connect) {
  const auto get = [&](const std::string& path, const auto& handler) {
    server.get(path, connected(connect, handler));
  };

  // Histories and pages of single jobs, and their comparison.
  get("/job/*", [](Connection& connection, const Request& request) {
    return Reply{job_json(connection, request.name).dump()};
  });
  get("/frames/*", [](Connection& connection, const Request& request) {
    return Reply{frames_json(connection, request.name).dump()};
  });
  get("/sketch/*", [](Connection& connection, const Request& request) {
    return Reply{sketch_json(connection, request.name).dump()};
  });
  get("/compare/*", [](Connection& connection, const Request& request) {
    return comparison(connection, request.values("job"));
  });

  // The study that looks for a remedy.
  server.post("/remedy/*", connected(connect, [](Connection& connection, const Request& request) {
                return Reply{Json{{"study", remedy_of(connection, request.name).id()}}.dump()};
              }));
  get("/server/*", [](Connection& connection, const Request&) {
    const auto who = connection.call(&Stub::WhoAmI, v1::WhoAmIRequest());
    return Reply{Json{{"address", connection.server()},
                      {"user", who.name()},
                      {"shared", connection.is_for_browser()},
                      {"role", v1::Role_Name(who.role())}}
                     .dump()};
  });
}

void add_cases(WebServer& server, const Connect& connect, const std::vector<std::string>& cases) {
  server.get("/cases/*", connected(connect, [=](Connection& connection, const Request&) {
               return Reply{cases_json(connection, cases).dump()};
             }));
  server.post("/case/*", shown_case);
}

}  // namespace

void add_dashboard(WebServer& server, const Connect& connect,
                   const std::vector<std::string>& cases) {
  add_pages(server);
  server.post("/dccast.v1.SimulationService/*", connected(connect, connect_reply));
  server.post("/drawn/*", connected(connect, drawn_call));
  add_results(server, connect);
  add_resources(server, connect);
  add_cases(server, connect, cases);
}

}  // namespace dccast::client
