#include "core/casting/simulation.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "core/base/errors.hpp"
#include "core/casting/case/casting_schedule.hpp"
#include "core/casting/casting_run.hpp"
#include "core/casting/slab_run.hpp"
#include "core/casting/stored_run.hpp"
#include "core/results/result_writer.hpp"
#include "core/storage/storage_error.hpp"

namespace dccast::casting {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

const char* checkpoint_name = "checkpoint.bin";
const char* results_name = "results.h5";

results::RunHeader header_of(const Case& c) {
  results::RunHeader header;
  header.program_version = DCCAST_VERSION;
  header.build = "g++ " __VERSION__;
  header.commit = c.commit;

  header.title = c.title;
  header.case_sha256 = c.case_sha256;
  header.case_json = c.source_json;
  header.relative_curl_error = c.relative_curl_error;

  header.section = mesh::name_of(c.section.kind);
  header.dimension = mesh::dimension_of(c.section.kind);
  header.liquidus = c.alloy.liquidus;
  header.solidus = c.alloy.solidus;
  header.shell = c.alloy.shell_temperature();

  for (const Monitor& monitor : c.monitors) {
    header.monitor_name.push_back(monitor.name);
    std::vector<double> place{monitor.x, monitor.y};
    if (header.dimension == 3) place.push_back(monitor.z.value_or(0.0));
    if (!monitor.of.empty()) std::ranges::fill(place, std::nan(""));
    header.monitor_position.push_back(std::move(place));
  }
  return header;
}

RunFailure failure_of(const SolveFailed& error) {
  return {FailureKind::solve_failed, error.what(), error.time(),
          error.time_step(),         {},           error.residual_history()};
}

results::RunSummary summary_of(const CastingRun& run) {
  results::RunSummary summary;
  if (!run.failures().empty())
    summary = {name_of(run.failures().front().kind), in_words(run.failures())};
  summary.validity_lost = run.validity_lost();
  summary.findings = run.findings();
  summary.margins = run.margins();
  return summary;
}

/// Decides when a checkpoint is due: by number of steps or by wall time.
class CheckpointClock {
public:
  explicit CheckpointClock(const CheckpointPolicy& policy) : policy_(policy) {}
  bool due(std::int64_t step) const {
    const std::chrono::duration<double> since = std::chrono::steady_clock::now() - last_;
    return (policy_.every_steps > 0 && step % policy_.every_steps == 0) ||
           (policy_.every_seconds > 0.0 && since.count() >= policy_.every_seconds);
  }
  void written() { last_ = std::chrono::steady_clock::now(); }

private:
  CheckpointPolicy policy_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// A run with its files and its observer.
class Driver {
public:
  Driver(const Case& c, const RunDirectory& directory, StepObserver& observer, int threads,
         LeverFeed* feed)
      : directory_(directory),
        observer_(observer),
        feed_(feed),
        run_(make_run(c, threads)),
        clock_(c.checkpoint),
        header_(header_of(c)),
        files_{directory.path / journal_name, directory.path / results_name} {}

  RunOutcome drive() {
    try {
      if (const auto refused = begin()) return *refused;
      while (!run_->finished() && !over()) {
        if (const auto end = await_levers()) return *end;
        if (record_ended_) break;
        if (const auto end = after(run_->advance())) return *end;
      }
    } catch (const SolveFailed& error) {
      run_->fail(failure_of(error));
    } catch (const std::system_error& error) {
      return with_storage_failure(error);
    }
    return conclude();
  }

private:
  /// @return the outcome if the run must not begin
  std::optional<RunOutcome> begin() {
    if (directory_.resume) {
      if (auto refused = resume()) return refused;
    }
    if (!writer_) begin_anew();
    return std::nullopt;
  }

  void begin_anew() {
    if (!directory_.keeps_nothing) {
      std::filesystem::remove(checkpoint());  // it would not belong to the same run as the journal
      writer_ = std::make_unique<results::ResultWriter>(files_, header_);
    }
    store_frame();
    report_new_findings();
  }

