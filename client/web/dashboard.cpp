#include "client/web/dashboard.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <map>
#include <sstream>
#include <utility>

#include "client/html/html_parts.hpp"
#include "client/html/pages.hpp"
#include "client/model/json.hpp"
#include "client/model/measured_csv.hpp"
#include "client/session/byte_call.hpp"
#include "client/session/case_faults.hpp"
#include "client/session/jobs.hpp"
#include "client/session/plan_requests.hpp"
#include "client/session/queries.hpp"
#include "client/web/connect_entry.hpp"
#include "client/web/connect_messages.hpp"
#include "client/web/resources.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/remedies.hpp"
#include "proto/case_file/shipped.hpp"

namespace dccast::client {
namespace {

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

/// A job with its curl, the error of mesh and steps, and its case with the files that it names.
Json job_json(Connection& connection, const std::string& id) {
  const v1::Job job = connection.call(&Stub::GetJob, id);
  const v1::QueryResultResponse result = query_result(connection, job.id());
  return {{"job", to_json(job)},
          {"has_levers", !case_file::advice_against(job.findings()).empty()},
          {"steps", json_list(result.steps(), step_json)},
          {"wanted", to_json(result.case_().plausibility())},
          {"case", case_file::to_toml(result.case_())},
          {"attachments", json_list(result.attachments(), to_json)}};
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

Reply comparison(Connection& connection, const Request& request) {
  v1::CompareRunsRequest wanted;
  for (const std::string& id : request.values("job")) wanted.add_runs()->set_job(id);
  return page_alone(comparison_page(connection.call(&Stub::CompareRuns, wanted)));
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

// ---- Studies whose plan pages do not make

/// Begins the recipe search of a CreateStudyRequest, or finds the one that is there. Query: the
/// texts of a RecipeChoice. What the request has of a RecipePlan holds.
Reply recipe_search(Connection& connection, const Request& request) {
  std::string bytes;
  check(read_request(*find_method("CreateStudy"), true, request.body, bytes), connection.server());
  v1::CreateStudyRequest wanted;
  wanted.ParseFromString(bytes);

  RecipeChoice choice;
  for (const auto& [name, text] :
       {std::pair{"band", &choice.band}, std::pair{"speed", &choice.speed},
        std::pair{"water", &choice.water}, std::pair{"hold", &choice.hold},
        std::pair{"filling", &choice.filling}})
    if (request.query.contains(name)) *text = request.value(name);
  const v1::RecipePlan given = wanted.recipe();
  lay_out_recipe(connection, choice, wanted);
  wanted.mutable_recipe()->MergeFrom(given);
  return json_reply(
      to_json(taken_up(connection, connection.call(&Stub::CreateStudy, wanted))).dump());
}

/// The curves of a file of measurements: the body, under the name of the request. Query: the
/// monitors of the case.
Reply measured_curves(Connection& connection, const Request& request) {
  connection.call(&Stub::WhoAmI, v1::WhoAmIRequest());  // the daemon knows whether the token is one
  constexpr std::size_t most_bytes = 2'000'000;
  std::string text;
  for (std::string part; !(part = request.next_part()).empty();) {
    text += part;
    if (text.size() > most_bytes)
      throw invalid(fmt::format("{} has more than {} bytes; thin its readings out", request.name,
                                most_bytes));
  }

  std::istringstream lines(text);
  const MeasuredFile read = read_measured(lines, request.name, request.values("monitor"));
  if (!read.faults.empty()) throw invalid(fmt::format("{}", fmt::join(read.faults, "\n")));
  return json_reply(json_list(read.curves, to_json).dump());
}

std::string type_of(const std::string& name) {
  if (name.ends_with(".js")) return "text/javascript; charset=utf-8";
  if (name.ends_with(".css")) return "text/css; charset=utf-8";
  if (name.ends_with(".svg")) return "image/svg+xml";
  if (name.ends_with(".json")) return "application/json";
  return "text/html; charset=utf-8";
}

void add_pages(WebServer& server) {
  for (const Asset& asset : assets())
    server.file(asset.name == "index.html" ? "/" : "/" + asset.name, type_of(asset.name),
                asset.text);
  for (const PageAsset& asset : page_assets())
    server.file("/" + asset.name, type_of(asset.name), asset.text);
}

}  // namespace

void add_dashboard(WebServer& server, const Connect& connect,
                   const std::vector<std::string>& cases) {
  add_pages(server);
  server.post("/dccast.v1.SimulationService/*", connected(connect, connect_reply));
  add_resources(server, connect);

  const auto get = [&](const std::string& path, const auto& handler) {
    server.get(path, connected(connect, handler));
  };
  get("/cases/*", [=](Connection& connection, const Request&) {
    return json_reply(cases_json(connection, cases).dump());
  });
  get("/job/*", [](Connection& connection, const Request& request) {
    return json_reply(job_json(connection, request.name).dump());
  });
  get("/frames/*", [](Connection& connection, const Request& request) {
    return json_reply(frames_json(connection, request.name).dump());
  });
  get("/compare/*", comparison);
  get("/server/*", [](Connection& connection, const Request&) {
    const auto who = connection.call(&Stub::WhoAmI, v1::WhoAmIRequest());
    return json_reply(Json{{"address", connection.server()},
                           {"user", who.name()},
                           {"shared", connection.is_for_browser()},
                           {"role", v1::Role_Name(who.role())}}
                          .dump());
  });
  server.post("/recipe", connected(connect, recipe_search));
  server.put("/measured/*", connected(connect, measured_curves));
}

}  // namespace dccast::client
