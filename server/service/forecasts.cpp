#include "server/service/forecasts.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "server/jobs/folder/events.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/logs/readings_log.hpp"
#include "server/levers/lever_watch.hpp"
#include "server/service/refusals.hpp"
#include "server/service/run_history.hpp"
#include "server/studies/curl_forecast.hpp"
#include "server/studies/curl_prior.hpp"
#include "server/studies/past_forecasts.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::service {

namespace {

/// Results of studies with their curves, each evaluated once.
class EvaluatedStudies {
public:
  explicit EvaluatedStudies(Context& context) : context_(context) {}

  /// Null: there is no such study any more. Of an empty id: a result without runs.
  std::shared_ptr<const v1::StudyResult> find(const std::string& id) {
    const auto known = results_.find(id);
    if (known != results_.end()) return known->second;

    std::shared_ptr<const v1::StudyResult>& result = results_[id];
    if (id.empty()) return result = std::make_shared<v1::StudyResult>();
    v1::EvaluateStudyRequest request;
    request.set_id(id);
    request.set_curves(true);
    if (auto found = context_.studies.evaluation().evaluate(request))
      result = std::make_shared<v1::StudyResult>(std::move(*found));
    return result;
  }

  /// @throws Refusal  there is no such study any more
  std::shared_ptr<const v1::StudyResult> get(const std::string& id) {
    auto found = find(id);
    if (!found) throw Refusal{unknown_study(id)};
    return found;
  }

private:
  Context& context_;
  std::map<std::string, std::shared_ptr<const v1::StudyResult>> results_;
};

/// Curls of a run so far.
std::vector<v1::CurlCurve> curls_of(Context& context, const v1::Job& job) {
  return studies::run_curves(job, read_steps(context, job.id())).curves;
}

/// Curls of the run of the plan. @throws Refusal  it has not succeeded
std::vector<v1::CurlCurve> curls_of_plan(Context& context, const std::string& id) {
  const Remedy remedy{"`dccast follow --prepare CASE` before a casting computes more"};
  const v1::Job job = find_job(context, id);
  if (!jobs::is_terminal(job.state()))
    refuse(ErrorInfo::WRONG_STATE, Remedy{"ask again when it has ended"},
           "the run of the plan, job {}, has not ended yet", id);
  if (job.state() != v1::SUCCEEDED)
    refuse(ErrorInfo::WRONG_STATE, remedy, "the run of the plan, job {}, has not succeeded", id);
  return curls_of(context, job);
}

/// Whether the run of a plan has succeeded at a quality.
bool has_run_at(Context& context, const std::string& id, v1::Quality quality) {
  const auto job = id.empty() ? std::nullopt : context.scheduler.find(id);
  v1::Case computed;
  return job && job->state() == v1::SUCCEEDED &&
         jobs::read_complete_case(context.jobs_directory / id, computed) &&
         computed.quality() == quality;
}

/// The castings of a line that come before a job and have ended, the oldest first. A job that is
/// not on the line any more has none.
std::vector<studies::EarlierCasting> castings_before(const std::string& job, const v1::Line& line,
                                                     EvaluatedStudies& studies) {
  const auto own = std::ranges::find(line.castings(), job, &v1::LineCasting::job);
  if (own == line.castings().end()) return {};

  std::vector<studies::EarlierCasting> earlier;
  for (auto casting = line.castings().begin(); casting != own; ++casting)
    // A typed casting has no curl against time.
    if (casting->ended() && casting->has_following())
      earlier.push_back({*casting, studies.find(casting->following().ensemble()),
                         studies.find(casting->following().pairs())});
  return earlier;
}

/// What a job has recorded, and what its forecast rests on.
class RecordedCasting {
public:
  /// @param line  with what earlier castings have told; null: none
  RecordedCasting(Context& context, const std::string& id, const v1::Line* line,
                  EvaluatedStudies& studies) {
    const auto folder = context.jobs_directory / id;
    jobs::ReadingsReader record(folder);
    following_ = record.following();
    readings_ = record.read_new();
    check_rests_on_something(id);

    if (!jobs::read_complete_case(folder, plan_))
      refuse(ErrorInfo::DAMAGED, "the case of job {} cannot be read any more", id);
    error_of_plan_ = studies::error_of_plan(plan_.section());

    ensemble_ = studies.get(following_.ensemble());
    pairs_ = studies.get(following_.pairs());
    const bool shows_levers = has_run_at(context, following_.plan_job(), plan_.quality());
    if (shows_levers || following_.ensemble().empty())
      plan_run_ = curls_of_plan(context, following_.plan_job());
    if (shows_levers) followed_run_ = curls_of(context, find_job(context, id));
    levers_ = studies.find(following_.levers());
    if (line) earlier_ = castings_before(id, *line, studies);
  }

