#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <iostream>
#include <iterator>
#include <thread>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/commands/follow_alarms.hpp"
#include "client/model/answer.hpp"
#include "client/session/case_faults.hpp"
#include "client/session/jobs.hpp"
#include "client/session/kept_clock.hpp"
#include "client/session/line_source.hpp"
#include "client/session/readings.hpp"
#include "client/session/readings_table.hpp"
#include "client/session/studies.hpp"
#include "client/session/unsent_readings.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/values/digests.hpp"

namespace dccast::client {
namespace {

struct FollowOptions {
  std::string file;
  std::string job;
  std::string readings = "-";
  std::string columns;
  std::string jump_from;
  std::vector<std::string> set;
  std::vector<std::string> labels;
  std::string ensemble;
  std::string line;
  std::string noise = "1 mm", zero = "0 mm";
  std::string broker;
  AlarmOptions alarms;
  bool prepare = false;
  bool growing = false;
  bool json = false;
  bool strict = false;
};

void remark(const std::string& text) {
  std::cerr << "readings: " << text << std::endl;
}

/// What one line of the source holds, after its remarks are said.
ReadingsTable::Line take(const std::string& text, ReadingsTable& table,
                         std::vector<ReadingOfLine>& readings) {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  ReadingsTable::Line line = table.take(text, std::chrono::duration<double>(now).count());
  for (const std::string& each : line.remarks) remark(each);
  std::ranges::move(line.readings, std::back_inserter(readings));
  return line;
}

/// Reads until a line holds a reading, before anything is submitted: a source that cannot be used
/// makes no job. Throws CommandFailed: it ends before, or nothing of its first lines can be read.
std::vector<ReadingOfLine> read_first(LineSource& source, ReadingsTable& table) {
  constexpr int most_faulty = 10;
  std::vector<ReadingOfLine> readings;
  std::string fault;
  int faulty = 0;
  for (bool found = false; !found;) {
    const auto lines = source.next({});
    if (lines.empty() && !table.has_header()) throw invalid("the source of the readings is empty");
    if (lines.empty() || faulty >= most_faulty)
      throw invalid(fmt::format("the source of the readings has no value that can be read: {}",
                                fault.empty() ? "a header and nothing after it" : fault));

    for (const std::string& text : lines) {
      const ReadingsTable::Line line = take(text, table, readings);
      found = found || (line.time_s && (line.has_values || line.fault.empty()));
      if (!line.fault.empty() && ++faulty == 1) fault = line.fault;
    }
  }
  return readings;
}

/// What lines of the source hold.
std::vector<ReadingOfLine> readings_in(const std::vector<std::string>& lines,
                                       ReadingsTable& table) {
  std::vector<ReadingOfLine> readings;
  for (const std::string& text : lines) take(text, table, readings);
  return readings;
}

/// A command for the same case, "dccast follow --prepare my.toml --set 'time.end=40 s'".
std::string command_of(const std::string& command, const FollowOptions& options) {
  std::string text = fmt::format("{} {}", command, options.file);
  for (const std::string& change : options.set) text += fmt::format(" --set '{}'", change);
  return text;
}

/// A question about the preparation of the case that a job follows.
v1::PrepareCastingRequest preparation_of(const v1::SubmitJobRequest& job) {
  v1::PrepareCastingRequest request;
  *request.mutable_case_() = job.case_();
  *request.mutable_attachments() = job.attachments();
  *request.mutable_changes() = job.changes();
  request.set_case_file(job.case_file());
  return request;
}

/// Names what the forecast of a case rests on: a run of the plan, and the study that the user gives
/// or those that prepare it.
void add_studies(const FollowOptions& options, const v1::SubmitJobRequest& job,
                 Connection& connection, v1::Following& following) {
  v1::PrepareCastingRequest request = preparation_of(job);
  request.set_begins_now(true);
  const v1::Preparation found = connection.call(&Stub::PrepareCasting, request);
  following.set_plan_job(found.plan_job());
  if (!options.ensemble.empty()) {
    following.set_ensemble(resolve_study(connection, options.ensemble));
    return;
  }

  following.set_ensemble(found.ensemble().id());
  following.set_pairs(found.pairs().id());
  following.set_levers(found.levers().id());
  if (found.has_ensemble()) return;
  remark(
      fmt::format("this plan is not prepared: the forecast is its run, job {}, plus the last "
                  "difference between "
                  "measured and computed curl. Before the next casting: {}",
                  following.plan_job(), command_of("dccast follow --prepare", options)));
  if (!options.line.empty())
    remark(fmt::format("line {} learns nothing from a casting that is not prepared", options.line));
}

/// How the job follows: each curl of the source has a gauge.
v1::Following following_of(const FollowOptions& options, const ReadingsTable& table,
                           const v1::SubmitJobRequest& request, Connection& connection) {
  v1::Following following;
  if (!table.gauges().empty() || !options.ensemble.empty())
    add_studies(options, request, connection, following);

  following.set_line(options.line);
  if (!options.line.empty() && table.gauges().empty())
    remark(fmt::format("line {} learns nothing: no column has a measured curl", options.line));

  // Noise and zero are one figure for all gauges of a plant.
  for (const std::string& monitor : table.gauges()) {
    v1::Gauge& gauge = *following.add_gauges();
    gauge.set_monitor(monitor);
    gauge.set_noise_m(case_file::parse_quantity(options.noise, "m").value.value());
    gauge.set_zero_m(case_file::parse_quantity(options.zero, "m").value.value());
  }
  return following;
}

/// The case as a submission, its files uploaded. Throws CommandFailed.
v1::SubmitJobRequest sound_submission(const FollowOptions& options, Connection& connection) {
  CaseUnderCheck checked = read_case(options.file, changes_of(options.set));
  check_with_server(checked, connection);
  if (!checked.faults.empty()) {
    print_faults(checked, std::cerr);
    throw invalid("the case has faults; nothing was submitted");
  }
  v1::SubmitJobRequest request = submission_of(checked, connection);
  request.mutable_labels()->Assign(options.labels.begin(), options.labels.end());
  return request;
}

/// Submits the case as a job that follows readings. Throws CommandFailed.
std::string submit(const FollowOptions& options, const ReadingsTable& table,
                   Connection& connection) {
  v1::SubmitJobRequest request = sound_submission(options, connection);
  request.set_request_id(values::random_uuid());
  *request.mutable_following() = following_of(options, table, request, connection);
  v1::Job job;
  check(submit_with_retries(connection, request, job), connection.server());
  std::cerr << "job " << job.id() << " follows the casting" << std::endl;
  return job.id();
}

std::unique_ptr<LineSource> open_source(const FollowOptions& options) {
  if (!is_topic(options.readings))
    return lines_of_file(options.readings, options.growing ? FileEnd::grows : FileEnd::ends_source,
                         remark);

  auto source =
      lines_of_topic(parse_topic(options.readings), read_broker_login(options.broker), remark);
  remark("waiting for those of " + options.readings);
  return source;
}

/// Works beside the watch of the job, in a thread and with a connection of its own, and is
/// interrupted when it is destroyed.
class Companion {
public:
  explicit Companion(const Connection& connection)
      : connection_(connection.another(interruption_)) {}

