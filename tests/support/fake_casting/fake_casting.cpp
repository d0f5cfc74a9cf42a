// A casting whose behaviour follows from the title of its case: README.md.
#include <signal.h>

#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <map>
#include <optional>
#include <sstream>
#include <system_error>
#include <thread>

#include "core/casting/case/case_check.hpp"
#include "core/casting/findings/judge.hpp"
#include "core/casting/forecast.hpp"
#include "core/casting/simulation.hpp"
#include "core/casting/stored_run.hpp"
#include "core/results/result_writer.hpp"
#include "tests/support/fake_casting/attack.hpp"

namespace dccast::casting {

namespace {

/// The words KEY=VALUE of a title.
class Script {
public:
  explicit Script(const std::string& title) {
    std::istringstream words(title);
    for (std::string word; words >> word;)
      if (const auto equals = word.find('='); equals != std::string::npos)
        words_[word.substr(0, equals)] = word.substr(equals + 1);
  }
  /// The number of a key; `otherwise` if it is absent or not a number.
  std::int64_t number(const std::string& key, std::int64_t otherwise) const {
    const auto found = words_.find(key);
    if (found == words_.end()) return otherwise;

    std::int64_t number = otherwise;  // tests mutate titles: the value may be anything
    std::from_chars(found->second.data(), found->second.data() + found->second.size(), number);
    return number;
  }
  /// The text of a key; empty if it is absent.
  std::string word(const std::string& key) const {
    const auto found = words_.find(key);
    return found == words_.end() ? "" : found->second;
  }

private:
  std::map<std::string, std::string> words_;
};

/// The state of a run, also the content of its checkpoint.
struct State {
  std::int64_t step = 0;
  double displacement = 0.0;  ///< of the first monitor [m]
  bool found = false;         ///< the finding of `finding_at`
};

void advance(State& state) {
  ++state.step;
  state.displacement = 0.9 * state.displacement + 1e-3 * std::sin(static_cast<double>(state.step));
}

/// Writes a checkpoint completely or not at all: renames it after the write, as the real solver
/// does.
void write_checkpoint(const std::filesystem::path& folder, const State& state) {
  {
    std::ofstream file(folder / "checkpoint.bin.part", std::ios::binary);
    file.write(reinterpret_cast<const char*>(&state), sizeof state);
    if (!file.flush()) throw std::system_error(ENOSPC, std::generic_category(), "checkpoint.bin");
  }
  std::filesystem::rename(folder / "checkpoint.bin.part", folder / "checkpoint.bin");
}

bool read_checkpoint(const std::filesystem::path& folder, State& state) {
  std::ifstream file(folder / "checkpoint.bin", std::ios::binary);
  return static_cast<bool>(file.read(reinterpret_cast<char*>(&state), sizeof state));
}

void write_results(const std::filesystem::path& folder, const Script& script, std::int64_t steps) {
  {
    std::ofstream file(folder / "results.h5.part", std::ios::binary);
    State state;
    file << std::setprecision(17);
    while (state.step < steps) {
      advance(state);
      file << state.step << ' ' << state.displacement << '\n';
    }
    const std::string line(1024, 'x');
    for (std::int64_t written = 0; written < script.number("big", 0); written += 1024) file << line;
    if (!file.flush()) throw std::system_error(ENOSPC, std::generic_category(), "results.h5");
  }
  std::filesystem::rename(folder / "results.h5.part", folder / "results.h5");
}

/// A cold quarter slab one metre high that is narrower than its mould: by `per_mille` of the
/// opening in the middle of the face, by three tenths of that at its end.
results::Frame cold_slab(const mesh::SectionSpec& section, double per_mille) {
  results::Frame frame;
  frame.dimension = 3;
  frame.nodes_per_element = 8;
  frame.metal_level = 1.0;

  constexpr int columns = 12, layers = 2, rows = 20;
  for (int k = 0; k <= rows; ++k)
    for (int i = 0; i <= columns; ++i)
      for (int j = 0; j <= layers; ++j) {
        const double along = double(i) / columns, share = double(j) / layers;
        const double opening = section.half_thickness(along * section.half_width);
        const double lost = 1e-3 * per_mille * (1.0 - 0.7 * along * along) * opening;
        frame.node.insert(frame.node.end(),
                          {along * section.half_width, share * opening, double(k) / rows});
        frame.displacement.insert(frame.displacement.end(), {0.0, -share * lost, 0.0});
        frame.temperature.push_back(20.0);
      }

  // One element is enough: only the nodes are read.
  constexpr int row = (columns + 1) * (layers + 1);
  for (const int n : {0, layers + 1, layers + 2, 1}) frame.element_node.push_back(n);
  for (const int n : {0, layers + 1, layers + 2, 1}) frame.element_node.push_back(row + n);
  return frame;
}

/// Writes results with one frame, as the real worker does.
void write_slab(const std::filesystem::path& folder, const Case& c, double per_mille) {
  results::RunHeader header;
  header.title = c.title;
  header.section = "quarter_slab";
  header.liquidus = 649.0;
  header.solidus = 620.0;
  header.shell = 620.0;
  header.dimension = 3;

  results::ResultWriter writer({folder / "journal.bin", folder / "results.h5"}, header);
  writer.append(cold_slab(c.section, per_mille));
  writer.publish({});
  std::filesystem::remove(folder / "journal.bin");
}

results::StepReport make_report(const State& state, std::int64_t steps, double seconds) {
  results::StepReport report;
  report.step = state.step;
  report.time = static_cast<double>(state.step);
  report.time_step = 1.0;
  report.cast_length = 1e-3 * static_cast<double>(state.step);
  report.iterations = 4;
  report.monitor_displacement = {{0.0, state.displacement}};
  report.solver_seconds = seconds;
  report.progress = static_cast<double>(state.step) / static_cast<double>(steps);
  return report;
}

Finding make_finding(std::int64_t step) {
  Finding finding;
  finding.code = "bleed_out_at_exit";
  finding.severity = Severity::danger;
  finding.message = "The shell leaves the mould 3 mm thick.";
  finding.time = static_cast<double>(step);
  finding.place = {0.28, 0.04};
  finding.value = 3e-3;
  finding.limit = 5e-3;
  finding.unit = "m";
  finding.key = "plausibility.minimum_shell";
  return finding;
}

/// A run with its state.
struct FakeRun {
  const Script& script;
  const RunDirectory& directory;
  StepObserver& observer;
  std::int64_t steps;
  bool opens_too_far = false;  ///< the mould, for `fail_open_mm`
  bool resumed = false;
  State state{};
  std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();

