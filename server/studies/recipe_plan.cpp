// The search for recipes of a start, in three rounds. Drafts over recipe and data give surfaces,
// which propose candidates. Castings at these improve the surfaces, which propose better
// candidates. Castings at those, from which no surface learns, and a run of each at full quality
// judge them.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <mutex>
#include <set>
#include <stdexcept>

#include "core/statistics/sampling.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/quantity.hpp"
#include "server/intake/case_intake.hpp"
#include "server/studies/recipe_search.hpp"
#include "server/studies/study_plan.hpp"

#include <fmt/format.h>

namespace dccast::studies {

namespace {

using intake::fault_of;
using statistics::ScoredDesign;

// Numbers of the first runs. The case itself comes first, as a draft and at full quality: their
// ratio corrects the curls of all drafts.
constexpr int draft_of_case = 0, full_of_case = 1, first_draft = 2;
constexpr double least_curl_compared = 1e-3;  // [m] below it a ratio of curls means nothing
constexpr double least_scale = 0.5, greatest_scale = 2.0;  // other ratios are not applied

/// A run of a candidate.
struct CandidateRun {
  int candidate = 0;
  int casting = -1;  ///< over the data; -1: at full quality with the data of the case
};

/// Candidates that were proposed, and the surfaces that did.
struct Round {
  std::shared_ptr<const RecipeSearch> search;
  std::vector<ScoredDesign> candidates;
  std::string fault;  ///< why there are none
};

class RecipeStudy final : public StudyPlan {
public:
  explicit RecipeStudy(const v1::CreateStudyRequest& request)
      : full_(request.case_()),
        draft_(request.recipe().draft()),
        plan_(request.recipe()),
        space_(std::make_shared<RecipeSpace>(draft_, plan_)),
        drafts_(statistics::hypercube(plan_.drafts(), space_->numbers() + space_->data(),
                                      plan_.seed())) {
    for (Eigen::Index i = 0; i < drafts_.rows(); ++i)
      drafts_.row(i).head(space_->numbers()) =
          space_->permitted(drafts_.row(i).head(space_->numbers()));
  }

  int runs() const override { return first_draft + plan_.drafts(); }
  int most_runs() const override { return final_round() + plan_.candidates() + castings(); }
  bool outlasts_failures() const override { return true; }
  int rests_on(int number) const override {
    return number < final_round() ? runs() : final_round();
  }

  PlannedRun run(int number) const override {
    if (number == draft_of_case) return planned(number, "the case itself, draft", draft_, {});
    if (number == full_of_case) return planned(number, "the case itself", full_, {});
    const Eigen::RowVectorXd place = drafts_.row(number - first_draft);
    return planned(number, "draft " + std::to_string(number - first_draft + 1), draft_,
                   changes_at(place));
  }

  std::optional<PlannedRun> next(int number,
                                 const std::vector<EvaluatedRun>& before) const override {
    const auto round = round_of(number, before);
    if (round == nullptr) return std::nullopt;
    const auto which = candidate_run(number, *round);
    if (!which) return std::nullopt;
    const std::string name = "candidate " + std::to_string(which->candidate + 1);
    const auto& design = round->candidates[which->candidate].design;
    if (which->casting < 0) return planned(number, name, full_, space_->changes(design));
    return planned(number, name + ", casting " + std::to_string(which->casting + 1), draft_,
                   changes_at(place_of(number, *which, *round)));
  }

  void evaluate(const std::vector<EvaluatedRun>& runs, v1::StudyResult& result) const override {
    v1::RecipeFound& found = *result.mutable_recipe();
    found.set_chosen(-1);

    const auto round = round_of(final_round(), runs);
    if (round == nullptr) {
      found.set_fault("the drafts of this study have not all ended, or some were lost");
      return;
    }

    found.set_fault(round->fault);
    if (round->search == nullptr) return;
    round->search->describe(found);

    const int monitor = monitor_of(runs);
    if (monitor < full_.monitor_size()) found.set_monitor(full_.monitor(monitor).name());
    add_itself(*round, found);
    for (int candidate = 0; candidate < std::ssize(round->candidates); ++candidate)
      add_candidate(*round, candidate, monitor, runs, *found.add_front());
    choose(found);
  }

private:
  int castings() const { return plan_.candidates() * plan_.castings(); }
  int trial_round() const { return runs(); }
  int final_round() const { return trial_round() + castings(); }