  Connection& connection() { return connection_; }
  Interruption& interruption() { return *interruption_; }

  /// @param work  may throw Interrupted
  void start(std::function<void(const std::stop_token&)> work) {
    thread_ = std::jthread([this, work = std::move(work)](const std::stop_token& stop) {
      const std::stop_callback cancel(stop, [this] { interruption_->come(); });
      try {
        work(stop);
      } catch (const Interrupted&) {  // the job has ended, or the user has left
      }
    });
  }

  /// Interrupts the work, and waits for its end.
  void stop() { thread_ = {}; }

private:
  std::shared_ptr<Interruption> interruption_ = std::make_shared<Interruption>();
  Connection connection_;
  std::jthread thread_;
};

/// Readings on their way to a job: one thread reads the source, and another sends. While the server
/// is away what comes is kept.
class Sending {
public:
  /// Throws CommandFailed: the job follows no readings.
  Sending(const Connection& connection, std::string id)
      : id_(std::move(id)),
        clock_file_(kept_clock_file(id_)),
        companion_(connection),
        unsent_(unsent_readings_file(id_), remark),
        sender_(companion_.connection(), id_, remark) {}
  ~Sending() {
    reader_ = {};
    companion_.stop();  // it uses the other members
  }

  void start(LineSource& source, ReadingsTable& table, std::vector<ReadingOfLine> first) {
    companion_.start([this](const std::stop_token& stop) { send_all(stop); });
    reader_ =
        std::jthread([this, &source, &table, first = std::move(first)](
                         const std::stop_token& stop) { read_all(source, table, first, stop); });
  }

