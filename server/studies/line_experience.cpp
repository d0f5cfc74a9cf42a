#include "server/studies/line_experience.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>
#include <vector>

#include "core/statistics/gaussian_process.hpp"
#include "core/statistics/line_posterior.hpp"
#include "core/statistics/robust_search.hpp"
#include "core/statistics/sampling.hpp"
#include "proto/case_file/override.hpp"
#include "server/studies/lines.hpp"
#include "server/studies/recipe_search.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::studies {

namespace {

using statistics::stack_rows;

constexpr std::size_t fewest_weighed = 12;  // that a surface of dangers needs
constexpr double fewest_draws = 30.0;       // without which there is no answer
constexpr double hand_noise_m = 3e-3;       // [A] of a curl that was measured by hand
constexpr double assumed_castings = 200.0;  // of a recipe that is cast daily [A]
constexpr double same_end_s = 1.0;
constexpr Eigen::Index most_members = 256;  // that a plan keeps
constexpr double is_wrong = 0.5;            // probability from which a record is named
constexpr std::uint64_t experience_seed = 61;

/// Place of a run on the axes, 0 to 1.
Eigen::RowVectorXd place_on_axes(const v1::Case& base, const v1::SweepPlan& sweep,
                                 const v1::StudyRun& run) {
  Eigen::RowVectorXd place(sweep.axes_size());
  for (int i = 0; i < sweep.axes_size(); ++i) {
    const auto& axis = sweep.axes(i);
    std::vector<double> ends;
    for (const std::string& value : axis.values())
      ends.push_back(number_of(base, axis.key(), value));
    const auto [low, high] = std::ranges::minmax(ends);
    place(i) = high > low ? (run.numbers(i) - low) / (high - low) : 0.5;
  }
  return place;
}

bool hangs_up(const v1::StudyRun& run) {
  return std::ranges::count(dangers_of(run), "hangs_up") > 0;
}

/// The surfaces over the runs of a study.
class Surfaces {
public:
  /// @throws CannotPredict
  Surfaces(const v1::StudyResult& result, const ExperienceQuestion& question) {
    std::vector<Eigen::RowVectorXd> places, valid;
    std::vector<double> curls;
    std::vector<bool> bleeds, hangs;
    for (const v1::StudyRun& run : result.runs()) {
      if (run.numbers_size() != result.study().sweep().axes_size()) continue;
      const auto known = recipe_run(run, question.monitor,
                                    place_on_axes(question.base, result.study().sweep(), run));
      if (!known) continue;

      // What is no hang-up is a bleed-out, or a butt that is lost in another way.
      places.push_back(known->place);
      hangs.push_back(hangs_up(run));
      bleeds.push_back(known->danger && !(hangs.back() && dangers_of(run).size() == 1));
      if (!known->curl_m) continue;
      valid.push_back(known->place);
      curls.push_back(*known->curl_m);
    }
    if (places.size() < fewest_weighed)
      throw CannotPredict(fmt::format(
          "what a line has cast is weighed over {} runs or more, and {} have ended; wait for more",
          fewest_weighed, places.size()));

    runs_ = static_cast<int>(places.size());
    const Eigen::MatrixXd all = stack_rows(places);
    dangers_.emplace_back(all, bleeds);
    if (std::ranges::count(hangs, true) > 0) dangers_.emplace_back(all, hangs);
    if (valid.size() >= fewest_weighed)
      curl_.emplace(stack_rows(valid),
                    Eigen::VectorXd::Map(curls.data(), static_cast<Eigen::Index>(curls.size())));
  }

  bool knows_hang_ups() const { return dangers_.size() > 1; }
  bool has_curl() const { return curl_.has_value(); }
  double curl_error() const {
    const Eigen::VectorXd& errors = curl_->left_out_errors();
    return errors.norm() / std::sqrt(static_cast<double>(errors.size()));
  }

  statistics::LineModel model(int inputs) const {
    statistics::LineModel model{.inputs = inputs, .dangers = {}, .curl = {}};
    for (const statistics::Classifier& danger : dangers_)
      model.dangers.push_back(
          {[&](const Eigen::MatrixXd& places) { return danger.answer(places); }, danger.error()});
    if (curl_)
      model.curl = {[this](const Eigen::MatrixXd& places) { return curl_->means(places); },
                    curl_error()};
    return model;
  }