  std::vector<v1::CaseChange> changes_at(const Eigen::RowVectorXd& place) const {
    auto changes = space_->changes(place.head(space_->numbers()));
    const auto data = space_->data_changes(place.tail(space_->data()));
    changes.insert(changes.end(), data.begin(), data.end());
    return changes;
  }

  /// What a run of a round does; nothing beyond its end. Where there are fewer candidates than the
  /// plan asks for, each has more castings.
  std::optional<CandidateRun> candidate_run(int number, const Round& round) const {
    const int candidates = static_cast<int>(round.candidates.size());
    if (candidates == 0) return std::nullopt;
    int place = number - (number < final_round() ? trial_round() : final_round());
    if (number >= final_round()) {
      if (place < candidates) return CandidateRun{place};
      place -= candidates;
    }
    if (place >= castings()) return std::nullopt;
    return CandidateRun{place % candidates, place / candidates};
  }

  /// Of a casting at a candidate: its design, and data of the candidate's own.
  Eigen::RowVectorXd place_of(int number, const CandidateRun& which, const Round& round) const {
    const int candidates = static_cast<int>(round.candidates.size());
    const int each = (castings() + candidates - 1) / candidates;
    const std::uint64_t of_round = number < final_round() ? 1000 : 2000;
    const Eigen::MatrixXd data =
        space_->castings(each, plan_.seed() + of_round + static_cast<unsigned>(which.candidate));
    Eigen::RowVectorXd place(space_->numbers() + space_->data());
    place << round.candidates[which.candidate].design, data.row(which.casting);
    return place;
  }

  /// The monitor of the plan or of output.curl, or that with the largest curl of a run laid out
  /// beforehand.
  int monitor_of(const std::vector<EvaluatedRun>& runs) const {
    const std::string& name = plan_.monitor().empty() ? full_.output().curl() : plan_.monitor();
    for (int m = 0; m < full_.monitor_size(); ++m)
      if (full_.monitor(m).name() == name) return m;
    int largest = 0;
    double most = -1.0;
    for (const EvaluatedRun& evaluated : runs)
      for (int m = 0; evaluated.number < trial_round() && m < evaluated.run.end_curl_m_size(); ++m)
        if (std::abs(evaluated.run.end_curl_m(m)) > most) {
          most = std::abs(evaluated.run.end_curl_m(m));
          largest = m;
        }
    return largest;
  }

  double scale_of(const std::vector<EvaluatedRun>& runs, int monitor) const {
    std::array<std::optional<double>, 2> curls;
    for (const EvaluatedRun& evaluated : runs)
      if (evaluated.number < first_draft)
        if (const auto known = recipe_run(evaluated.run, monitor, {}))
          curls[evaluated.number] = known->curl_m;
    if (!curls[0] || !curls[1] || std::abs(*curls[0]) < least_curl_compared) return 1.0;
    const double scale = *curls[full_of_case] / *curls[draft_of_case];
    return scale > least_scale && scale < greatest_scale ? scale : 1.0;
  }

  /// Candidates of the round that a run belongs to, from the runs it rests on.
  /// @return null while these have not all ended, or where some were cancelled, deleted, or lost to
  /// their machine: with them there might be other candidates
  std::shared_ptr<const Round> round_of(int number, const std::vector<EvaluatedRun>& runs) const {
    const std::lock_guard lock(mutex_);
    std::shared_ptr<const Round> trial;
    for (std::size_t which = 0; which < rounds_.size(); ++which) {
      auto& kept = rounds_[which];
      if (kept == nullptr) {
        if (!have_ended(runs, which == 0 ? trial_round() : final_round())) return nullptr;
        kept = std::make_shared<const Round>(proposed(which, trial.get(), runs));
      }
      trial = kept;
      if (number < final_round() || trial->search == nullptr) break;
    }
    return trial;
  }

  /// @param count  of the first runs of the plan
  static bool have_ended(const std::vector<EvaluatedRun>& runs, int count) {
    return std::ranges::count_if(runs, [&](const EvaluatedRun& evaluated) {
             const v1::StudyRun& run = evaluated.run;
             return evaluated.number < count &&
                    (run.state() == v1::SUCCEEDED ||
                     (run.state() == v1::FAILED && by_the_case_itself(run.failure())));
           }) >= count;
  }