  const RecordSender& sender() const { return sender_; }
  /// Readings that the server does not have.
  std::size_t unsent() const { return unsent_.size(); }
  /// The casting has ended: nothing of its source is needed any more.
  void forget_clock() {
    reader_ = {};
    std::error_code error;
    std::filesystem::remove(clock_file_, error);
  }

private:
  void read_all(LineSource& source, ReadingsTable& table, const std::vector<ReadingOfLine>& first,
                const std::stop_token& stop) {
    try {
      keep_jumps(table);
      bool goes_on = unsent_.add(first, stop);
      while (goes_on) {
        const auto lines = source.next(stop);
        if (lines.empty()) break;
        std::vector<ReadingOfLine> readings = readings_in(lines, table);
        keep_jumps(table);
        goes_on = unsent_.add(std::move(readings), stop);
      }
      for (const std::string& each : table.summary()) remark(each);
      if (!stop.stop_requested()) unsent_.close();
    } catch (const std::exception& error) {
      end_early(error);
    }
  }

  /// Whoever goes on with the source must know of jumps before.
  void keep_jumps(const ReadingsTable& table) {
    const SourceClock::History& history = table.clock().history();
    if (history.jumps.size() == kept_jumps_) return;
    kept_jumps_ = history.jumps.size();
    if (const std::string fault = keep_clock(clock_file_, history); !fault.empty())
      remark(fault + "; if this program is started again, stamps are taken as they are");
  }

  /// Sends until the source ends, the job takes no more, or the stop is requested.
  void send_all(const std::stop_token& stop) {
    try {
      bool takes_more = true;
      for (auto readings = unsent_.next(stop); takes_more && !readings.empty();
           readings = unsent_.next(stop)) {
        const std::size_t count = readings.size();
        takes_more = sender_.send(std::move(readings));
        unsent_.acknowledge(count);
      }
      if (takes_more && !stop.stop_requested()) sender_.close();
      sender_.remark_left_out();
    } catch (const Interrupted&) {
      throw;
    } catch (const std::exception& error) {
      end_early(error);
    }
  }

  void end_early(const std::exception& error) const {
    remark(fmt::format("no more are sent: {}. The job waits for them: dccast follow --job {}",
                       error.what(), id_));
  }

