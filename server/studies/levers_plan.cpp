// What can still be done: drafts of a case with one lever moved from some time of the casting on,
// of several data, since an effect differs between them by as much as ten times
// (docs/forecasts.md).
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "core/statistics/sampling.hpp"
#include "proto/case_file/fingerprint.hpp"
#include "proto/case_file/live_levers.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/uncertainty.hpp"
#include "proto/values/interpolation.hpp"
#include "server/intake/case_intake.hpp"
#include "server/judging/judged_study.hpp"
#include "server/studies/data_axes.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::studies {

namespace {

/// When levers are moved, as shares of the casting. An effect falls fast while most of the curl
/// comes, and slowly after (docs/forecasts.md).
constexpr std::array begins{0.1, 0.25};
/// Castings of different data.
constexpr int members = 8;

double last_length_m(const RunCurves& history) {
  return *history.curves.front().cast_length_m().rbegin();
}

/// Curl at a cast length [m]; NaN where it is not known.
double curl_at_length(const v1::CurlCurve* curve, double length_m) {
  if (curve == nullptr) return NAN;
  return values::at_instants({length_m},
                             {curve->cast_length_m().begin(), curve->cast_length_m().end()},
                             {curve->curl_m().begin(), curve->curl_m().end()})
      .front();
}

/// The least shell from a time on, up to a cast length [m]; empty: no step lies there.
std::optional<double> least_shell_m(const RunCurves& history, double from_s, double length_m) {
  constexpr double margin_m = 1e-6;
  const v1::CurlCurve& any = history.curves.front();
  std::optional<double> least;
  for (int step = 0; step < any.time_s_size(); ++step) {
    if (any.time_s(step) <= from_s || any.cast_length_m(step) > length_m + margin_m) continue;
    const double shell_m = history.least_shell_m[static_cast<std::size_t>(step)];
    least = std::min(shell_m, least.value_or(shell_m));
  }
  return least;
}

/// How far a finding is beyond its limit, in the unit of the limit.
double excess_of(const v1::Finding& finding) {
  const double value = finding.has_worst() ? finding.worst().value() : finding.value();
  return std::abs(value - finding.limit());
}

/// Whether a finding of the same code is graver, or farther beyond its limit by more than two
/// drafts of the same case may differ.
bool is_worse(const v1::Finding& finding, const v1::Finding& before) {
  constexpr double least_share = 0.02;
  if (finding.severity() != before.severity()) return finding.severity() > before.severity();
  if (!finding.has_limit() || !before.has_limit()) return false;
  const double size = std::max(std::abs(before.limit()), std::abs(before.value()));
  return excess_of(finding) > excess_of(before) + least_share * size;
}

/// Findings beyond notes that a run has and the plan has not, or less, and why it failed.
std::vector<std::string> made_worse(const v1::StudyRun& run, const v1::StudyRun& plan) {
  std::vector<std::string> worse;
  for (const v1::Finding& finding : run.findings()) {
    if (finding.severity() <= v1::Finding::NOTE) continue;
    const auto before = std::ranges::find(plan.findings(), finding.code(), &v1::Finding::code);
    if (before == plan.findings().end() || is_worse(finding, *before))
      worse.push_back(finding.code());
  }
  if (!judging::is_valid(run) && worse.empty())
    worse.push_back(run.failure().code().empty() ? "the end of the run" : run.failure().code());
  return worse;
}

/// Data of one casting each, drawn from their ranges.
/// @param base  complete, with ranges
std::vector<std::vector<v1::CaseChange>> drawn_data(const v1::Case& base) {
  const auto keys = case_file::uncertain_keys(base);
  if (keys.empty()) return {{}};

  std::vector<std::vector<v1::CaseChange>> data(members);
  const auto places = statistics::hypercube(members, static_cast<int>(keys.size()), 0);
  for (Eigen::Index member = 0; member < members; ++member)
    for (std::size_t i = 0; i < keys.size(); ++i)
      data[static_cast<std::size_t>(member)].push_back(case_file::change_of(
          keys[i].change(),
          value_between(base, keys[i].change(), keys[i].ends.low, keys[i].ends.high,
                        places(member, static_cast<Eigen::Index>(i)))));
  return data;
}

/// One run: a casting of some data, as planned or with a lever moved.
struct LeverRun {
  int member;
  std::optional<case_file::LeverDraft> draft;  ///< empty: as planned
};

/// Of each casting the run as planned, then those with a lever moved.
class Levers final : public StudyPlan {
public:
  explicit Levers(const v1::CreateStudyRequest& request)
      : base_(case_file::without_ranges(request.case_())), data_(drawn_data(request.case_())) {
    for (int member = 0; member < std::ssize(data_); ++member) {
      runs_.push_back({member, std::nullopt});
      const v1::Case casting = casting_of(member);
      for (const double begin : begins) {
        const double from_s = std::round(10.0 * begin * base_.time().end_s()) / 10.0;
        for (case_file::LeverDraft& draft : case_file::lever_drafts_from(casting, from_s))
          runs_.push_back({member, std::move(draft)});
      }
    }
  }