  void describe(v1::LineExperience& experience) const {
    experience.set_runs(runs_);
    experience.set_misjudged(dangers_.front().misjudged());
    if (curl_) experience.set_curl_error_m(curl_error());
  }

private:
  int runs_ = 0;
  std::vector<statistics::Classifier> dangers_;  ///< bleed-outs, then hang-ups
  std::optional<statistics::GaussianProcess> curl_;
};

/// What a casting says of the dangers and of the curl; empty: nothing.
/// @param end_m  cast length at the end of the study
std::optional<statistics::LineRecord> record_of(const v1::LineCasting& casting,
                                                const Surfaces& surfaces, double end_s,
                                                double end_m) {
  statistics::LineRecord record;
  record.dangers.resize(surfaces.knows_hang_ups() ? 2 : 1);
  record.count = static_cast<double>(std::max<std::int64_t>(1, casting.count()));

  // A casting that failed behind the end of the study was sound as far as it knows.
  const bool sound =
      casting.outcome() == v1::LineCasting::SOUND || (casting.has_at_m() && casting.at_m() > end_m);
  if (sound) std::ranges::fill(record.dangers, false);
  if (!sound && casting.outcome() == v1::LineCasting::BLED_OUT) record.dangers.front() = true;
  if (!sound && casting.outcome() == v1::LineCasting::HUNG_UP && surfaces.knows_hang_ups())
    record.dangers.back() = true;

  const auto& curls = casting.cold_curl_m();
  if (!curls.empty() && surfaces.has_curl() &&
      std::abs(casting.recipe_end_s() - end_s) < same_end_s) {
    record.curl = std::accumulate(curls.begin(), curls.end(), 0.0) / curls.size();
    record.curl_noise = hand_noise_m;
  }
  const bool knows_danger =
      std::ranges::any_of(record.dangers, [](const auto& danger) { return danger.has_value(); });
  return knows_danger || record.curl ? std::optional(record) : std::nullopt;
}

/// The castings of a line that count, in the order of `experience.counted()`; says what the others
/// are.
std::vector<statistics::LineRecord> records_of(const ExperienceQuestion& question,
                                               const Surfaces& surfaces, double end_m,
                                               v1::LineExperience& experience) {
  const std::string recipe = recipe_name(question.base);
  std::vector<statistics::LineRecord> records;
  std::set<std::string> others;
  for (const v1::LineCasting& casting : question.line.castings()) {
    const auto count = std::max<std::int64_t>(1, casting.count());
    if (casting.recipe() != recipe) {
      others.insert(casting.title().empty() ? casting.recipe() : casting.title());
      experience.set_castings_of_others(experience.castings_of_others() + count);
      continue;
    }
    const auto record = record_of(casting, surfaces, question.base.time().end_s(), end_m);
    if (!record) {
      experience.set_castings_without_meaning(experience.castings_without_meaning() + count);
      continue;
    }
    experience.set_castings(experience.castings() + count);
    if (record->curl) experience.set_curls(experience.curls() + 1);
    experience.add_counted(casting.id());
    records.push_back(*record);
  }

  experience.set_records(experience.counted_size());
  *experience.mutable_other_recipes() = {others.begin(), others.end()};
  return records;
}

v1::LineExperience::State state_of(const statistics::LinePosterior& next, bool has_curl) {
  v1::LineExperience::State state;
  state.set_danger(next.danger);
  state.set_danger_low(next.danger_low);
  state.set_danger_high(next.danger_high);
  state.set_effective_draws(next.effective_draws);
  if (!has_curl) return state;
  state.set_low_m(next.curl_low);
  state.set_median_m(next.curl_median);
  state.set_high_m(next.curl_high);
  return state;
}

}  // namespace

LineAnswer ask_line(const v1::StudyResult& result, const ExperienceQuestion& question) {
  LineAnswer answer;
  v1::LineExperience& experience = answer.experience;
  experience.set_study(result.study().id());
  experience.set_end_s(question.base.time().end_s());
  experience.set_line(question.line.name());
  experience.set_assumed_sound(question.assume_sound);
  const Surfaces surfaces(result, question);
  surfaces.describe(experience);

  const auto& lengths = result.spread().cast_length_m();
  const double end_m = lengths.empty() ? 0.0 : *lengths.rbegin();
  auto records = records_of(question, surfaces, end_m, experience);
  if (question.assume_sound)
    records.push_back(
        {.dangers = std::vector<std::optional<bool>>(surfaces.knows_hang_ups() ? 2 : 1, false),
         .count = assumed_castings});

  const statistics::LineModel model = surfaces.model(result.study().sweep().axes_size());
  *experience.mutable_before() =
      state_of(statistics::next_casting(model, {}, experience_seed), surfaces.has_curl());
  const auto after = statistics::next_casting(model, records, experience_seed);
  for (int i = 0; i < experience.counted_size(); ++i)
    if (after.wrong(i) > is_wrong) experience.add_unexplained(experience.counted(i));

  if (after.effective_draws < fewest_draws) return answer;

  *experience.mutable_after() = state_of(after, surfaces.has_curl());
  experience.mutable_told()->Assign(after.told.begin(), after.told.end());
  answer.castings = after.castings;
  return answer;
}

void take_members(const LineAnswer& answer, const v1::SweepPlan& sweep, v1::RecipePlan& plan) {
  std::vector<Eigen::Index> axes;
  for (const v1::RecipePlan::Datum& datum : plan.data()) {
    const auto axis = std::ranges::find(sweep.axes(), datum.key(), &v1::SweepPlan::Axis::key);
    if (axis == sweep.axes().end() || axis->values(0) != datum.low() ||
        axis->values(1) != datum.high())
      throw CannotPredict(
          fmt::format("study {} has no range {}..{} of {}; dccast uncertainty CASE computes the "
                      "ranges of today",
                      answer.experience.study(), datum.low(), datum.high(), datum.key()));
    axes.push_back(axis - sweep.axes().begin());
  }
  for (Eigen::Index i = 0; i < std::min(answer.castings.rows(), most_members); ++i)
    for (const Eigen::Index axis : axes)
      plan.add_members(static_cast<float>(answer.castings(i, axis)));
}

std::vector<v1::CaseChange> middle_casting(const LineAnswer& answer, const v1::SweepPlan& sweep,
                                           const v1::Case& base) {
  Eigen::Index middle = 0;
  (answer.castings.rowwise() - answer.castings.colwise().mean())
      .rowwise()
      .squaredNorm()
      .minCoeff(&middle);

  std::vector<v1::CaseChange> changes;
  for (int i = 0; i < sweep.axes_size(); ++i) {
    const auto& axis = sweep.axes(i);
    changes.push_back(case_file::change_of(
        axis.key(), value_between(base, axis.key(), axis.values(0), axis.values(1),
                                  answer.castings(middle, i))));
  }
  return changes;
}

}  // namespace dccast::studies
