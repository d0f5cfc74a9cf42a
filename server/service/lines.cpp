// The calls about lines. What a line learns is in forecasts.cpp.
#include "server/studies/lines.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>
#include <vector>

#include "proto/case_file/plant_words.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/folder/job_description.hpp"
#include "server/service/call.hpp"
#include "server/service/forecasts.hpp"
#include "server/service/refusals.hpp"
#include "server/service/simulation_service.hpp"

namespace dccast::service {

using Unary = SimulationService::Unary;

namespace {

using Faults = google::protobuf::RepeatedPtrField<v1::Fault>;

/// What is typed of a casting, and what is permitted [m].
constexpr std::int64_t most_count = 1'000'000;
constexpr double longest_casting = 30.0, largest_curl = 0.5, most_sawn_off = 5.0;
constexpr int most_points = 100;

void check_length(const std::string& field, double value, double least, double most,
                  Faults& faults) {
  if (std::isfinite(value) && value >= least && value <= most) return;
  *faults.Add() = intake::fault_of(field, fmt::format("{:g} m", value), "is out of range",
                                   fmt::format("{:g} to {:g} m", least, most),
                                   "write the length with its unit, as 40 mm");
}

/// Checks what somebody has typed of castings. @param prefix  of the fields, "" or "castings[3]."
void check_record(const std::string& prefix, const v1::LineCasting& typed, Faults& faults) {
  if (!v1::LineCasting::Outcome_IsValid(typed.outcome()))
    *faults.Add() =
        intake::fault_of(prefix + "outcome", std::to_string(typed.outcome()), "is no outcome",
                         case_file::outcome_words(), "name one of them");
  if (typed.outcome() == v1::LineCasting::UNKNOWN && typed.cold_curl_m().empty())
    *faults.Add() = intake::fault_of(
        prefix + "outcome", "none", "says neither how the casting went nor its curl",
        case_file::outcome_words() + ", or a curl", "give --outcome, or --curl");
  if (typed.count() < 1 || typed.count() > most_count)
    *faults.Add() = intake::fault_of(prefix + "count", std::to_string(typed.count()),
                                     "is no number of castings", "1 to 1000000",
                                     "write how many castings went alike");
  if (typed.count() > 1 && !typed.cold_curl_m().empty())
    *faults.Add() = intake::fault_of(prefix + "count", std::to_string(typed.count()),
                                     "castings cannot have one measured curl", "1 beside a curl",
                                     "add the measured casting by itself");

  const bool has_failed = typed.outcome() > v1::LineCasting::SOUND;
  if (typed.has_at_m() && !has_failed)
    *faults.Add() =
        intake::fault_of(prefix + "at", fmt::format("{:g} m", typed.at_m()),
                         "is where a casting fails, and this one did not",
                         "only with " + case_file::outcome_words(v1::LineCasting::BLED_OUT),
                         "leave it out, or give the outcome");
  if (typed.has_at_m()) check_length(prefix + "at", typed.at_m(), 0.0, longest_casting, faults);
  if (typed.has_sawn_off_m())
    check_length(prefix + "sawn_off", typed.sawn_off_m(), 0.0, most_sawn_off, faults);
  if (typed.cold_curl_m_size() > most_points)
    *faults.Add() =
        intake::fault_of(prefix + "curl", fmt::format("{} points", typed.cold_curl_m_size()),
                         "has too many points", "at most 100", "leave some out");
  for (const double curl : typed.cold_curl_m())
    check_length(prefix + "curl", curl, -largest_curl, largest_curl, faults);
}

/// What a record has of its recipe; nothing but faults where it cannot be read.
v1::LineCasting record_of_recipe(Context& context, const Call& call, const std::string& prefix,
                                 const v1::CastingRecipe& recipe, Faults& faults) {
  v1::LineCasting record;
  if (!recipe.has_case_()) {
    readable_job(context, call.caller, recipe.job());
    v1::Case complete;
    if (jobs::read_complete_case(context.jobs_directory / recipe.job(), complete))
      studies::set_recipe(complete, record);
    else
      *faults.Add() = intake::fault_of(prefix + "job", recipe.job(), "has no case that can be read",
                                       "a job whose folder is whole", "name the case file");
    return record;
  }

  const auto examined = context.intake.complete_case(recipe.case_(), {});
  for (const v1::Fault& fault : examined.verdict.faults()) {
    *faults.Add() = fault;
    faults.rbegin()->set_field(prefix + fault.field());
  }
  if (examined.verdict.faults().empty()) studies::set_recipe(examined.complete, record);
  return record;
}

/// The record of one typed casting. @param record  with its recipe
v1::LineCasting typed_record(const v1::LineCasting& typed, v1::LineCasting record,
                             const std::string& user) {
  *record.mutable_begin_time() = jobs::now();
  studies::set_typed(typed, user, record);
  record.set_ended(true);
  return record;
}

void add_castings(Context& context, const Call& call, const v1::AddCastingsRequest& request,
                  v1::AddCastingsResponse& response) {
  check_line_name(request.id());
  check_text("request_id", request.request_id());
  if (request.castings().empty() || request.castings_size() > studies::most_castings)
    refuse(Remedy{"give one or more, in several requests if need be"},
           "castings has {} records, permitted are 1 to {}", request.castings_size(),
           studies::most_castings);

  std::vector<v1::LineCasting> recipes;
  for (int i = 0; i < request.recipes_size(); ++i)
    recipes.push_back(record_of_recipe(context, call, fmt::format("recipes[{}].", i),
                                       request.recipes(i), *response.mutable_faults()));
  std::vector<v1::LineCasting> records;
  for (int i = 0; i < request.castings_size(); ++i) {
    const auto& casting = request.castings(i);
    const std::string prefix = fmt::format("castings[{}].", i);
    check_record(prefix, casting.record(), *response.mutable_faults());
    if (casting.recipe() < 0 || casting.recipe() >= request.recipes_size())
      *response.add_faults() = intake::fault_of(
          prefix + "recipe", std::to_string(casting.recipe()), "names no recipe of the request",
          fmt::format("0 to {}", request.recipes_size() - 1), "name one of `recipes`");
    else
      records.push_back(
          typed_record(casting.record(), recipes[casting.recipe()], call.caller.name));
  }
  for (v1::Fault& fault : *response.mutable_faults()) intake::make_printable(fault);
  if (!response.faults().empty()) return;

  v1::AddCastingsRequest asked = request;
  asked.clear_request_id();
  const auto line = context.lines.reserve(request.id(), call.caller.name);
  const auto added = line.add_typed(std::move(records), request.request_id(),
                                    values::sha256(asked.SerializeAsString()));
  if (added.other_request)
    refuse(ErrorInfo::REQUEST_ID_TAKEN, Remedy{"choose a new one"},
           "line {} has other castings by this request_id", request.id());
  *response.mutable_castings() = {added.ids.begin(), added.ids.end()};
  response.set_repeated_request(added.repeated);
}

grpc::Status unknown_casting(const std::string& line, const std::string& id) {
  return make_status({.reason = ErrorInfo::NOT_FOUND,
                      .cause = fmt::format("line {} has no record {}", line, id),
                      .remedy = fmt::format("`dccast line show {}` lists them", line)});
}

}  // namespace

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

Unary* SimulationService::AddCastings(Wire* wire, const v1::AddCastingsRequest* request,
                                      v1::AddCastingsResponse* response) {
  return answer(wire, *request, pools_.durable,
                [=, this](const Call& call) { add_castings(context_, call, *request, *response); });
}

Unary* SimulationService::EditCasting(Wire* wire, const v1::EditCastingRequest* request,
                                      v1::LineCasting* response) {
  return answer(wire, *request, pools_.durable, [=, this](const Call& call) {
    Faults faults;
    check_record("", request->record(), faults);
    if (!faults.empty())
      refuse(Remedy{faults[0].remedy()}, "{} = {} {}; permitted: {}", faults[0].field(),
             faults[0].value(), faults[0].message(), faults[0].permitted());

    if (!context_.lines.owner(request->id())) throw Refusal{unknown_line(request->id())};
    auto edited =
        context_.lines.edit(request->id(), request->casting(), request->record(), call.caller.name);
    if (!edited) throw Refusal{unknown_casting(request->id(), request->casting())};
    *response = std::move(*edited);
  });
}

Unary* SimulationService::ForgetCastings(Wire* wire, const v1::ForgetCastingsRequest* request,
                                         v1::ForgetCastingsResponse*) {
  return answer(wire, *request, pools_.durable, [=, this](const Call&) {
    if (!context_.lines.owner(request->id())) throw Refusal{unknown_line(request->id())};
    const auto& castings = request->castings();
    const auto unknown = context_.lines.forget(request->id(), {castings.begin(), castings.end()});
    if (unknown) throw Refusal{unknown_casting(request->id(), *unknown)};
  });
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
