#include "server/studies/recipe_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "core/statistics/sampling.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/schedule.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::studies {

namespace {

using case_file::Recipe;
using case_file::RecipeNumber;
using statistics::stack_rows;

constexpr std::size_t fewest_valid = 12;  // drafts that a surface needs at least
constexpr int search_samples = 96, score_samples = 512;
constexpr std::uint64_t score_seed = 20;
// A recipe that risks a fifth of all castings more than the safest one is no alternative.
constexpr double more_risk = 0.2;

/// Whether the recipe may be the cause. A run that does not converge is not known to be safe.
bool by_the_recipe(const v1::Finding& failure) {
  return by_the_case_itself(failure) && failure.kind() != v1::Finding::INVALID_CASE;
}

}  // namespace

RecipeSpace::RecipeSpace(const v1::Case& draft, const v1::RecipePlan& plan)
    : draft_(draft), plan_(plan) {
  plan_.clear_draft();
  for (const v1::RecipePlan::Number& number : plan_.numbers()) {
    const auto found = std::ranges::find(case_file::recipe_names, number.name());
    ends_.push_back({static_cast<RecipeNumber>(found - case_file::recipe_names.begin()),
                     number.low(), number.high()});
  }
}

const RecipeSpace::Ends* RecipeSpace::ends_of(RecipeNumber number) const {
  const auto found = std::ranges::find(ends_, number, &Ends::number);
  return found == ends_.end() ? nullptr : &*found;
}

Recipe RecipeSpace::recipe(const Eigen::RowVectorXd& design) const {
  Recipe recipe = case_file::recipe_of(draft_);
  for (int i = 0; i < numbers(); ++i) recipe[ends_[i].number] = number(i, design);
  return recipe;
}

Eigen::RowVectorXd RecipeSpace::design(const Recipe& recipe) const {
  Eigen::RowVectorXd design(ends_.size());
  for (std::size_t i = 0; i < ends_.size(); ++i)
    design(i) = (recipe[ends_[i].number] - ends_[i].low) / (ends_[i].high - ends_[i].low);
  return design;
}

/// Lengthens a ramp that changes speed or water faster than `rate` [unit/s]; shortens the step if
/// the ramp cannot become long enough.
/// @param start  number of the value at the start; the next two are those of the run and the ramp
void RecipeSpace::keep_rate(Recipe& recipe, RecipeNumber start, double rate) const {
  const auto run = static_cast<RecipeNumber>(start + 1),
             ramp = static_cast<RecipeNumber>(start + 2);
  const v1::Schedule& schedule = draft_.schedule();
  const bool by_length =
      case_file::is_by_length(start == case_file::speed_start ? schedule.casting_speed_m_per_s()
                                                              : schedule.water_flow_m2_per_s());

  // A ramp by length lasts as long as its length takes at the mean speed.
  const double per_second =
      by_length ? 0.5 * (recipe[case_file::speed_start] + recipe[case_file::speed_run]) : 1.0;
  const double step = recipe[run] - recipe[start];
  const double shortest = std::abs(step) / rate * per_second;
  if (recipe[ramp] >= shortest) return;

  const Ends* ends = ends_of(ramp);
  const double longest = ends == nullptr ? recipe[ramp] : std::max(ends->high, recipe[ramp]);
  recipe[ramp] = std::min(shortest, longest);
  if (shortest > longest) recipe[run] = recipe[start] + step * longest / shortest;
}

Eigen::RowVectorXd RecipeSpace::permitted(const Eigen::RowVectorXd& design) const {
  Recipe changed = recipe(design);
  keep_rate(changed, case_file::speed_start, plan_.greatest_speed_rate_m_per_s2());
  keep_rate(changed, case_file::water_start, plan_.greatest_flow_rate_m2_per_s2());
  if (ends_of(case_file::filling) != nullptr)
    changed[case_file::filling] = std::min(changed[case_file::filling], changed[case_file::hold]);
  return this->design(changed);
}

std::vector<v1::CaseChange> RecipeSpace::changes(const Eigen::RowVectorXd& design) const {
  return case_file::recipe_changes(draft_, recipe(design));
}

double RecipeSpace::casting_time_s(const Eigen::RowVectorXd& design) const {
  v1::Case changed;  // with what changes and nothing else: a case is large
  *changed.mutable_schedule() = draft_.schedule();
  *changed.mutable_time() = draft_.time();
  case_file::apply_changes(changed, case_file::recipe_changes(changed, recipe(design)));
  return changed.schedule().hold_s() + changed.time().end_s();
}

Eigen::MatrixXd RecipeSpace::castings(int count, std::uint64_t seed) const {
  const auto& members = plan_.members();
  if (members.empty()) return statistics::hypercube(count, data(), seed);

  std::mt19937_64 random(seed);
  const int known = members.size() / data();
  Eigen::MatrixXd castings(count, data());
  for (auto casting : castings.rowwise()) {
    const int member = static_cast<int>(known * statistics::uniform(random));
    for (int i = 0; i < data(); ++i) casting(i) = members.at(member * data() + i);
  }
  return castings;
}

