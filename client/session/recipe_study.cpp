#include "client/session/recipe_study.hpp"

#include <algorithm>
#include <set>

#include "client/session/data_study.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/recipe_numbers.hpp"
#include "proto/case_file/uncertainty.hpp"
#include "proto/values/digests.hpp"

namespace dccast::client {
namespace {

using case_file::RecipeNumber;

struct Ends {
  double low, high;
};

[[noreturn]] void refuse(const std::string& option, const std::string& text,
                         const std::string& why) {
  throw CommandFailed(ExitCode::invalid, option + " " + text + ": " + why);
}

/// @param whole  text of the option that the quantity is a part of; empty: the quantity itself
double quantity_of(const std::string& option, const std::string& text, const std::string& unit,
                   const std::string& whole = {}) {
  const case_file::Quantity quantity = case_file::parse_quantity(text, unit);
  if (!quantity.value) refuse(option, whole.empty() ? text : whole, quantity.message);
  return *quantity.value;
}

Ends ends_of(const std::string& option, const std::string& text, const std::string& unit) {
  const auto range = case_file::parse_range(text);
  if (!range || !range->suffix.empty()) refuse(option, text, "write it as 20..80 with its unit");
  const Ends ends{quantity_of(option, range->low, unit, text),
                  quantity_of(option, range->high, unit, text)};
  if (!(ends.low >= 0.0)) refuse(option, text, "permitted: 0 or more");
  return ends;
}

/// One number of a recipe and the option that limits it.
struct Limited {
  RecipeNumber number;
  const char* option;
  std::string text;
  const char* unit;
};

void add_number(const Limited& limited, double value, double least_share, double greatest_share,
                v1::RecipePlan& plan) {
  if (!(value > 0.0)) return;  // the case does without it
  const std::string name = case_file::recipe_names[limited.number];
  const Ends limits = ends_of(limited.option, limited.text, limited.unit);
  const Ends ends{std::max(least_share * value, limits.low),
                  std::min(greatest_share * value, limits.high)};
  if (!(ends.low < ends.high))
    refuse(
        limited.option, limited.text,
        name + " of the case is " + case_file::number_text(value) + " " + limited.unit +
            ", and nothing near it is inside this limit; change the limit, the case, or --within");
  v1::RecipePlan::Number& number = *plan.add_numbers();
  number.set_name(name);
  number.set_low(ends.low);
  number.set_high(ends.high);
}

void add_numbers(const v1::Case& draft, const RecipeChoice& choice, v1::RecipePlan& plan) {
  const case_file::Recipe recipe = case_file::recipe_of(draft);
  const double within = 0.01 * choice.within_percent;
  const auto level = [&](RecipeNumber number, const char* option, const std::string& text,
                         const char* unit) {
    add_number({number, option, text, unit}, recipe[number], 1.0 - within, 1.0 + within, plan);
  };
  const auto time = [&](RecipeNumber number, const char* option, const std::string& text) {
    add_number({number, option, text, "s"}, recipe[number], 0.5, 2.0, plan);
  };
  // A ramp along the slab is a length, which no limit of a time holds for.
  const auto ramp = [&](RecipeNumber number, const v1::Curve& curve) {
    if (case_file::ramps_by_length(curve))
      add_number({number, "--ramp", "0..10 m", "m"}, recipe[number], 0.5, 2.0, plan);
    else
      time(number, "--ramp", choice.ramp);
  };
  level(case_file::speed_start, "--speed", choice.speed, "m/s");
  level(case_file::speed_run, "--speed", choice.speed, "m/s");
  ramp(case_file::speed_ramp, draft.schedule().casting_speed_m_per_s());
  time(case_file::filling, "--filling", choice.filling);
  time(case_file::hold, "--hold", choice.hold);
  if (!draft.cooling().water().enabled()) return;
  level(case_file::water_start, "--water", choice.water, "m2/s");
  level(case_file::water_run, "--water", choice.water, "m2/s");
  ramp(case_file::water_ramp, draft.schedule().water_flow_m2_per_s());
}

/// All data with a range but those that the recipe itself sets.
void add_data(const std::vector<case_file::UncertainKey>& keys, v1::RecipePlan& plan) {
  const std::set<std::string> of_recipe{"schedule.casting_speed", "schedule.water_flow",
                                        "schedule.hold", "schedule.filling", "time.end"};
  for (const case_file::UncertainKey& key : keys) {
    if (of_recipe.contains(key.key.substr(0, key.key.find('[')))) continue;
    v1::RecipePlan::Datum& datum = *plan.add_data();
    datum.set_key(key.change());
    datum.set_low(key.ends.low);
    datum.set_high(key.ends.high);
  }
  if (plan.data().empty())
    throw CommandFailed(ExitCode::invalid,
                        "no key of this case has a range; give some in [uncertainty] "
                        "(docs/uncertainty.md)");
}

void add_band(const RecipeChoice& choice, const v1::Case& complete, v1::RecipePlan& plan) {
  if (!choice.band.empty()) {
    const auto range = case_file::parse_range(choice.band);
    if (!range || !range->suffix.empty()) refuse("--band", choice.band, "write it as 35..45 mm");
    plan.set_least_curl_m(quantity_of("--band", range->low, "m", choice.band));
    plan.set_greatest_curl_m(quantity_of("--band", range->high, "m", choice.band));
    return;
  }
  const v1::Plausibility& accepted = complete.plausibility();
  if (!accepted.has_least_curl_m() || !accepted.has_greatest_curl_m())
    throw CommandFailed(ExitCode::invalid,
                        "give the curls that the plant accepts, e.g. --band \"35..45 mm\"");
  plan.set_least_curl_m(accepted.least_curl_m());
  plan.set_greatest_curl_m(accepted.greatest_curl_m());
}

std::string uuid_of(const std::string& text) {
  std::string id = values::sha256(text).substr(0, 32);
  for (const std::size_t at : {8, 13, 18, 23}) id.insert(at, "-");
  return id;
}

}  // namespace

void lay_out_recipe(Connection& connection, const RecipeChoice& choice,
                    v1::CreateStudyRequest& request) {
  v1::CreateStudyRequest draft = request;
  draft.mutable_case_()->set_quality(v1::DRAFT);
  const auto keys = complete_case(connection, draft);
  complete_case(connection, request);
  v1::RecipePlan& plan = *request.mutable_recipe();
  add_band(choice, request.case_(), plan);
  add_numbers(draft.case_(), choice, plan);
  add_data(keys, plan);
  *plan.mutable_draft() = draft.case_();
  plan.set_monitor(choice.point);
  plan.set_greatest_speed_rate_m_per_s2(quantity_of("--speed-rate", choice.speed_rate, "m/s2"));
  plan.set_greatest_flow_rate_m2_per_s2(quantity_of("--water-rate", choice.water_rate, "m2/s2"));
  plan.set_drafts(choice.drafts);
  plan.set_castings(choice.castings);
  plan.set_candidates(choice.candidates);
  plan.set_seed(choice.seed);
  request.clear_request_id();
  request.set_request_id(uuid_of(request.SerializeAsString()));
}

v1::Study taken_up(Connection& connection, const v1::Study& study) {
  if (study.state() != v1::STUDY_CANCELLED && study.state() != v1::STUDY_FAILED) return study;
  v1::ResumeStudyRequest request;
  request.set_id(study.id());
  return connection.call_once(&Stub::ResumeStudy, request);
}

void cancel_after_interruption(const Connection& interrupted, const std::string& id) {
  Connection connection = interrupted.another(std::make_shared<Interruption>());
  v1::CancelStudyRequest request;
  request.set_id(id);
  request.set_reason("interrupted");
  connection.call(&Stub::CancelStudy, request);
}

}  // namespace dccast::client