  const std::string id_;
  const std::filesystem::path clock_file_;
  std::size_t kept_jumps_ = 0;  ///< of the clock of the source
  Companion companion_;
  UnsentReadings unsent_;
  RecordSender sender_;
  std::jthread reader_;
};

/// Watches the job to its end and tells alarms. A server that is away ends neither.
ExitCode watch_with_alarms(Connection& connection, const std::string& id, AlarmWatch& alarms,
                           const FollowOptions& options) {
  constexpr std::chrono::seconds between_looks{2};
  constexpr RetryPolicy for_ever{.attempts = 0};
  const auto watched = [&]() -> std::optional<ExitCode> {
    try {
      return watch_job(connection, id, 1, options.json, false, options.strict, for_ever);
    } catch (const Interrupted&) {
      throw;
    } catch (const CommandFailed& failure) {
      if (failure.code() != ExitCode::unreachable) throw;
      return std::nullopt;  // before the first event
    }
  };

  std::optional<ExitCode> code;
  {
    Companion companion(connection);
    companion.start([&](const std::stop_token&) {
      for (;; companion.interruption().sleep(between_looks)) alarms.look(companion.connection());
    });
    while (!(code = watched())) connection.interruption().sleep(between_looks);
  }
  alarms.look(connection);  // at what came last
  return *code;
}

/// Waits for the end of a study of a preparation. Throws CommandFailed: it was cancelled.
void await(const v1::Study& study, Connection& connection, const std::string& come_back) {
  std::cerr << fmt::format("study {}, {} runs\n", study.id(), study.runs());
  follow_with_progress(connection, study.id(), come_back);
  v1::GetStudyRequest request;
  request.set_id(study.id());
  if (connection.call(&Stub::GetStudy, request).state() == v1::STUDY_CANCELLED)
    throw CommandFailed(
        ExitCode::solve_failed,
        fmt::format("study {} was cancelled. Begin another: {}", study.id(), come_back));
}

/// Has the server compute what a forecast of the case rests on.
ExitCode run_preparation(const FollowOptions& options, Program& program) {
  if (options.file.empty() || options.file == "-" || !options.job.empty())
    throw invalid("name the case FILE to prepare");
  Connection connection = program.connect();
  const std::string come_back = command_of("dccast follow --prepare", options);

  const v1::SubmitJobRequest job = sound_submission(options, connection);
  v1::PrepareCastingRequest request = preparation_of(job);
  *request.mutable_labels() = job.labels();
  for (;;) {
    const v1::Preparation there = connection.call(&Stub::PrepareCasting, request);
    for (const v1::Study* study : {&there.ensemble(), &there.pairs(), &there.levers()})
      if (study->state() == v1::STUDY_RUNNING) await(*study, connection, come_back);
    if (there.ready()) break;
  }
  std::cerr << "the plan is prepared: " << command_of("dccast follow", options) << std::endl;
  return ExitCode::done;
}

/// The clock of the source. @param job  that waits for further readings; empty: it is a new one
SourceClock clock_of(const FollowOptions& options, const std::string& job) {
  std::optional<double> jump_from_s;
  if (!options.jump_from.empty())
    jump_from_s = case_file::parse_quantity(options.jump_from, "s").value;
  if (job.empty()) return SourceClock(jump_from_s);

  SourceClock::History before = read_kept_clock(kept_clock_file(job));
  if (!before.jumps.empty())
    remark(fmt::format(
        "the clock of the source had jumped by {:+.4g} s in all; stamps from there on are "
        "moved by as much",
        -before.jumps.back().offset_s));
  return SourceClock(jump_from_s, std::move(before));
}

ExitCode run(const FollowOptions& options, Program& program) {
  if (options.prepare) return run_preparation(options, program);
  if (options.file.empty() == options.job.empty()) throw invalid("give either FILE or --job JOB");
  if (options.file == "-" && options.readings == "-")
    throw invalid("standard input holds the readings; give the case as a file");

  const auto source = open_source(options);
  Connection connection = program.connect();
  std::string id;
  if (!options.job.empty()) id = resolve_job(connection, options.job);
  ReadingsTable table(read_columns(options.columns), clock_of(options, id));
  std::vector<ReadingOfLine> first = read_first(*source, table);
  if (id.empty()) id = submit(options, table, connection);

  AlarmHandlers handlers = alarm_handlers(options.alarms, options.broker, id);
  const bool has_forecast = !table.gauges().empty();
  if (!has_forecast) handlers = {.finding = handlers.finding, .lever = handlers.lever};
  AlarmWatch alarms(id, std::move(handlers));
  Sending sending(connection, id);
  sending.start(*source, table, std::move(first));
  ExitCode code{};
  try {
    code = watch_with_alarms(connection, id, alarms, options);
  } catch (const Interrupted&) {
    const std::size_t unsent = sending.unsent();
    throw Interrupted(fmt::format(
        "{}job {} waits for readings. Go on: dccast follow --job {}",
        unsent > 0 ? fmt::format("{} readings are kept for the server, and ", unsent) : "", id,
        id));
  }
  sending.forget_clock();
  if (code != ExitCode::done || sending.sender().has_values()) return code;

  remark("no value that was measured was used: the job has computed the plan of the case");
  return ExitCode::invalid;
}

constexpr const char* follow_examples =
    R"(dccast follow --prepare my.toml        # before the casting; takes minutes
  plant-logger | dccast follow my.toml --line pit-3
  dccast follow my.toml --readings today.csv --growing
  dccast follow my.toml --readings mqtt://broker/pit3 --columns plc.toml --notify 'beep'
  dccast follow my.toml --readings casting-41.csv        # one that was cast, computed again
  plant-logger | dccast follow --job JOB                 # after this program was stopped

The source is a table whose first line names the columns, or JSON objects with such names, one a line:
  time [s], speed [mm/min], water [l/min/m], narrow water [l/min/m], metal [degC], curl corner [mm]
A measured curl gives a forecast: dccast forecast JOB.)";

}  // namespace

