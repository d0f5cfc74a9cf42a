#include "core/casting/simulation.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

#include "core/base/errors.hpp"
#include "core/casting/casting_run.hpp"
#include "core/casting/solver_identity.hpp"
#include "core/casting/stored_run.hpp"
#include "core/results/result_writer.hpp"

namespace dccast::casting {

namespace {

// Bounds of the checks of a run. Energy: the heat step solves to 1e-11. Support: share of the
// weight that the mechanical residual may leave unsupported. Contact: gaps relative to 1 mm, forces
// to the weight.
constexpr double energy_bound = 1e-8;
constexpr double support_bound = 1e-2;
constexpr double contact_bound = 1e-3;

const char* checkpoint_name = "checkpoint.bin";
const char* journal_name = "journal.bin";
const char* results_name = "results.h5";

results::RunHeader header_of(const Case& c) {
  results::RunHeader header;
  header.program_version = DCCAST_VERSION;
  header.build = "g++ " __VERSION__;
  header.title = c.title;
  header.case_json = c.source_json;
  header.section = mesh::name_of(c.section.kind);
  header.dimension = mesh::dimension_of(c.section.kind);
  header.liquidus = c.alloy.liquidus;
  header.solidus = c.alloy.solidus;
  for (const Monitor& monitor : c.monitors) {
    header.monitor_name.push_back(monitor.name);
    header.monitor_position.push_back({monitor.x, monitor.y});
    if (header.dimension == 3) header.monitor_position.back().push_back(monitor.z.value_or(0.0));
  }
  return header;
}

/// The check that a step violates; empty if there is none.
/// @param dimension  of the mesh: the forces of a section are per metre
std::string failed_check(const results::StepReport& r, int dimension) {
  char text[200] = "";
  if (!(std::abs(r.energy_balance_error) <= energy_bound)) {
    std::snprintf(text, sizeof text, "energy balance off by %.2e at t = %g s",
                  r.energy_balance_error, r.time);
  } else if (r.weight > 0.0 &&
             !(std::abs(r.bottom_reaction - r.weight) <= support_bound * r.weight)) {
    const char* unit = dimension == 2 ? "N/m" : "N";
    std::snprintf(text, sizeof text,
                  "bottom reaction %.6g %s against a weight of %.6g %s at t = %g s",
                  r.bottom_reaction, unit, r.weight, unit, r.time);
  } else if (!(r.complementarity_error <= contact_bound)) {
    std::snprintf(text, sizeof text, "contact conditions violated by %.2e at t = %g s",
                  r.complementarity_error, r.time);
  }
  return text;
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
  return summary;
}

RunFailure failure_of(const results::ValidityLoss& loss, double time_step) {
  return {failure_kind(loss.kind).value(), loss.message, loss.time, time_step, loss.place, {}};
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
  Driver(const Case& c, const RunDirectory& directory, StepObserver& observer, int threads)
      : directory_(directory),
        observer_(observer),
        run_(make_run(c, threads)),
        clock_(c.checkpoint),
        when_lost_(c.validity.when_lost),
        header_(header_of(c)),
        files_{directory.path / journal_name, directory.path / results_name} {}

  RunOutcome drive() {
    try {
      if (const auto refused = begin()) return *refused;
      while (!run_->finished() && !over()) {
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
      writer_.emplace(results::ResultWriter::create(files_, header_));
    }
    store_frame();
    tell_findings();
  }

  void store_frame() {
    const results::Frame frame = run_->take_frame();
    if (!writer_) return;
    writer_->append(frame);
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

  /// @return empty if resumed; else the reason: the journal ends before the state, or the state
  ///         does not fit the run
  std::string go_on_from(const StoredRun& stored) {
    auto resumed = results::ResultWriter::resume(files_, stored.step, stored.journal_records);
    if (!resumed.writer) return resumed.reason;
    if (std::string reason = run_->restore(*stored.content); !reason.empty()) return reason;
    writer_.emplace(std::move(*resumed.writer));
    if (directory_.last_reported_step) report_missed_steps(*directory_.last_reported_step);
    observer_.on_resumed(stored.step, run_->time());
    if (run_->validity_lost()) observer_.on_validity_lost(*run_->validity_lost());
    tell_findings();
    return "";
  }

  void report_missed_steps(std::int64_t last_reported) {
    writer_->visit_steps(last_reported, [this](const results::StepReport& report) {
      observer_.on_missed_step(report);
    });
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

  /// Stores and reports a step. @return the outcome if the observer ends the run here
  std::optional<RunOutcome> after(const results::StepReport& report) {
    if (writer_) writer_->append(report);
    if (std::string fault = failed_check(report, header_.dimension); !fault.empty())
      run_->fail(
          {FailureKind::check_failed, std::move(fault), report.time, report.time_step, {}, {}});
    note_lost_validity(report);
    tell_findings();
    if (run_->frame_is_due() || over()) store_frame();
    const Order order = observer_.on_step(report);
    if (order == Order::cancel) return cancelled();
    const bool stop = order == Order::stop_at_checkpoint && !run_->finished() && !over();
    if (writer_ && (stop || clock_.due(report.step))) write_checkpoint();
    if (!stop) return std::nullopt;
    if (writer_) writer_->wait();
    return RunOutcome{RunEnd::stopped, {}};
  }

  /// Reports the loss of validity in the step in which it occurs.
  void note_lost_validity(const results::StepReport& report) {
    const auto& lost = run_->validity_lost();
    if (!lost || lost->time != report.time) return;
    if (when_lost_ == WhenLost::stop) run_->fail(failure_of(*lost, report.time_step));
    observer_.on_validity_lost(*lost);
  }

  /// Reports the findings that the observer has not received yet.
  void tell_findings() {
    const std::vector<results::Finding>& found = run_->findings();
    while (findings_told_ < found.size()) observer_.on_finding(found[findings_told_++]);
  }

  /// Whether a failure of a step has ended the run early.
  bool over() const { return std::ranges::any_of(run_->failures(), ends_run, &RunFailure::kind); }

  void write_checkpoint() {
    restart::Sections content = run_->state_sections();
    sign(content, origin());
    writer_->checkpoint(checkpoint(), std::move(content));
    clock_.written();
  }

  RunOutcome conclude() {
    const RunFailures& failures = run_->failures();
    try {
      if (writer_) writer_->publish(summary_of(*run_));
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

  /// The files are kept: the run continues from them once the disk can be written again.
  RunOutcome with_storage_failure(const std::system_error& error) {
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
  std::unique_ptr<CastingRun> run_;
  CheckpointClock clock_;
  WhenLost when_lost_;
  results::RunHeader header_;
  results::RunFiles files_;
  std::optional<results::ResultWriter> writer_;  ///< none where nothing is kept
  std::size_t findings_told_ = 0;
};

}  // namespace

RunOutcome run(const Case& c, const RunDirectory& directory, StepObserver& observer, int threads) {
  return Driver(c, directory, observer, threads).drive();
}

}  // namespace dccast::casting