  void store_frame() {
    if (!writer_) return;
    writer_->append(run_->take_frame());
    writer_->flush();
  }

  std::optional<RunOutcome> resume() {
    const StoredRun stored = read_stored_run(checkpoint(), origin());
    if (stored.other_version && directory_.other_version != OtherVersion::begin_anew)
      return refused(stored.reason);
    const std::string reason = stored.content ? go_on_from(stored) : stored.reason;
    if (!reason.empty())
      observer_.on_message("no checkpoint to continue from (" + reason +
                           "): the run starts from the beginning");
    return std::nullopt;
  }

  /// @return empty if resumed; else the reason: a step or a frame before the state is lost, or the
  ///         state does not fit the run
  std::string go_on_from(const StoredRun& stored) {
    auto history = observer_.reported_steps(stored.step);
    if (history.size() != static_cast<std::size_t>(stored.step) ||
        (stored.step > 0 && history.back().step != stored.step))
      return "a step before it is lost";
    auto resumed =
        results::ResultWriter::resume(files_, std::move(history), stored.journal_records);
    if (!resumed.writer) return resumed.reason;
    if (std::string reason = run_->restore(*stored.content); !reason.empty()) return reason;
    writer_ = std::move(resumed.writer);
    observer_.on_resumed(stored.step, run_->time());
    if (run_->validity_lost()) observer_.on_validity_lost(*run_->validity_lost());
    report_new_findings();
    return "";
  }

  /// The checkpoint is kept if the run is to wait.
  RunOutcome refused(const std::string& reason) {
    const bool fails = directory_.other_version == OtherVersion::fail;
    if (fails) remove_files();
    RunFailure failure;
    failure.kind = FailureKind::other_version;
    failure.message = "no checkpoint to continue from (" + reason + ")";
    return {fails ? RunEnd::failed : RunEnd::other_version, {failure}};
  }

  /// Takes the levers of a casting under way up to the end of the next step.
  /// @return the outcome if the run ends before that step
  std::optional<RunOutcome> await_levers() {
    while (feed_ && levers_until() < run_->next_time()) {
      const LeverFeed::Arrived arrived = feed_->wait_until(run_->next_time());
      for (const LeverReading& reading : arrived.readings) {
        run_->append(reading);
        keep(reading);
      }
      if (arrived.order == Order::cancel) return cancelled();
      if (arrived.order == Order::stop_at_checkpoint) return stopped();

      record_ended_ = arrived.closed && levers_until() < run_->next_time();
      if (!record_ended_) continue;
      if (writer_ && writer_->last_frame_time() < run_->time()) store_frame();
      break;
    }
    return std::nullopt;
  }

  /// Time up to which the levers are known [s].
  double levers_until() const { return levers_.time.empty() ? -infinity : levers_.time.back(); }

  /// The readings that the run has used, up to the first one at or after its end: later ones may
  /// have arrived or not.
  results::MeasuredLevers used_levers() const {
    results::MeasuredLevers used = levers_;
    const auto end = std::ranges::lower_bound(used.time, run_->time());
    const auto count =
        std::min(used.time.size(), static_cast<std::size_t>(end - used.time.begin()) + 1);
    used.time.resize(count);
    for (std::vector<double>& values : used.values) values.resize(count);
    return used;
  }

  /// Keeps a reading for the results.
  void keep(const LeverReading& reading) {
    constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();
    levers_.time.push_back(reading.time);
    for (std::size_t lever = 0; lever < lever_count; ++lever)
      levers_.values[lever].push_back(reading.value[lever].value_or(not_measured));
  }

  /// Stores and reports a step. @return the outcome if the observer ends the run here
  std::optional<RunOutcome> after(const results::StepReport& report) {
    if (writer_) writer_->append(report);
    const auto& lost = run_->validity_lost();
    if (lost && lost->time == report.time) observer_.on_validity_lost(*lost);
    report_new_findings();
    if (run_->frame_is_due() || over()) store_frame();
    const Order order = observer_.on_step(report);
    if (order == Order::cancel) return cancelled();
    if (order == Order::stop_at_checkpoint && !run_->finished() && !over()) return stopped();
    if (writer_ && clock_.due(report.step)) write_checkpoint();
    return std::nullopt;
  }