  studies::ForecastBasis basis() const {
    return {.ensemble = *ensemble_,
            .pairs = *pairs_,
            .plan = plan_,
            .following = following_,
            .readings = readings_,
            .plan_run = plan_run_,
            .followed_run = followed_run_,
            .error_of_plan = error_of_plan_,
            .earlier = earlier_,
            .levers = levers_};
  }

private:
  void check_rests_on_something(const std::string& id) const {
    if (following_.gauges().empty())
      refuse(ErrorInfo::WRONG_STATE,
             Remedy{"give the readings a column \"curl MONITOR\" and follow again"},
             "job {} measures no curl, so there is nothing to forecast from", id);
    if (following_.ensemble().empty() && following_.plan_job().empty())
      refuse(
          ErrorInfo::WRONG_STATE,
          Remedy{"`dccast follow --prepare CASE` before a casting computes an ensemble, or give a "
                 "study by `dccast follow --ensemble STUDY`"},
          "job {} has neither an ensemble nor a run of its plan, on which a forecast rests", id);
  }

  v1::Following following_;
  std::vector<v1::Reading> readings_;
  v1::Case plan_;  ///< complete
  std::shared_ptr<const v1::StudyResult> ensemble_, pairs_;
  std::shared_ptr<const v1::StudyResult> levers_;  ///< null: the study is not there any more
  std::vector<v1::CurlCurve> plan_run_, followed_run_;
  double error_of_plan_ = 0.0;
  std::vector<studies::EarlierCasting> earlier_;
};

/// Curls observed in an ended casting, for its line; none where no forecast can be made of it.
std::vector<v1::ObservedCurl> curls_observed_in(Context& context, const v1::LineCasting& casting,
                                                const v1::Line& line, EvaluatedStudies& studies) {
  if (casting.following().ensemble().empty()) return {};
  try {
    const RecordedCasting recorded(context, casting.job(), &line, studies);
    return studies::observed_curls(recorded.basis());
  } catch (const studies::CannotForecast& reason) {
    log::info("line {}: job {} is left out of its forecasts: {}", line.name(), casting.job(),
              reason.what());
  } catch (const Refusal& refusal) {
    log::info("line {}: job {} is left out of its forecasts: {}", line.name(), casting.job(),
              refusal.status.error_message());
  }
  return {};
}

/// The line with the curls observed in all ended castings; empty if there is no such line.
std::optional<v1::Line> learn_of_ended(Context& context, const std::string& name,
                                       EvaluatedStudies& studies) {
  auto line = context.lines.find(name);
  if (!line) return line;

  // The oldest first: its curls sift the readings of the next.
  for (v1::LineCasting& casting : *line->mutable_castings()) {
    if (casting.ended()) continue;
    const auto job = context.scheduler.find(casting.job());
    if (job && !jobs::is_terminal(job->state())) continue;

    const auto curls = job ? curls_observed_in(context, casting, *line, studies)
                           : std::vector<v1::ObservedCurl>();  // deleted before it told anything
    context.lines.end_casting(name, casting.job(), curls);
    casting.set_ended(true);
    *casting.mutable_curls() = {curls.begin(), curls.end()};
  }
  return line;
}

/// Seconds since a moment; empty: the clock was set back, so that they are not known.
std::optional<double> seconds_since(const google::protobuf::Timestamp& moment) {
  const auto age_ms = jobs::milliseconds(jobs::now()) - jobs::milliseconds(moment);
  return age_ms < 0 ? std::nullopt : std::optional(1e-3 * static_cast<double>(age_ms));
}

/// The case of a job. @throws std::runtime_error  it cannot be read
v1::Case require_case(const std::filesystem::path& folder) {
  v1::Case plan;
  if (!jobs::read_complete_case(folder, plan))
    throw std::runtime_error("the case cannot be read any more");
  return plan;
}

/// @param ask  of a studies::ForecastBasis, of the casting that a job follows
/// @throws Refusal
auto ask_record(Context& context, const std::string& id, const auto& ask) {
  EvaluatedStudies studies(context);
  const std::string name = jobs::ReadingsReader(context.jobs_directory / id).following().line();
  const auto line = name.empty() ? std::nullopt : learn_of_ended(context, name, studies);
  try {
    const RecordedCasting recorded(context, id, line ? &*line : nullptr, studies);
    return ask(recorded.basis());
  } catch (const studies::CannotForecast& reason) {
    refuse(ErrorInfo::WRONG_STATE, Remedy{"ask again when more have ended"}, "{}", reason.what());
  }
}

}  // namespace

FollowedRecord::FollowedRecord(const std::filesystem::path& folder)
    : record_(folder), casting_(require_case(folder)) {}

