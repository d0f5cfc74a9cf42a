#include <fmt/format.h>

#include <algorithm>
#include <iostream>

#include "client/commands/commands.hpp"
#include "client/model/answer.hpp"
#include "client/session/jobs.hpp"
#include "client/text/forecast_text.hpp"
#include "client/text/table.hpp"

namespace dccast::client {
namespace {

struct ForecastOptions {
  std::string id;
  bool json = false;
};

void add_rows(const v1::ForecastCurl& curl, double now_s, Table& table) {
  const double end_s = *curl.time_s().rbegin();
  const auto add = [&](const std::string& when, double at_s) {
    const CurlToCome there = curl_to_come(curl, at_s);
    table.add({curl.monitor(), when, fixed(at_s, 0), fixed(there.curl_mm, 1),
               fixed(there.lower_mm, 1), fixed(there.upper_mm, 1)});
  };

  add("now", std::clamp(now_s, 0.0, end_s));
  for (const double ahead_s : {30.0, 60.0, 120.0})
    if (now_s + ahead_s < end_s && now_s + ahead_s > 0.0)
      add(fmt::format("in {:.0f} s", ahead_s), now_s + ahead_s);
  add("end", end_s);
}

/// What castings on the line have told.
void print_line_memory(const v1::ForecastCurl& curl) {
  const v1::LineMemory& line = curl.line();
  if (line.castings() == 0) {
    std::cout << fmt::format("{}: no earlier casting on the line counts\n", curl.monitor());
    return;
  }
  std::cout << fmt::format(
      "{}: {} earlier casting{} on the line; {:.0f} % of the variance differs from "
      "casting to casting, the model is off by {:.0f} %\n",
      curl.monitor(), line.castings(), line.castings() == 1 ? "" : "s", 100.0 * line.scatter(),
      100.0 * line.model_error());
}

void print_forecast(const v1::Forecast& forecast) {
  Table table({"curl of", "when", ">at s", ">mm", ">5 %", ">95 %"});
  for (const v1::ForecastCurl& curl : forecast.curls()) add_rows(curl, forecast.time_s(), table);
  std::cout << table.text();

  for (const v1::ForecastCurl& curl : forecast.curls()) {
    std::cout << fmt::format("{}: {} readings, {} left out; {}\n", curl.monitor(), curl.readings(),
                             curl.left_out(),
                             curl.members() > 0 ? fmt::format("{} members", curl.members())
                                                : "the run of the plan alone");
    std::cout << fmt::format("{}: before the casting {:.1f} mm at its end ({:.1f} to {:.1f})\n",
                             curl.monitor(), 1e3 * curl.before().curl_m(),
                             1e3 * curl.before().lower_m(), 1e3 * curl.before().upper_m());

    if (curl.has_line()) print_line_memory(curl);
    // Only a gauge whose zero is uncertain has a figure for it.
    if (curl.zero_upper_m() > curl.zero_lower_m())
      std::cout << fmt::format("{}: the gauge shows {:.1f} mm too much ({:.1f} to {:.1f})\n",
                               curl.monitor(), 1e3 * curl.zero_m(), 1e3 * curl.zero_lower_m(),
                               1e3 * curl.zero_upper_m());
  }
}

/// What is off, what may come, and how much the forecast rests on.
void print_remarks(const v1::Forecast& forecast) {
  for (const v1::ForecastWarning& warning : forecast.warnings())
    std::cout << fmt::format("warning at {:.0f} s, {}\n", warning.time_s(), warning_text(warning));
  for (const v1::ForecastFinding& finding : forecast.findings())
    std::cout << fmt::format("to come in {} of {} members: {}\n", finding.members(), finding.of(),
                             finding.rule());
  for (const std::string& advice : forecast.advice())
    std::cout << "what can still be done: " << advice << '\n';
  for (const std::string& note : forecast.notes()) std::cout << "note: " << note << '\n';
}

ExitCode run(const ForecastOptions& options, Program& program) {
  Connection connection = program.connect();
  const v1::Forecast forecast =
      connection.call(&Stub::ForecastJob, resolve_job(connection, options.id));
  if (options.json) {
    print_line(to_json(forecast));
    return ExitCode::done;
  }
  print_forecast(forecast);
  print_remarks(forecast);
  return ExitCode::done;
}

}  // namespace

void add_forecast(CommandLine& line, Program& program) {
  const auto [command, options] = declare<ForecastOptions>(
      line, program, run, "forecast",
      "The curl to come of a casting that a job follows, from the curl measured so far",
      "dccast forecast last\n  watch -n 2 dccast forecast JOB");
  command.option("JOB", options.id, job_help, required);
  command.json(options.json);
}

}  // namespace dccast::client