  results::StepReport report(const State& reported) const {
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
    return make_report(reported, steps, spent.count());
  }
  /// Whether the present step is the one that the script names.
  bool is(const char* word) const { return state.step == script.number(word, -1); }

  std::optional<RunOutcome> resume();
  void wait() const;
  void misbehave() const;
  RunOutcome solve_failed() const;
  std::optional<RunOutcome> step();
};

/// Continues from a checkpoint, if there is one.
/// @return the outcome if the checkpoint has "another version" and the run must not begin
std::optional<RunOutcome> FakeRun::resume() {
  if (!directory.resume || !read_checkpoint(directory.path, state)) return std::nullopt;

  if (script.number("other_version", 0) != 0) {
    state = {};
    const RunFailure failure{FailureKind::other_version, "another version wrote it", 0, 0, {}, {}};
    if (directory.other_version == OtherVersion::wait)
      return RunOutcome{RunEnd::other_version, {failure}};
    if (directory.other_version == OtherVersion::fail) return RunOutcome{RunEnd::failed, {failure}};
    observer.on_message(failure.message + ": the run starts from the beginning");
    std::filesystem::remove(directory.path / "checkpoint.bin");
    return std::nullopt;
  }

  resumed = true;
  observer.on_resumed(state.step, static_cast<double>(state.step));
  if (state.found) observer.on_finding(make_finding(script.number("finding_at", -1)));
  return std::nullopt;
}

void FakeRun::wait() const {
  while (is("wait_at") && !std::filesystem::exists(directory.path / "go"))
    std::this_thread::sleep_for(std::chrono::milliseconds(5));  // until the test lets it go on
}

/// Crashes, hangs, freezes or attacks, if the script asks for it in this step.
void FakeRun::misbehave() const {
  if (is("crash_at")) std::abort();
  if (resumed) return;

  if (is("crash_once_at")) std::abort();
  if (is("freeze_once_at")) ::raise(SIGSTOP);
  if (const auto bytes = script.number("attack", 0); bytes > 0 && state.step == 2)
    std::ofstream(directory.path / "taken")
        << attack(static_cast<std::size_t>(bytes), directory.path);
  while (is("hang_once_at")) std::this_thread::sleep_for(std::chrono::hours(1));  // it is killed
}

RunOutcome FakeRun::solve_failed() const {
  if (!directory.keeps_nothing && script.number("partial", 0) != 0)
    write_results(directory.path, script, state.step);
  RunFailure failure;
  failure.message = "did not converge";
  failure.time = static_cast<double>(state.step);
  failure.time_step = 1e-3;
  failure.residual_history = {1.0, 0.5};
  return {RunEnd::failed, {failure}};
}

/// Computes a step. @return the outcome if the run ends with it
std::optional<RunOutcome> FakeRun::step() {
  wait();
  std::this_thread::sleep_for(std::chrono::milliseconds(script.number("sleep_ms", 0)));  // computes
  advance(state);
  misbehave();
  if (is("fail_at") || opens_too_far) return solve_failed();

  if (is("finding_at")) observer.on_finding(make_finding(state.step));
  state.found |= is("finding_at");

  const Order order = observer.on_step(report(state));
  if (!directory.keeps_nothing && state.step % script.number("checkpoint", 5) == 0)
    write_checkpoint(directory.path, state);

  if (script.number("deaf", 0) != 0 || order == Order::go_on) return std::nullopt;
  if (order == Order::cancel) return RunOutcome{RunEnd::cancelled, {}};
  write_checkpoint(directory.path, state);
  return RunOutcome{RunEnd::stopped, {}};
}

}  // namespace

std::vector<Finding> findings_of_case(const Case&) {
  return {};
}

std::vector<Finding> forecast(const Case& casting_case) {
  const auto step = Script(casting_case.title).number("finding_at", -1);
  return step < 0 ? std::vector<Finding>{} : std::vector{make_finding(step)};
}

CheckedCase check(const Case& casting_case, const std::vector<std::string>&) {
  const Script script(casting_case.title);
  CheckedCase checked;
  if (script.word("check") == "crash") std::abort();
  std::this_thread::sleep_for(std::chrono::milliseconds(script.number("check_ms", 0)));  // checks
  if (script.word("check") == "fault") {
    checked.faults.add("monitor[0].y", 7.0, "is outside the slab", "0 to 0.1 m", "move it");
    checked.faults.add("limits.maximum_steps", 10.0, "the case has 145 steps", "at least 145", "");
  }
  checked.estimate = {.nodes = script.number("nodes", 1),
                      .elements = 1,
                      .steps = script.number("steps", 20),
                      .solver_seconds = static_cast<double>(script.number("estimate_s", 0)),
                      .memory_bytes = static_cast<double>(script.number("memory", 0))};
  return checked;
}

const std::string& solver_identity() {
  static const std::string identity = "no solver at all";
  return identity;
}

RunOutcome run(const Case& casting_case, const RunDirectory& directory, StepObserver& observer, int,
               LeverFeed*) {
  const Script script(casting_case.title);
  const std::int64_t widest_mm = script.number("fail_open_mm", 0);
  FakeRun fake{script, directory, observer, script.number("steps", 20),
               widest_mm > 0 && 1e3 * casting_case.section.half_thickness(0.0) > double(widest_mm)};
  if (const auto refused = fake.resume()) return *refused;

  while (fake.state.step < fake.steps)
    if (const auto end = fake.step()) return *end;

  if (directory.keeps_nothing) return {};
  if (const auto per_mille = script.number("mould", 0); per_mille > 0)
    write_slab(directory.path, casting_case, static_cast<double>(per_mille));
  else
    write_results(directory.path, script, fake.steps);
  return {};
}

}  // namespace dccast::casting
