#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <vector>

#include "client/commands/commands.hpp"
#include "client/model/answer.hpp"
#include "client/session/jobs.hpp"
#include "client/text/job_text.hpp"
#include "client/text/table.hpp"

namespace dccast::client {
namespace {

struct LineOptions {
  std::string name;
  bool json = false;
};

ExitCode list(const LineOptions& options, Program& program) {
  Connection connection = program.connect();
  const auto answer = connection.call(&Stub::ListLines, v1::ListLinesRequest());
  // A file that cannot be read hides no other line.
  for (const std::string& name : answer.damaged())
    std::cerr << fmt::format(
        "line {0} is damaged: restore its file from a backup, or dccast line forget "
        "{0}\n",
        name);
  if (options.json) {
    print_line(json_list(answer.lines(), [](const v1::Line& line) { return to_json(line); }));
    return ExitCode::done;
  }

  Table table({"LINE", "OWNER", ">CASTINGS", "SINCE"});
  for (const v1::Line& line : answer.lines())
    table.add({line.name(), line.owner(), std::to_string(line.castings_size()),
               time_text(line.has_restart_time() ? line.restart_time() : line.create_time())});
  if (answer.lines().empty() && answer.damaged().empty())
    std::cerr << "no lines: dccast follow CASE --line NAME begins one\n";
  else if (!answer.lines().empty())
    std::cout << table.text();
  return ExitCode::done;
}

/// What a casting has told: its last measured curl.
std::string told_text(const v1::LineCasting& casting) {
  if (!casting.ended()) return "has not ended";
  std::vector<std::string> curls;
  for (const v1::ObservedCurl& curl : casting.curls())
    if (!curl.time_s().empty())
      curls.push_back(fmt::format("{} {:.1f} mm at {:.0f} s", curl.monitor(),
                                  1e3 * *curl.curl_m().rbegin(), *curl.time_s().rbegin()));
  return curls.empty() ? "nothing" : fmt::format("{}", fmt::join(curls, ", "));
}

ExitCode print(const LineOptions& options, const v1::Line& line) {
  if (options.json) {
    print_line(to_json(line));
    return ExitCode::done;
  }

  std::cout << fmt::format("line {} of {}, since {}\n", line.name(), line.owner(),
                           time_text(line.create_time()));
  if (line.has_restart_time())
    std::cout << fmt::format("begun afresh {}\n", time_text(line.restart_time()));
  // Ids are cut to the length that still tells these jobs apart.
  std::vector<std::string> jobs;
  for (const v1::LineCasting& casting : line.castings()) jobs.push_back(casting.job());
  const std::size_t length = short_id_length(jobs);
  Table table({"JOB", "BEGUN", "MEASURED", "TITLE"});
  for (const v1::LineCasting& casting : line.castings())
    table.add({casting.job().substr(0, length), time_text(casting.begin_time()), told_text(casting),
               casting.title()});
  if (line.castings().empty())
    std::cout << "no castings\n";
  else
    std::cout << table.text();
  return ExitCode::done;
}

template <typename Request>
Request request_for(const LineOptions& options) {
  Request request;
  request.set_id(options.name);
  return request;
}

ExitCode show(const LineOptions& options, Program& program) {
  Connection connection = program.connect();
  return print(options, connection.call(&Stub::GetLine, request_for<v1::GetLineRequest>(options)));
}

ExitCode restart(const LineOptions& options, Program& program) {
  Connection connection = program.connect();
  return print(options,
               connection.call(&Stub::RestartLine, request_for<v1::RestartLineRequest>(options)));
}

ExitCode forget(const LineOptions& options, Program& program) {
  Connection connection = program.connect();
  connection.call_once(&Stub::DeleteLine, request_for<v1::DeleteLineRequest>(options));
  if (options.json)
    print_line({{"name", options.name}, {"deleted", true}});
  else
    std::cerr << "line " << options.name << " is forgotten; its jobs and studies stay\n";
  return ExitCode::done;
}

}  // namespace

void add_line(CommandLine& line, Program& program) {
  const auto [command, options] = declare<LineOptions>(
      line, program, list, "line",
      "Lines, on which castings share mould, water and metal; show, restart or forget one. A "
      "casting "
      "joins a line by dccast follow --line",
      "dccast line list\n  dccast line show pit-3\n  dccast line restart pit-3    new mould, new "
      "water: earlier castings do not count any more");
  command.json(options.json);

  // Without an action of its own `dccast line` lists them, as `dccast studies` does.
  const auto add = [&, &options = options](const std::string& name, const std::string& description,
                                           ExitCode (*run)(const LineOptions&, Program&)) {
    const Command added = command.command(name, description);
    added.json(options.json);
    added.action([&options, &program, run] { return run(options, program); });
    return added;
  };
  add("list", "All lines", list);
  for (const Command& named :
       {add("show", "The castings on a line, and what each has told", show),
        add("restart", "Begin afresh: the castings so far do not count any more", restart),
        add("forget", "Remove a line; its jobs and studies stay", forget)})
    named.option("NAME", options.name, "Name of the line", required);
}

}  // namespace dccast::client
