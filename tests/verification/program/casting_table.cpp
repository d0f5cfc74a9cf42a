#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "core/casting/simulation.hpp"
#include "tests/support/load_case.hpp"
#include "tests/verification/mechanics/figures.hpp"
#include "tests/verification/program/paper_tables.hpp"
#include "tests/verification/program/run_request.hpp"

namespace dccast::verification {

namespace {

using mechanics::Algorithm;
namespace fs = std::filesystem;

constexpr const char* casting_name = "start-2d-thickness";

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

/// Counts what a run did, and ends it when it has used its processor time.
class CountingObserver : public casting::StepObserver {
public:
  explicit CountingObserver(double limit) : limit_(limit), start_(cpu_seconds()) {}

  casting::Order on_step(const results::StepReport& report) override {
    if (report.iterations > 0) ++mechanical_steps;
    iterations += report.iterations;
    failed += report.failed_attempts;
    last = report;
    return seconds() > limit_ ? casting::Order::cancel : casting::Order::go_on;
  }
  void on_resumed(std::int64_t, double) override {}
  void on_message(std::string_view) override {}
  double seconds() const { return cpu_seconds() - start_; }

  long iterations = 0, mechanical_steps = 0, failed = 0;
  results::StepReport last;

private:
  double limit_, start_;
};

struct CastingRow {
  Algorithm algorithm;
  Cell paper_seconds, paper_iterations;
};

/// Parameters of section 5.2.
void set_algorithm(casting::Case& casting_case, Algorithm algorithm) {
  auto& options = casting_case.mechanics.options;
  options.algorithm = algorithm;
  if (algorithm != Algorithm::sbm) return;
  options.parameters.gamma_c = 0.5e6;
  options.parameters.lambda_c = 1e-6;
  options.parameters.gamma_p = 1.25e-12;
  options.parameters.lambda_p = 0.4e12;
}

std::string ending(const casting::RunOutcome& outcome, const CountingObserver& seen, double limit) {
  char text[160];
  switch (outcome.end) {
    case casting::RunEnd::succeeded:
      return "reached its end";
    case casting::RunEnd::check_failed:
      return "reached its end; a check failed";
    case casting::RunEnd::cancelled:
      std::snprintf(text, sizeof text, "given up at t = %.4g s after %.4g s", seen.last.time,
                    limit);
      return text;
    default:
      break;
  }
  std::snprintf(text, sizeof text, "failed at t = %.5g s", seen.last.time);
  return text;
}

/// @return seconds used, whether or not the run reached its end
double add_casting(Table& table, const CastingRow& row, double limit) {
  casting::Case casting_case = support::load_case(casting_name);
  set_algorithm(casting_case, row.algorithm);
  const ScratchDirectory scratch;
  CountingObserver seen(limit);
  const auto outcome = casting::run(casting_case, {scratch.path(), false}, seen);
  const double used = seen.seconds();
  Cell curl = nullptr;
  if (!seen.last.monitor_displacement.empty()) {
    curl = 1e3 * seen.last.monitor_displacement.front()[1];
  }
  const double mean =
      seen.mechanical_steps > 0 ? double(seen.iterations) / double(seen.mechanical_steps) : 0.0;
  table.rows.push_back({name_of(row.algorithm), row.paper_seconds, row.paper_iterations, used,
                        seen.last.time, long(seen.last.step), mean, long(seen.failed), curl,
                        ending(outcome, seen, limit)});
  if (outcome.failure) {
    table.remarks.push_back(name_of(row.algorithm) + ": " + outcome.failure->message);
  }
  return used;
}

}  // namespace

bool has_casting_table() {
  return true;
}

Table casting_table(const TableOptions& options) {
  Table table;
  table.title = "Table 11: start of a casting, all four algorithms";
  const casting::Case shown = support::load_case(casting_name);
  table.setup =
      std::string("Case `") + casting_name +
      "`: thickness section, 1320 P1 triangles at the start, 0 to " +
      std::to_string(long(std::lround(shown.time.end))) +
      " s with the steps of the case. Heat, files and checks are in the seconds. The paper's "
      "slab and thermal data are not published: its curl is not ours to match.";
  table.columns = {"method",      "cpu paper [s]", "iterations paper",    "cpu [s]",
                   "reached [s]", "steps",         "iterations per step", "failed attempts",
                   "curl [mm]",   "how it ended"};
  const CastingRow rows[] = {{Algorithm::newton, nullptr, nullptr},
                             {Algorithm::vnbm, 465.562, 89},
                             {Algorithm::nbm, nullptr, nullptr},
                             {Algorithm::sbm, 2660.49, 6593}};
  double newton = 0.0, sbm = 0.0;
  for (const CastingRow& row : rows) {
    const double used = add_casting(table, row, options.limit);
    if (row.algorithm == Algorithm::newton) newton = used;
    if (row.algorithm == Algorithm::sbm) sbm = used;
  }
  char text[120];
  std::snprintf(text, sizeof text,
                "Seconds of sbm over seconds of newton, in this run: %.3g (10 wanted).",
                sbm / newton);
  table.remarks.push_back(text);
  table.remarks.push_back(
      "Curl is the vertical displacement of the first monitor of the case, `" +
      (shown.monitors.empty() ? std::string("none") : shown.monitors.front().name) + "`.");
  return table;
}

}  // namespace dccast::verification
