#include "core/casting/simulation.hpp"

#include <chrono>
#include <cmath>
#include <cstdio>

#include "core/casting/slab_run.hpp"
#include "core/results/checkpoint_file.hpp"
#include "core/results/result_writer.hpp"

namespace dccast::casting {

namespace {

// Bounds of a run's own checks. Energy: the heat step solves to 1e-11. Support: what the mechanical
// residual may leave of the weight. Contact: gaps against 1 mm, forces against the weight.
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
  header.section = c.section.kind == mesh::SectionKind::axisymmetric ? "axisymmetric" : "plane_strain";
  header.liquidus = c.alloy.liquidus;
  header.solidus = c.alloy.solidus;
  for (const Monitor& monitor : c.monitors) {
    header.monitor_name.push_back(monitor.name);
    header.monitor_position.push_back({monitor.x, monitor.y});
  }
  return header;
}

/// What is wrong with a step by the run's own checks; empty when nothing is.
std::string failed_check(const results::StepReport& r) {
  char text[200] = "";
  if (!(std::abs(r.energy_balance_error) <= energy_bound)) {
    std::snprintf(text, sizeof text, "energy balance off by %.2e at t = %g s", r.energy_balance_error,
                  r.time);
  } else if (r.weight > 0.0 &&
             !(std::abs(r.bottom_reaction - r.weight) <= support_bound * r.weight)) {
    std::snprintf(text, sizeof text, "bottom reaction %.6g N/m against a weight of %.6g N/m at t = %g s",
                  r.bottom_reaction, r.weight, r.time);
  } else if (!(r.complementarity_error <= contact_bound)) {
    std::snprintf(text, sizeof text, "contact conditions violated by %.2e at t = %g s",
                  r.complementarity_error, r.time);
  }
  return text;
}

/// Decides when a checkpoint is due: by steps, or by the wall clock.
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
template <class Element>
class Driver {
public:
  Driver(const Case& c, const RunDirectory& directory, StepObserver& observer)
      : directory_(directory.path), observer_(observer), run_(c), clock_(c.checkpoint),
        header_(header_of(c)), files_{directory_ / journal_name, directory_ / results_name} {
    if (directory.resume) resume();
    if (!writer_) {
      writer_.emplace(results::ResultWriter::create(files_, header_));
      writer_->append(run_.take_frame());
      writer_->flush();
    }
  }

  RunOutcome drive() {
    try {
      while (!run_.finished()) {
        const results::StepReport report = run_.advance();
        if (const auto end = after(report)) return *end;
      }
    } catch (const SolveFailed& failure) {
      writer_->publish({"solve_failed", failure.what()});
      return {RunEnd::solve_failed, RunFailure{failure.what(), failure.time(), failure.time_step(),
                                               failure.residual_history()}};
    }
    return finish();
  }

private:
  void resume() {
    const auto read = results::read_checkpoint(directory_ / checkpoint_name);
    RunState state;
    if (!read.content || !from_sections(*read.content, header_.case_json, state)) {
      observer_.on_message("no checkpoint to go on from (" + read.reason + "): the run begins anew");
      return;
    }
    auto resumed = results::ResultWriter::resume(files_, state.step);
    if (!resumed.writer) {
      observer_.on_message("the journal does not reach the checkpoint (" + resumed.reason +
                           "): the run begins anew");
      return;
    }
    writer_.emplace(std::move(*resumed.writer));
    run_.restore(state);
    observer_.on_resumed(state.step, state.time);
  }

  /// Stores and reports a step. @return the outcome when the run ends here
  std::optional<RunOutcome> after(const results::StepReport& report) {
    writer_->append(report);
    if (run_.frame_is_due()) {
      writer_->append(run_.take_frame());
      writer_->flush();
    }
    if (failure_.empty()) {
      failure_ = failed_check(report);
      failure_time_ = report.time;
      failure_step_ = report.time_step;
    }
    const Order order = observer_.on_step(report);
    if (order == Order::cancel) return RunOutcome{RunEnd::cancelled, std::nullopt};
    if (order == Order::stop_at_checkpoint || clock_.due(report.step)) write_checkpoint();
    if (order == Order::stop_at_checkpoint && !run_.finished()) {
      writer_->wait();
      return RunOutcome{RunEnd::stopped, std::nullopt};
    }
    return std::nullopt;
  }

  void write_checkpoint() {
    writer_->checkpoint(directory_ / checkpoint_name,
                        to_sections(run_.state(), header_.case_json));
    clock_.written();
  }

  RunOutcome finish() {
    const bool good = failure_.empty();
    writer_->publish({good ? "succeeded" : "check_failed", failure_});
    writer_->remove_journal();
    std::error_code ignored;  // a checkpoint that stays does no harm
    std::filesystem::remove(directory_ / checkpoint_name, ignored);
    if (good) return {RunEnd::succeeded, std::nullopt};
    return {RunEnd::check_failed, RunFailure{failure_, failure_time_, failure_step_, {}}};
  }

  std::filesystem::path directory_;
  StepObserver& observer_;
  SlabRun<Element> run_;
  CheckpointClock clock_;
  results::RunHeader header_;
  results::RunFiles files_;
  std::optional<results::ResultWriter> writer_;
  std::string failure_;
  double failure_time_ = 0.0;
  double failure_step_ = 0.0;
};

}  // namespace

RunOutcome run(const Case& c, const RunDirectory& directory, StepObserver& observer) {
  const auto with = [&]<class Element>() {
    return Driver<Element>(c, directory, observer).drive();
  };
  const bool q1 = c.section.element == mesh::ElementKind::q1;
  if (c.section.kind == mesh::SectionKind::axisymmetric) {
    return q1 ? with.template operator()<fem::Q1Ring>() : with.template operator()<fem::P1Ring>();
  }
  return q1 ? with.template operator()<fem::Q1Quadrilateral>()
            : with.template operator()<fem::P1Triangle>();
}

}  // namespace dccast::casting
