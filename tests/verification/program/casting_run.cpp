#include "tests/verification/program/casting_run.hpp"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include "tests/support/load_case.hpp"
#include "tests/verification/mechanics/figures.hpp"

namespace dccast::verification {

namespace {

namespace fs = std::filesystem;

/// A directory of its own, removed with its contents.
class ScratchDirectory {
public:
  ScratchDirectory() {
    std::string pattern = (fs::temp_directory_path() / "dccast-verify-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) {
      throw std::runtime_error("no scratch directory can be made in " +
                               fs::temp_directory_path().string());
    }
    path_ = pattern;
  }
  ~ScratchDirectory() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  ScratchDirectory(const ScratchDirectory&) = delete;
  const fs::path& path() const { return path_; }

private:
  fs::path path_;
};

/// Counts what a run does, and ends it when it has used its processor time.
class CountingObserver : public casting::StepObserver {
public:
  CountingObserver(double limit, CastingRun& run)
      : limit_(limit), start_(cpu_seconds()), run_(&run) {}

  casting::Order on_step(const results::StepReport& report) override {
    if (report.iterations > 0) ++run_->mechanical_steps;
    run_->iterations += report.iterations;
    run_->failed_attempts += report.failed_attempts;
    run_->last = report;
    if (!report.monitor_displacement.empty()) {
      run_->time_s.push_back(report.time);
      run_->curl_m.push_back(report.monitor_displacement.front().back());
    }
    return seconds() > limit_ ? casting::Order::cancel : casting::Order::go_on;
  }
  void on_resumed(std::int64_t, double) override {}
  void on_message(std::string_view) override {}
  double seconds() const { return cpu_seconds() - start_; }

private:
  double limit_, start_;
  CastingRun* run_;
};

}  // namespace

casting::Case shipped_casting(mesh::ElementKind element) {
  casting::Case casting_case = support::load_case(casting_name);
  support::take_paper_size(casting_case);
  casting_case.section.element = element;
  return casting_case;
}

double CastingRun::iterations_per_step() const {
  return mechanical_steps > 0 ? double(iterations) / double(mechanical_steps) : 0.0;
}

std::optional<double> CastingRun::curl_mm() const {
  if (curl_m.empty()) return std::nullopt;
  return 1e3 * curl_m.back();
}

std::string CastingRun::ending() const {
  char text[160];
  if (outcome.end == casting::RunEnd::succeeded) return "reached its end";
  if (outcome.end == casting::RunEnd::cancelled) {
    std::snprintf(text, sizeof text, "given up at t = %.4g s after %.4g s", last.time, seconds);
    return text;
  }
  if (outcome.failures.size() == 1 &&
      outcome.failures.front().kind == casting::FailureKind::check_failed)
    return "reached its end; a check failed";
  std::snprintf(text, sizeof text, "failed at t = %.5g s", last.time);
  return text;
}

CastingRun run_casting(const casting::Case& casting_case, double limit) {
  const ScratchDirectory scratch;
  CastingRun run;
  CountingObserver observer(limit, run);
  run.outcome = casting::run(casting_case, {scratch.path(), false}, observer);
  run.seconds = observer.seconds();
  return run;
}

}  // namespace dccast::verification