v1::CastingNow FollowedRecord::now() {
  const std::lock_guard lock(mutex_);
  for (const v1::Reading& reading : record_.read_new()) casting_.follow(reading);

  v1::CastingNow casting = casting_.now();
  *casting.mutable_following() = record_.following();
  const auto age_s = record_.last_arrival() ? seconds_since(*record_.last_arrival()) : std::nullopt;
  if (casting.has_measured() && age_s) casting.set_age_s(*age_s);
  return casting;
}

std::shared_ptr<FollowedRecord> FollowedRecords::open(
    const std::filesystem::path& folder, const std::function<bool(const std::string&)>& runs) {
  const std::lock_guard lock(mutex_);
  const std::string job = folder.filename();
  if (const auto found = records_.find(job); found != records_.end()) return found->second;

  std::erase_if(records_, [&](const auto& entry) { return !runs(entry.first); });
  return records_.emplace(job, std::make_shared<FollowedRecord>(folder)).first->second;
}

void FollowedRecords::forget(const std::string& job) {
  const std::lock_guard lock(mutex_);
  records_.erase(job);
}

void add_casting(Context& context, v1::Job& job) {
  const auto folder = context.jobs_directory / job.id();
  if (job.state() != v1::RUNNING || !jobs::follows_readings(folder)) return;
  const auto runs = [&](const std::string& id) {
    const auto other = context.scheduler.find(id);
    return other && other->state() == v1::RUNNING;
  };
  try {
    *job.mutable_casting() = context.followed_records.open(folder, runs)->now();
  } catch (const std::exception& error) {
    log::warn("job {}: {}", job.id(), error.what());
    context.followed_records.forget(job.id());
  }
}

FollowedCastings followed_castings(Context& context) {
  const jobs::JobStore::Page running{.states = {v1::RUNNING}, .size = 1000};
  std::set<std::string> followed;
  FollowedCastings now;
  for (v1::Job& job : context.scheduler.list(running)) {
    add_casting(context, job);
    if (!job.has_casting() || job.casting().closed()) continue;
    followed.insert(job.id());
    now.oldest_reading_s = std::max(now.oldest_reading_s, job.casting().age_s());
    now.levers_off_plan += job.casting().alarms_size();
  }

  now.castings = static_cast<int>(followed.size());
  now.warnings = context.latest_warnings.sum_of(followed);
  return now;
}

void require_following(const Context& context, const std::string& id) {
  if (!jobs::follows_readings(context.jobs_directory / id))
    refuse(ErrorInfo::WRONG_STATE, Remedy{"`dccast follow` submits one that does"},
           "job {} follows no readings", id);
}

v1::Forecast forecast_job(Context& context, const std::string& id) {
  find_job(context, id);
  require_following(context, id);
  v1::Forecast forecast = ask_record(context, id, studies::forecast_curls);
  context.latest_warnings.set(id, forecast.warnings_size());
  return forecast;
}

std::optional<judging::FollowedCasting> followed_casting(Context& context, const std::string& id) {
  const auto folder = context.jobs_directory / id;
  if (!jobs::follows_readings(folder)) return std::nullopt;

  judging::FollowedCasting followed;
  v1::Case plan;
  if (jobs::read_complete_case(folder, plan))
    followed.poured = levers::poured_levers(plan, jobs::ReadingsReader(folder).read_new());
  const v1::Job job = find_job(context, id);
  followed.has_findings = std::ranges::any_of(job.findings(), [](const v1::Finding& finding) {
    return finding.severity() > v1::Finding::NOTE;
  });
  try {
    ask_record(context, id, [&](const studies::ForecastBasis& basis) {
      followed.forecast = studies::forecast_curls(basis);
      followed.past = studies::past_forecasts(basis);
      return true;
    });
  } catch (const Refusal& refusal) {
    followed.no_forecast = refusal.status.error_message();
  }
  return followed;
}

void learn_before_removal(Context& context, const v1::Job& job) noexcept {
  try {
    const auto folder = context.jobs_directory / job.id();
    if (!jobs::follows_readings(folder)) return;
    const std::string line = jobs::ReadingsReader(folder).following().line();
    EvaluatedStudies studies(context);
    if (!line.empty()) learn_of_ended(context, line, studies);
  } catch (const std::exception& error) {
    log::warn("job {} is deleted before its line has learned from it: {}", job.id(), error.what());
  }
}

v1::Line learned_line(Context& context, const std::string& name) {
  EvaluatedStudies studies(context);
  auto line = learn_of_ended(context, name, studies);
  if (!line) throw Refusal{unknown_line(name)};
  return std::move(*line);
}

}  // namespace dccast::service