  /// Ends the run where it can be resumed.
  RunOutcome stopped() {
    if (writer_) {
      write_checkpoint();
      writer_->wait();
    }
    return {RunEnd::stopped, {}};
  }

  /// Reports the findings that the observer has not received yet, or not as sure as they are.
  void report_new_findings() {
    const std::vector<results::Finding>& found = run_->findings();
    for (std::size_t i = 0; i < reported_.size(); ++i) {
      if (found[i].certainty == reported_[i].certainty) continue;
      reported_[i] = found[i];
      observer_.on_finding(found[i]);
    }

    while (reported_.size() < found.size()) {
      reported_.push_back(found[reported_.size()]);
      observer_.on_finding(reported_.back());
    }
  }

  /// Reports again those whose worst exceedance has grown since.
  void report_worst_exceedances() {
    const std::vector<results::Finding>& found = run_->findings();
    for (std::size_t i = 0; i < reported_.size(); ++i) {
      if (found[i] == reported_[i]) continue;
      reported_[i] = found[i];
      observer_.on_finding(found[i]);
    }
  }

  /// Whether a failure of a step has ended the run early.
  bool over() const { return std::ranges::any_of(run_->failures(), ends_run, &RunFailure::kind); }

  void write_checkpoint() {
    results::Sections content = run_->state_sections();
    sign(content, origin());
    writer_->checkpoint(checkpoint(), std::move(content), [this] { observer_.sync_reports(); });
    clock_.written();
  }

  RunOutcome conclude() {
    const RunFailures& failures = run_->failures();
    report_worst_exceedances();
    try {
      if (writer_) writer_->publish(summary_of(*run_), used_levers());
    } catch (const std::system_error& error) {
      return with_storage_failure(error);
    }
    remove_files();
    return {failures.empty() ? RunEnd::succeeded : RunEnd::failed, failures};
  }

  RunOutcome cancelled() {
    writer_.reset();  // its thread may be writing a checkpoint
    remove_files();
    return {RunEnd::cancelled, {}};
  }

  /// Keeps the files: the run continues from them once the disk can be written again. Called where
  /// the error is caught. An error of memory has nothing to do with the disk and is passed on.
  RunOutcome with_storage_failure(const std::system_error& error) {
    if (storage::is_memory_fault(error.code())) throw;
    run_->fail({FailureKind::storage, error.what(), run_->time(), 0.0, {}, {}});
    return {RunEnd::failed, run_->failures()};
  }

  /// Removes the files that only a resumption needs.
  void remove_files() {
    if (directory_.keeps_nothing || directory_.leaves_run_files) return;
    std::error_code ignored;  // a remaining file does no harm
    std::filesystem::remove(checkpoint(), ignored);
    std::filesystem::remove(files_.journal, ignored);
  }

  CheckpointOrigin origin() const { return {solver_identity(), header_.case_json}; }
  std::filesystem::path checkpoint() const { return directory_.path / checkpoint_name; }

  RunDirectory directory_;
  StepObserver& observer_;
  LeverFeed* feed_;  ///< none where the case alone is computed
  std::unique_ptr<CastingRun> run_;
  CheckpointClock clock_;
  results::RunHeader header_;
  results::RunFiles files_;
  std::unique_ptr<results::ResultWriter> writer_;  ///< none where nothing is kept
  std::vector<results::Finding> reported_;         ///< findings as the observer has them

  results::MeasuredLevers levers_;  ///< readings of the levers so far
  bool record_ended_ = false;       ///< the levers of the next step will never be known
};

}  // namespace

RunOutcome run(const Case& c, const RunDirectory& directory, StepObserver& observer, int threads,
               LeverFeed* feed) {
  return Driver(c, directory, observer, threads, feed).drive();
}

}  // namespace dccast::casting