void add_follow(CommandLine& line, Program& program) {
  const auto [command, options] = declare<FollowOptions>(
      line, program, run, "follow",
      "Compute a casting while it is cast: measured speed, water and metal temperature replace the "
      "plan of the case up to the last reading. Ctrl-C ends the sending alone, the job waits",
      follow_examples);

  command.option("FILE", options.file, "Case file: the plan");
  command.option("--job", options.job, "Instead of a FILE: go on with this job, which waits",
                 {.placeholder = "JOB"});
  add_set_option(command, options.set);
  command.repeatable("--label", options.labels, "Label for finding the job; repeatable",
                     {.comma_separated = true});

  // Where the readings come from.
  command.option(
      "--readings", options.readings,
      "File with the readings, or MQTT topic such as mqtt://HOST/TOPIC; - for standard input "
      "(default)",
      {.placeholder = "SOURCE"});
  command.option("--broker", options.broker,
                 "TOML file with the login at the broker: user, password, ca, certificate, key",
                 {.placeholder = "FILE"});
  add_columns_option(command, options.columns);
  command.flag(
      "--growing", options.growing,
      "The file grows: wait for further lines at its end. Otherwise its end is that of the "
      "casting");

  command.option(
      "--jump-from", options.jump_from,
      "A step of the clock of this length and more is a jump, a shorter one a gap without "
      "readings; "
      "of lines that are read at once, as those that come in real time tell it by their arrival. "
      "Default \"60 s\", and at least ten usual pauses",
      {.fault =
           [](const std::string& text) { return case_file::parse_quantity(text, "s").message; },
       .placeholder = "TIME"});

  // What the forecast rests on.
  const Rules length{.fault = [](const std::string& text) {
    return case_file::parse_quantity(text, "m").message;
  }};
  command.flag("--prepare", options.prepare,
               "Instead of following: compute what the forecast of this plan rests on");
  command.option("--ensemble", options.ensemble,
                 "Study of uncertainty of this plan instead of what --prepare computed",
                 {.placeholder = "STUDY"});
  command.option(
      "--line", options.line,
      "Line on which the casting is made: the forecast learns from its earlier castings, "
      "and the next ones from this (dccast line)",
      {.placeholder = "NAME", .excludes = {"--job", "--prepare"}});
  command.option("--noise", options.noise,
                 "Standard deviation of a measured curl; default \"1 mm\"", length);
  command.option("--zero", options.zero,
                 "Standard deviation of the unknown zero of its gauge; default \"0 mm\"", length);

  add_alarm_options(command, options.alarms);
  command.flag("--strict", options.strict,
               "Exit code 3 also for a job with findings beyond notes (docs/findings.md)");
  command.json(options.json, "One JSON object per event and line");
}

}  // namespace dccast::client