  /// Finds candidates with surfaces of all runs that have ended.
  /// @param which  0: from the drafts alone; 1: with the castings of the trial round too
  /// @param trial  result of the trial round; null in that round itself
  Round proposed(std::size_t which, const Round* trial,
                 const std::vector<EvaluatedRun>& runs) const {
    const int monitor = monitor_of(runs);
    std::vector<RecipeRun> known;
    for (const EvaluatedRun& evaluated : runs) {
      const int number = evaluated.number;
      if (number < first_draft || number >= (trial == nullptr ? trial_round() : final_round()))
        continue;

      const Eigen::RowVectorXd place =
          number < trial_round() ? Eigen::RowVectorXd(drafts_.row(number - first_draft))
                                 : place_of(number, *candidate_run(number, *trial), *trial);
      if (auto run = recipe_run(evaluated.run, monitor, place)) known.push_back(std::move(*run));
    }

    Round round;
    try {
      round.search = std::make_shared<RecipeSearch>(space_, known, scale_of(runs, monitor));
      round.candidates = round.search->candidates(plan_.seed() + 100 * (which + 1));
    } catch (const std::runtime_error& reason) {
      round.fault = reason.what();
    }
    return round;
  }

  /// Writes a candidate with its numbers, score and risk.
  /// @param castings  runs at this design, of which the surfaces do not know
  void write(const RecipeSearch& search, const ScoredDesign& scored,
             const std::vector<RecipeRun>& castings, v1::RecipeFound::Candidate& candidate) const {
    for (int i = 0; i < space_->numbers(); ++i)
      candidate.add_numbers(space_->number(i, scored.design));

    const auto changes = space_->changes(scored.design);
    *candidate.mutable_changes() = {changes.begin(), changes.end()};

    candidate.set_low_m(scored.score.low);
    candidate.set_median_m(scored.score.median);
    candidate.set_high_m(scored.score.high);
    candidate.set_danger(scored.score.danger);
    candidate.set_surface_risk(scored.score.risk);
    candidate.set_casting_time_s(scored.score.cost);

    // The risk combines the score with the castings that were run at the design.
    const statistics::Share share = search.risk(scored.score, castings);
    candidate.set_risk(share.value);
    candidate.set_risk_error(share.error);
    candidate.set_castings(static_cast<int>(castings.size()));
    candidate.set_lost(static_cast<int>(std::ranges::count_if(
        castings, [&](const RecipeRun& run) { return run.lost(plan_, search.scale()); })));
  }

  /// Adds the case's own recipe, unless it lies too far outside the domain.
  void add_itself(const Round& round, v1::RecipeFound& found) const {
    const Eigen::RowVectorXd design = space_->design(case_file::recipe_of(draft_));
    constexpr double outside = 0.1;  // of a range; surfaces do not extrapolate farther
    if (design.minCoeff() < -outside || design.maxCoeff() > 1.0 + outside) return;
    write(*round.search, {design, round.search->score(design)}, {}, *found.mutable_itself());
  }

  void add_candidate(const Round& round, int number, int monitor,
                     const std::vector<EvaluatedRun>& runs,
                     v1::RecipeFound::Candidate& candidate) const {
    std::vector<RecipeRun> castings;
    for (const EvaluatedRun& evaluated : runs) {
      if (evaluated.number < final_round()) continue;
      const auto which = candidate_run(evaluated.number, round);
      if (!which || which->candidate != number) continue;

      if (which->casting < 0)
        write_full(evaluated.run, monitor, candidate);
      else if (auto run =
                   recipe_run(evaluated.run, monitor, place_of(evaluated.number, *which, round)))
        castings.push_back(std::move(*run));
    }
    write(*round.search, round.candidates[number], castings, candidate);
  }

  static void write_full(const v1::StudyRun& run, int monitor,
                         v1::RecipeFound::Candidate& candidate) {
    candidate.set_full_state(run.state());
    candidate.set_full_job(run.job());
    const auto known = recipe_run(run, monitor, {});
    if (known && known->curl_m) candidate.set_full_curl_m(*known->curl_m);
    const auto dangers = dangers_of(run);
    *candidate.mutable_full_dangers() = {dangers.begin(), dangers.end()};
  }

  /// Sorts the front by risk and chooses the first candidate whose full run ends inside the band
  /// without danger.
  void choose(v1::RecipeFound& found) const {
    auto& front = *found.mutable_front();
    std::stable_sort(front.begin(), front.end(),
                     [](const auto& a, const auto& b) { return a.risk() < b.risk(); });

    const auto confirmed = std::ranges::find_if(front, [this](const auto& candidate) {
      return candidate.has_full_curl_m() && candidate.full_dangers().empty() &&
             candidate.full_curl_m() >= plan_.least_curl_m() &&
             candidate.full_curl_m() <= plan_.greatest_curl_m();
    });
    if (confirmed != front.end()) found.set_chosen(static_cast<int>(confirmed - front.begin()));
  }