std::vector<v1::CaseChange> RecipeSpace::data_changes(const Eigen::RowVectorXd& data) const {
  std::vector<v1::CaseChange> changes;
  for (int i = 0; i < plan_.data_size(); ++i) {
    const v1::RecipePlan::Datum& datum = plan_.data(i);
    changes.push_back(case_file::change_of(
        datum.key(), value_between(draft_, datum.key(), datum.low(), datum.high(), data(i))));
  }
  return changes;
}

bool RecipeRun::lost(const v1::RecipePlan& plan, double scale) const {
  if (danger || !curl_m) return true;
  return scale * *curl_m < plan.least_curl_m() || scale * *curl_m > plan.greatest_curl_m();
}

std::vector<std::string> dangers_of(const v1::StudyRun& run) {
  std::vector<std::string> codes;
  for (const v1::Finding& finding : run.findings())
    if (finding.severity() == v1::Finding::DANGER && !std::ranges::count(codes, finding.code()))
      codes.push_back(finding.code());
  if (run.has_failure() && !std::ranges::count(codes, run.failure().code()))
    codes.push_back(run.failure().code().empty() ? v1::Finding::Kind_Name(run.failure().kind())
                                                 : run.failure().code());
  return codes;
}

std::optional<RecipeRun> recipe_run(const v1::StudyRun& run, int monitor,
                                    Eigen::RowVectorXd place) {
  const bool succeeded = run.state() == v1::SUCCEEDED;
  if (!succeeded && !(run.state() == v1::FAILED && by_the_recipe(run.failure())))
    return std::nullopt;
  RecipeRun known{std::move(place), std::nullopt, !dangers_of(run).empty()};
  if (succeeded && !run.beyond_validity() && monitor < run.end_curl_m_size() &&
      std::isfinite(run.end_curl_m(monitor)))
    known.curl_m = run.end_curl_m(monitor);
  known.danger = known.danger || !known.curl_m;
  return known;
}

RecipeSearch::RecipeSearch(std::shared_ptr<const RecipeSpace> space,
                           const std::vector<RecipeRun>& runs, double scale)
    : space_(std::move(space)), scale_(scale), runs_(static_cast<int>(runs.size())) {
  std::vector<Eigen::RowVectorXd> places, valid;
  std::vector<double> curls;
  std::vector<bool> dangers;
  for (const RecipeRun& run : runs) {
    places.push_back(run.place);
    dangers.push_back(run.danger);
    dangers_ += run.danger ? 1 : 0;
    if (!run.curl_m) continue;
    valid.push_back(run.place);
    curls.push_back(scale * *run.curl_m);
  }

  if (valid.size() < fewest_valid)
    throw std::runtime_error(
        fmt::format("{} of {} drafts end with a valid curl; a surface needs {} or more",
                    valid.size(), runs.size(), fewest_valid));

  // Every draft shows whether a recipe is dangerous, but only valid ones give a curl.
  curl_.emplace(stack_rows(valid), Eigen::Map<const Eigen::VectorXd>(curls.data(), curls.size()));
  error_m_ = curl_->left_out_errors().norm() / std::sqrt(static_cast<double>(curls.size()));
  danger_.emplace(stack_rows(places), dangers);

  const v1::RecipePlan& plan = space_->plan();
  problem_ = {.design_inputs = space_->numbers(),
              .least = plan.least_curl_m(),
              .greatest = plan.greatest_curl_m(),
              .outcomes =
                  [this](const Eigen::MatrixXd& points) {
                    return statistics::Outcomes{curl_->means(points), danger_->probability(points),
                                                error_m_};
                  },
              .cost = [this](const auto& design) { return space_->casting_time_s(design); },
              .permitted = [this](const auto& design) { return space_->permitted(design); }};
}

std::vector<statistics::ScoredDesign> RecipeSearch::candidates(std::uint64_t seed) const {
  auto chosen = statistics::spread_over(
      statistics::pareto_front(problem_, space_->castings(search_samples, seed), seed),
      space_->plan().candidates(), more_risk);
  for (auto& candidate : chosen) candidate.score = score(candidate.design);
  return chosen;
}

statistics::DesignScore RecipeSearch::score(const Eigen::RowVectorXd& design) const {
  return statistics::score_design(problem_, design, space_->castings(score_samples, score_seed));
}

statistics::Share RecipeSearch::risk(const statistics::DesignScore& score,
                                     const std::vector<RecipeRun>& castings) const {
  std::vector<Eigen::RowVectorXd> places;
  std::vector<bool> lost;
  for (const RecipeRun& casting : castings) {
    places.push_back(casting.place);
    lost.push_back(casting.lost(space_->plan(), scale_));
  }
  if (places.empty()) return statistics::corrected_share(score.risk, {}, {});
  return statistics::corrected_share(score.risk, statistics::risk_at(problem_, stack_rows(places)),
                                     lost);
}

void RecipeSearch::describe(v1::RecipeFound& found) const {
  found.set_full_over_draft(scale_);
  found.set_surface_error_m(error_m_);
  found.set_misjudged(danger_->misjudged());
  found.set_runs(runs_);
  found.set_dangers(dangers_);
}

}  // namespace dccast::studies
