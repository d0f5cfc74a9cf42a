// What it does stands in tests/support/fake_casting/README.md.
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <map>
#include <sstream>
#include <system_error>
#include <thread>

#include "core/casting/case_check.hpp"
#include "core/casting/simulation.hpp"

namespace dccast::casting {

namespace {

class Script {
public:
  explicit Script(const std::string& title) {
    std::istringstream words(title);
    for (std::string word; words >> word;)
      if (const auto equals = word.find('='); equals != std::string::npos)
        words_[word.substr(0, equals)] = word.substr(equals + 1);
  }
  std::int64_t number(const std::string& key, std::int64_t otherwise) const {
    const auto found = words_.find(key);
    return found == words_.end() ? otherwise : std::stoll(found->second);
  }
  std::string word(const std::string& key) const {
    const auto found = words_.find(key);
    return found == words_.end() ? "" : found->second;
  }

private:
  std::map<std::string, std::string> words_;
};

struct State {
  std::int64_t step = 0;
  double displacement = 0.0;  ///< of the first monitor [m]
};

void advance(State& state) {
  ++state.step;
  state.displacement = 0.9 * state.displacement + 1e-3 * std::sin(static_cast<double>(state.step));
}

/// Whole or not at all: rename after the write, as the real one does.
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

results::StepReport report_of(const State& state, std::int64_t steps, double seconds) {
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

}  // namespace

CheckedCase check(const Case& casting_case, const std::vector<std::string>&) {
  const Script script(casting_case.title);
  CheckedCase checked;
  if (script.word("check") == "crash") std::abort();
  if (script.word("check") == "fault") {
    checked.faults.add("monitor[0].y", 7.0, "is outside the slab", "0 to 0.1 m", "move it");
    checked.faults.add("limits.maximum_steps", 10.0, "the case has 145 steps", "at least 145", "");
  }
  checked.estimate = {.nodes = 1,
                      .elements = 1,
                      .steps = script.number("steps", 20),
                      .solver_seconds = 0.0,
                      .memory_bytes = 0.0};
  return checked;
}

RunOutcome run(const Case& casting_case, const RunDirectory& directory, StepObserver& observer) {
  const Script script(casting_case.title);
  const std::int64_t steps = script.number("steps", 20);
  const auto begin = std::chrono::steady_clock::now();
  State state;
  const bool resumed = directory.resume && read_checkpoint(directory.path, state);
  if (resumed) observer.on_resumed(state.step, static_cast<double>(state.step));
  while (state.step < steps) {
    std::this_thread::sleep_for(std::chrono::milliseconds(script.number("sleep_ms", 0)));
    advance(state);
    if (state.step == script.number("crash_at", -1)) std::abort();
    if (!resumed && state.step == script.number("crash_once_at", -1)) std::abort();
    if (state.step == script.number("fail_at", -1))
      return {RunEnd::failed,
              {{FailureKind::solve_failed,
                "did not converge",
                static_cast<double>(state.step),
                1e-3,
                {},
                {1.0, 0.5}}}};
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
    const Order order = observer.on_step(report_of(state, steps, spent.count()));
    if (state.step % script.number("checkpoint", 5) == 0) write_checkpoint(directory.path, state);
    if (script.number("deaf", 0) != 0 || order == Order::go_on) continue;
    if (order == Order::cancel) return {RunEnd::cancelled, {}};
    write_checkpoint(directory.path, state);
    return {RunEnd::stopped, {}};
  }
  write_results(directory.path, script, steps);
  return {};
}

}  // namespace dccast::casting