  v1::Case full_, draft_;
  v1::RecipePlan plan_;
  std::shared_ptr<const RecipeSpace> space_;
  Eigen::MatrixXd drafts_;  ///< (draft, numbers and data)
  mutable std::mutex mutex_;
  mutable std::array<std::shared_ptr<const Round>, 2> rounds_;  ///< once their runs have ended
};

std::vector<v1::Fault> number_faults(const v1::RecipePlan& plan) {
  std::vector<v1::Fault> faults;
  std::set<std::string> names;

  for (const v1::RecipePlan::Number& number : plan.numbers()) {
    // Each number is a known one, and occurs once.
    if (std::ranges::find(case_file::recipe_names, number.name()) ==
            case_file::recipe_names.end() ||
        !names.insert(number.name()).second)
      faults.push_back(fault_of("recipe.numbers", number.name(),
                                "is no number of a recipe, or twice",
                                "speed_start, speed_run, speed_ramp, filling, hold, water_start, "

                                "water_run, water_ramp, each once"));
    // Each range is finite and not empty.
    if (!(number.low() >= 0.0 && number.high() > number.low() && std::isfinite(number.high())))
      faults.push_back(fault_of(fmt::format("recipe.{}", number.name()),
                                fmt::format("{}..{}", case_file::number_text(number.low()),
                                            case_file::number_text(number.high())),
                                "is no range", "0 or more, the smaller end first"));
  }

  if (names.empty())
    faults.push_back(
        fault_of("recipe.numbers", "", "there is nothing to choose", "one number or more"));
  return faults;
}

void check_count(const std::string& field, int value, int least, int most,
                 std::vector<v1::Fault>& faults) {
  if (value < least || value > most)
    faults.push_back(fault_of(fmt::format("recipe.{}", field), fmt::to_string(value),
                              "is out of range", fmt::format("{} to {}", least, most)));
}

/// Checks the uncertain data as what they are run with: the axes of a Latin hypercube.
std::vector<v1::Fault> data_faults(const v1::CreateStudyRequest& request) {
  v1::CreateStudyRequest sweep;
  *sweep.mutable_case_() = request.recipe().draft();
  sweep.mutable_sweep()->set_design(v1::SweepPlan::LATIN_HYPERCUBE);
  sweep.mutable_sweep()->set_runs(1);
  for (const v1::RecipePlan::Datum& datum : request.recipe().data()) {
    v1::SweepPlan::Axis& axis = *sweep.mutable_sweep()->add_axes();
    axis.set_key(datum.key());
    axis.add_values(datum.low());
    axis.add_values(datum.high());
  }
  return sweep_faults(sweep);
}

}  // namespace

std::vector<v1::Fault> recipe_faults(const v1::CreateStudyRequest& request) {
  const v1::RecipePlan& plan = request.recipe();
  auto faults = number_faults(plan);

  if (!plan.has_draft())
    faults.push_back(fault_of("recipe.draft", "", "is absent", "the case at draft quality"));

  if (!(plan.greatest_curl_m() > plan.least_curl_m()))
    faults.push_back(fault_of("recipe.band",
                              fmt::format("{}..{}", case_file::number_text(plan.least_curl_m()),
                                          case_file::number_text(plan.greatest_curl_m())),
                              "is no band", "two curls, the smaller one first"));

  if (!(plan.greatest_speed_rate_m_per_s2() > 0.0))
    faults.push_back(fault_of("recipe.greatest_speed_rate", "", "is out of range", "above 0"));
  if (!(plan.greatest_flow_rate_m2_per_s2() > 0.0))
    faults.push_back(fault_of("recipe.greatest_flow_rate", "", "is out of range", "above 0"));

  check_count("drafts", plan.drafts(), 12, 5000, faults);
  check_count("castings", plan.castings(), 2, 200, faults);
  check_count("candidates", plan.candidates(), 1, 10, faults);

  if (!faults.empty()) return faults;
  return data_faults(request);
}

std::unique_ptr<StudyPlan> recipe_plan(const v1::CreateStudyRequest& request) {
  return std::make_unique<RecipeStudy>(request);
}

}  // namespace dccast::studies