  int runs() const override { return static_cast<int>(runs_.size()); }
  bool needs_histories() const override { return true; }

  PlannedRun run(int number) const override {
    const auto& [member, draft] = run_of(number);
    const auto& data = data_[static_cast<std::size_t>(member)];
    if (!draft) return planned(number, "the plan", base_, data);

    // The tables of a lever hold the data already: a change of both would set a key twice.
    PlannedRun moved = planned(number, draft->step.words(), casting_of(member), draft->changes);
    moved.changes.insert(moved.changes.begin(), data.begin(), data.end());
    return moved;
  }

  void describe(int number, v1::StudyRun& run) const override {
    if (const auto& draft = run_of(number).draft) *run.mutable_lever_step() = draft->step;
  }

  void evaluate(const std::vector<EvaluatedRun>& runs, v1::StudyResult& result) const override {
    const EvaluatedRun* plan = nullptr;
    for (const EvaluatedRun& run : runs) {
      if (!run_of(run.number).draft) {
        plan = run.counts() ? &run : nullptr;
        if (plan) *result.add_lever_effects() = curls_of_plan(*plan);
      } else if (plan && has_ended(run) &&
                 run_of(run.number).member == run_of(plan->number).member) {
        *result.add_lever_effects() = effect_of(run, *plan);
      }
    }
  }

private:
  const LeverRun& run_of(int number) const { return runs_[static_cast<std::size_t>(number)]; }

  /// The case with the data of a member.
  v1::Case casting_of(int member) const {
    v1::Case casting = base_;
    case_file::apply_changes(casting, data_[static_cast<std::size_t>(member)]);
    return casting;
  }

  static bool has_ended(const EvaluatedRun& run) {
    return run.run.state() == v1::SUCCEEDED || run.run.state() == v1::FAILED;
  }

  v1::LeverEffect curls_of_plan(const EvaluatedRun& plan) const {
    v1::LeverEffect curls;
    for (const v1::Monitor& monitor : base_.monitor())
      curls.add_curl_m(
          curl_at_length(plan.history.curve(monitor.name()), last_length_m(plan.history)));
    return curls;
  }

  /// At equal cast length: a slower casting is not flatter because it is shorter.
  v1::LeverEffect effect_of(const EvaluatedRun& moved, const EvaluatedRun& plan) const {
    v1::LeverEffect effect;
    *effect.mutable_step() = run_of(moved.number).draft->step;
    for (std::string& code : made_worse(moved.run, plan.run)) effect.add_worse(std::move(code));
    if (!moved.counts()) {
      for (int monitor = 0; monitor < base_.monitor_size(); ++monitor) effect.add_curl_m(NAN);
      return effect;
    }

    const double length_m = std::min(last_length_m(moved.history), last_length_m(plan.history));
    for (const v1::Monitor& monitor : base_.monitor())
      effect.add_curl_m(curl_at_length(moved.history.curve(monitor.name()), length_m) -
                        curl_at_length(plan.history.curve(monitor.name()), length_m));

    const double from_s = effect.step().from_s();
    const auto before = least_shell_m(plan.history, from_s, length_m);
    const auto after = least_shell_m(moved.history, from_s, length_m);
    if (before && after) effect.set_least_shell_m(*after - *before);
    return effect;
  }

  v1::Case base_;
  std::vector<std::vector<v1::CaseChange>> data_;  ///< (member)
  std::vector<LeverRun> runs_;
};

}  // namespace

std::unique_ptr<StudyPlan> levers_plan(const v1::CreateStudyRequest& request) {
  return std::make_unique<Levers>(request);
}

}  // namespace dccast::studies
