#include <algorithm>
#include <chrono>
#include <iostream>
#include <limits>

#include "client/commands/commands.hpp"
#include "client/session/line_source.hpp"
#include "client/session/readings_table.hpp"

namespace dccast::client {
namespace {

using Clock = std::chrono::steady_clock;

struct ReplayOptions {
  std::string file;
  std::string columns;
  int pace = 1;
};

/// Keeps the time of the record, faster or as it was.
class Pace {
public:
  Pace(int pace, Interruption& interruption) : pace_(pace), interruption_(interruption) {}

  /// Waits until a time of the record has come; its first one comes at once. Throws Interrupted.
  void await(double time_s) {
    first_s_ = std::min(first_s_, time_s);
    const std::chrono::duration<double> due((time_s - first_s_) / pace_);
    const auto left = begin_ + due - Clock::now();
    if (left.count() > 0) interruption_.sleep(std::chrono::ceil<std::chrono::milliseconds>(left));
  }

private:
  int pace_;
  Interruption& interruption_;
  Clock::time_point begin_ = Clock::now();
  double first_s_ = std::numeric_limits<double>::infinity();  ///< smallest time so far
};

ExitCode run(const ReplayOptions& options, Program& program) {
  const auto source = lines_of_file(options.file, FileEnd::ends_source);
  ReadingsTable table(read_columns(options.columns));
  Pace pace(options.pace, *program.interruption);

  for (auto lines = source->next({}); !lines.empty(); lines = source->next({}))
    for (const std::string& line : lines) {
      // A line that cannot be read has no time; who reads it says what is wrong with it.
      if (const auto time_s = table.take(line).time_s) pace.await(*time_s);
      if (!(std::cout << line << std::endl)) return ExitCode::output_lost;
    }
  if (!table.has_header()) throw invalid(options.file + " is empty");
  return ExitCode::done;
}

}  // namespace

void add_replay(CommandLine& line, Program& program) {
  const auto [command, options] =
      declare<ReplayOptions>(line, program, run, "replay",
                             "Write a recorded table of readings as a plant would, line by line at "
                             "the times of its column "
                             "\"time\"",
                             "dccast replay casting-41.csv --pace 50 | dccast follow my.toml");
  command.option("FILE", options.file, "The table, as `dccast follow` takes it", required);
  add_columns_option(command, options.columns);
  command.number("--pace", options.pace, 1, 1000, "How many times faster than it was");
}

}  // namespace dccast::client
