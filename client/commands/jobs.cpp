#include <unistd.h>

#include <functional>
#include <iostream>
#include <map>
#include <set>

#include "client/commands/commands.hpp"
#include "client/session/jobs.hpp"
#include "client/session/queries.hpp"
#include "client/session/studies.hpp"
#include "client/session/user_command.hpp"
#include "client/text/job_text.hpp"
#include "proto/values/printable.hpp"

namespace dccast::client {
namespace {

struct ListOptions {
  std::vector<std::string> states;
  std::vector<std::string> labels;
  std::vector<std::string> columns;
  std::string study;
  std::string owner;
  std::string since;
  std::string name;
  bool mine = false;
  bool all = false;
  int limit = 50;
  bool ids = false;
  bool json = false;
};

const std::map<std::string, v1::JobState> state_names{
    {"queued", v1::QUEUED},       {"running", v1::RUNNING}, {"paused", v1::PAUSED},
    {"succeeded", v1::SUCCEEDED}, {"failed", v1::FAILED},   {"cancelled", v1::CANCELLED}};

v1::ListJobsRequest request_of(Connection& connection, const ListOptions& options) {
  v1::ListJobsRequest request;
  for (const std::string& state : options.states) request.add_states(state_names.at(state));
  request.mutable_labels()->Assign(options.labels.begin(), options.labels.end());
  if (!options.study.empty()) request.set_study(resolve_study(connection, options.study));
  request.set_owner(options.mine ? user_name(connection) : options.owner);
  if (!options.since.empty()) request.mutable_since()->set_seconds(seconds_of_past(options.since));
  request.set_title(options.name);
  return request;
}

/// How a list shows the runs of studies: not, below a line of their study, or as jobs like others.
enum class View { folded, below_study, flat };

/// Who asks for certain jobs, or writes for another program, gets these jobs.
View view_of(const ListOptions& options) {
  if (options.all) return View::below_study;
  const bool asks_for_some = !options.study.empty() || !options.states.empty() ||
                             !options.labels.empty() || !options.name.empty();
  return asks_for_some || options.ids || options.json ? View::flat : View::folded;
}

/// The studies of the jobs by id. A study that no longer exists has nothing but its id.
std::map<std::string, v1::Study> studies_of(Connection& connection,
                                            const std::vector<v1::Job>& jobs) {
  std::map<std::string, v1::Study> studies;
  for (const v1::Job& job : jobs)
    if (!job.study().empty()) studies[job.study()].set_id(job.study());

  // The newest jobs belong to the newest studies, so the first page mostly has them all.
  std::size_t missing = studies.size();
  if (missing == 0) return studies;
  read_studies(connection, {}, [&](const v1::Study& study) {
    if (const auto found = studies.find(study.id()); found != studies.end()) {
      found->second = study;
      --missing;
    }
    return missing > 0;
  });
  return studies;
}

/// The lines of a list. A study stands where its newest run does.
std::vector<ListLine> lines_of(Connection& connection, const std::vector<v1::Job>& jobs,
                               View view) {
  std::vector<ListLine> lines;
  std::map<std::string, std::vector<ListLine>> runs;
  for (const v1::Job& job : jobs)
    if (!job.study().empty()) runs[job.study()].push_back({.job = job, .below_study = true});

  const bool has_studies = view != View::flat && !runs.empty();
  const auto studies =
      has_studies ? studies_of(connection, jobs) : std::map<std::string, v1::Study>{};
  for (const v1::Job& job : jobs) {
    if (!has_studies || job.study().empty()) {
      lines.push_back({.job = job});
    } else if (const auto found = runs.find(job.study()); found != runs.end()) {
      lines.push_back({.study = studies.at(job.study())});
      if (view == View::below_study)
        lines.insert(lines.end(), found->second.begin(), found->second.end());
      // The line of a study stands for all of its runs that follow.
      runs.erase(found);
    }
  }
  return lines;
}

/// Reasons for which jobs are held, without repetition and without those that their states name.
void print_holds(const std::vector<v1::Job>& jobs) {
  std::set<std::string> reasons;
  for (const v1::Job& job : jobs)
    if (!job.held().empty() && !waits_for_others(job) && !waits_for_its_time(job))
      reasons.insert(job.held());
  for (const std::string& reason : reasons) std::cerr << "held: " << reason << '\n';
}

ExitCode run(const ListOptions& options, Program& program) {
  Connection connection = program.connect();
  const View view = view_of(options);
  const JobListing listing = list_jobs(connection, request_of(connection, options), options.limit,
                                       view == View::folded ? Runs::together : Runs::each);
  if (options.json)
    print_line(json_list(listing.jobs, to_json));
  else if (options.ids)
    for (const v1::Job& job : listing.jobs) std::cout << job.id() << '\n';
  else if (!listing.jobs.empty())
    std::cout << job_table(lines_of(connection, listing.jobs, view), options.columns,
                           terminal_of(STDOUT_FILENO))
              << std::flush;
  if (listing.jobs.empty()) std::cerr << "no jobs\n";
  if (listing.more)
    std::cerr << "these are the newest " << options.limit << "; there are more: --limit\n";
  // In the list a job that is held looks like one that waits.
  if (!options.json) print_holds(listing.jobs);
  return ExitCode::done;
}

constexpr const char* list_examples =
    R"(dccast list --state running,queued
  dccast list --mine --since yesterday --name 'line 3*'
  dccast list --all
  dccast list --label trial-7 --columns job,curl,changes
  dccast list --json | jq -r '.[] | select(.findings | length > 0) | .id'

JOB is the beginning of an id that no other job listed has; every command takes it.)";

struct WaitOptions {
  std::vector<std::string> ids;
  std::string notify;
  bool json = false;
};

/// Waits for one job. @return how it ended
v1::Job ended_job(Connection& connection, const std::string& id) {
  v1::Job job = connection.call(&Stub::GetJob, id);
  if (job.has_end_time()) return job;
  if (job.state() == v1::PAUSED)
    std::cerr << "waiting for job " << id << ", which is paused: dccast resume " << id << '\n';
  if (!job.held().empty()) std::cerr << "held: " << job.held() << '\n';
  follow_job(
      connection, id, 1, [](const v1::JobEvent&) {}, std::cerr);
  return connection.call(&Stub::GetJob, id);
}

/// Runs the user's command for a job that has ended, with the facts about the job in its
/// environment.
void notify(const std::string& command, const v1::Job& job) {
  run_user_command(command, {{"DCCAST_JOB", job.id()},
                             {"DCCAST_TITLE", job.title()},
                             {"DCCAST_STATE", state_text(job.state())}});
}

ExitCode run(const WaitOptions& options, Program& program) {
  Connection connection = program.connect();
  return wait_for_jobs(connection, resolve_jobs(connection, options.ids), options.notify,
                       options.json);
}

/// Options that say which jobs a command is about.
void add_selection(const Command& command, JobSelection& selection) {
  command.option("JOB", selection.jobs, job_help);
  command.repeatable("--label", selection.labels,
                     "In place of JOBs: your own jobs with this label; repeatable",
                     {.comma_separated = true});
}

/// Acts on each job, also after one that refused, whose reason is printed.
/// @return the exit code of the first refusal
ExitCode for_each_job(const std::vector<std::string>& ids,
                      const std::function<void(const std::string& id)>& act) {
  if (ids.empty()) std::cerr << "no jobs\n";
  ExitCode code = ExitCode::done;
  for (const std::string& id : ids) try {
      act(id);
    } catch (const Interrupted&) {
      throw;
    } catch (const CommandFailed& failure) {
      if (ids.size() == 1) throw;
      std::cerr << "dccast: " << failure.what() << '\n';
      if (code == ExitCode::done) code = failure.code();
    }
  return code;
}

const std::vector<v1::JobState> unfinished{v1::QUEUED, v1::RUNNING, v1::PAUSED};
const std::vector<v1::JobState> ended{v1::SUCCEEDED, v1::FAILED, v1::CANCELLED};

struct DeleteOptions {
  JobSelection selection;
  bool cancel = false;
  bool json = false;
};

/// A job that is being cancelled can be deleted only after its worker has ended.
void delete_job(Connection& connection, const std::string& id) {
  constexpr std::chrono::milliseconds pause{200};
  constexpr std::chrono::seconds longest{120};  // a worker that does not end is killed before
  const auto end = std::chrono::steady_clock::now() + longest;
  v1::DeleteJobRequest request;
  request.set_id(id);
  for (;;) {
    v1::DeleteJobResponse response;
    const grpc::Status status = connection.try_once(&Stub::DeleteJob, request, response);
    const bool again = status.error_code() == grpc::StatusCode::ABORTED;
    if (!again || std::chrono::steady_clock::now() > end) return check(status, connection.server());
    connection.interruption().sleep(pause);
  }
}

ExitCode run(const DeleteOptions& options, Program& program) {
  Connection connection = program.connect();
  const auto states = options.cancel ? std::vector<v1::JobState>{} : ended;
  const auto ids = selected_jobs(connection, options.selection, states);
  return for_each_job(ids, [&](const std::string& id) {
    if (options.cancel) connection.call(&Stub::CancelJob, id);
    delete_job(connection, id);
    if (options.json)
      std::cout << Json{{"id", id}, {"deleted", true}}.dump() << std::endl;
    else
      std::cerr << "deleted " << id << '\n';
  });
}

/// What is special about a command on jobs, with its help texts.
struct JobCommand {
  const char* name;
  const char* description;
  const char* example;
  std::vector<v1::JobState> states{};            ///< of the jobs that --label selects; empty: all
  bool repeatable = true;                        ///< a repeated call has the same result
  v1::JobState aim = v1::JOB_STATE_UNSPECIFIED;  ///< that a running job reaches a little later
};

/// Waits until the job has the requested state or has ended. A worker checks for requests after
/// every step; after the longest wait the job is returned in its present state.
v1::Job reached(Connection& connection, v1::Job job, v1::JobState aim) {
  constexpr std::chrono::milliseconds pause{100};
  constexpr std::chrono::seconds longest{30};
  const auto end = std::chrono::steady_clock::now() + longest;
  while (job.state() != aim && !job.has_end_time()) {
    if (std::chrono::steady_clock::now() > end) {
      std::cerr << "job " << job.id() << " is still " << state_text(job.state()) << "; it becomes "
                << state_text(aim) << " after its present step\n";
      break;
    }
    // Polled, since a worker reacts within a step and most steps take less than a second.
    connection.interruption().sleep(pause);
    job = connection.call(&Stub::GetJob, job.id());
  }
  return job;
}

/// "0f2b9a4e-... paused": output of commands that change a job.
std::string new_state(const v1::Job& job) {
  return job.id() + " " + state_text(job.state()) + "\n";
}

/// Adds a command that makes the same call about each of its jobs and prints them. The request
/// holds the options that the caller adds to the returned command.
/// @param text      formats a job as text; --json prints all of it
/// @param complete  sets what an option cannot write into the request itself
/// @param declare   adds positional arguments before JOB
template <typename Request>
Command add_job_command(CommandLine& line, Program& program, const JobCommand& about,
                        Method<Request, v1::Job> method, std::shared_ptr<Request> request,
                        std::string (*text)(const v1::Job&) = new_state,
                        std::function<void(Request&)> complete = nullptr,
                        const std::function<void(const Command&)>& declare = nullptr) {
  const Command command = line.command(about.name, about.description, about.example);

  const auto selection = std::make_shared<JobSelection>();
  const auto json = std::make_shared<bool>(false);
  if (declare) declare(command);
  add_selection(command, *selection);
  command.json(*json, "Each job as JSON on a line");

  command.action([=, &program] {
    if (complete) complete(*request);
    Connection connection = program.connect();

    // All are asked before the first one is waited for.
    std::vector<v1::Job> jobs;
    const auto ids = selected_jobs(connection, *selection, about.states);
    const ExitCode code = for_each_job(ids, [&](const std::string& id) {
      request->set_id(id);
      // A call that acts must not be sent twice when its answer is lost.
      jobs.push_back(about.repeatable ? connection.call(method, *request)
                                      : connection.call_once(method, *request));
    });

    for (v1::Job& job : jobs) {
      if (about.aim != v1::JOB_STATE_UNSPECIFIED)
        job = reached(connection, std::move(job), about.aim);
      std::cout << (*json ? to_json(job).dump() + "\n" : text(job)) << std::flush;
    }
    return code;
  });
  return command;
}

struct ShowOptions {
  std::string id;
  bool json = false;
};

ExitCode run(const ShowOptions& options, Program& program) {
  Connection connection = program.connect();
  const v1::Job job = connection.call(&Stub::GetJob, resolve_job(connection, options.id));
  if (options.json) {
    print_line(to_json(job));
    return ExitCode::done;
  }

  std::cout << job_sheet(job);
  if (job.has_last_step()) {
    std::cout << '\n';
    print_judgement(connection, run_of_job(job.id()), std::cout);
  }
  return ExitCode::done;
}

/// "0f2b9a4e-... line=3 (pinned)": output of commands that mark a job.
std::string marks_of(const v1::Job& job) {
  std::string text = job.id();
  for (const std::string& label : job.labels()) text += " " + label;
  return text + (job.pinned() ? " (pinned)\n" : "\n");
}

void add_pin_command(CommandLine& line, Program& program, const JobCommand& about, bool pinned) {
  const auto request = std::make_shared<v1::UpdateJobRequest>();
  request->set_pinned(pinned);
  add_job_command(line, program, about, &Stub::UpdateJob, request, marks_of);
}

}  // namespace

const std::map<std::string, int>& priorities() {
  static const std::map<std::string, int> names{
      {"low", v1::LOW}, {"normal", v1::NORMAL}, {"high", v1::HIGH}};
  return names;
}

ExitCode wait_for_jobs(Connection& connection, const std::vector<std::string>& ids,
                       const std::string& command, bool json) {
  ExitCode code = ExitCode::done;
  for (const std::string& id : ids) {
    const v1::Job job = ended_job(connection, id);
    std::cout << (json ? to_json(job).dump() : job.id() + " " + full_state_text(job)) << std::endl;
    if (!command.empty()) notify(command, job);
    if (job.state() != v1::SUCCEEDED) code = exit_code_of(job.state());
  }
  return code;
}

void add_list(CommandLine& line, Program& program) {
  const auto [command, options] =
      declare<ListOptions>(line, program, run, "list", "List jobs, newest first", list_examples);

  std::vector<std::string> names;
  for (const auto& [name, state] : state_names) names.push_back(name);

  command.option("-s,--state", options.states, "Only jobs in these states",
                 {.comma_separated = true, .one_of = names});
  command.repeatable("--label", options.labels, "Only jobs with this label; repeatable",
                     {.comma_separated = true});
  command.option("--owner", options.owner, "Only the jobs of this user");
  command.flag("--mine", options.mine, "Only your own jobs");
  command.option("--since", options.since,
                 "Only jobs submitted since: today, yesterday, \"3 h\", \"2 d\", 2026-11-20");
  command.option("--name", options.name, "Only jobs with this title; * and ? as in a shell");
  command.option("--study", options.study, "Only the jobs of this study");
  command.flag("--all", options.all, "Each run of a study too, below the line of its study");

  command.option("-c,--columns", options.columns, "Columns to show",
                 {.comma_separated = true, .one_of = job_columns()});
  command.number("-n,--limit", options.limit, 1, 1000000, "At most this many");
  command.flag("--ids", options.ids, "Print only complete ids, one per line");
  command.json(options.json);
}

void add_wait(CommandLine& line, Program& program) {
  const auto [command, options] = declare<WaitOptions>(
      line, program, run, "wait",
      "Wait until jobs have ended and print how; exit code 3 if one has not succeeded",
      "dccast wait last\n  dccast submit casts/*.toml | xargs dccast wait\n"
      "  dccast wait --notify 'mail -s \"$DCCAST_TITLE: $DCCAST_STATE\" anna </dev/null' JOB");
  command.option("JOB", options.ids, job_help, required);
  command.option(
      "--notify", options.notify,
      "Run this for each job that has ended, in a shell, with DCCAST_JOB, DCCAST_TITLE and "
      "DCCAST_STATE in its environment",
      {.placeholder = "COMMAND"});
  command.json(options.json, "Each job as JSON on a line");
}

void add_delete(CommandLine& line, Program& program) {
  const auto [command, options] = declare<DeleteOptions>(
      line, program, run, "delete",
      "Delete ended jobs and their files; waits for a job that is being cancelled",
      "dccast delete JOB\n  dccast delete --cancel JOB JOB\n  dccast delete --label trial-7");
  add_selection(command, options.selection);
  command.flag("--cancel", options.cancel, "Cancel jobs that have not ended first");
  command.json(options.json, "As JSON, one a line");
}

void add_label(CommandLine& line, Program& program) {
  struct LabelOptions {
    std::vector<std::string> add, remove;
  };
  const auto options = std::make_shared<LabelOptions>();
  const Command command = add_job_command<v1::UpdateJobRequest>(
      line, program,
      {"label", "Change labels of your jobs: key=value replaces the label with that key",
       "dccast label JOB --add line=3 --add checked\n  dccast label --label trial-7 --remove line"},
      &Stub::UpdateJob, std::make_shared<v1::UpdateJobRequest>(), marks_of,
      // Lists of an option cannot be the repeated fields of a message.
      [options](v1::UpdateJobRequest& request) {
        request.mutable_set_labels()->Assign(options->add.begin(), options->add.end());
        request.mutable_remove_labels()->Assign(options->remove.begin(), options->remove.end());
      });
  command.repeatable("--add", options->add, "Labels to be added; repeatable",
                     {.comma_separated = true, .placeholder = "LABEL"});
  command.repeatable("--remove", options->remove,
                     "Labels, or keys of labels, to be removed; repeatable",
                     {.comma_separated = true, .placeholder = "LABEL"});
}

void add_priority(CommandLine& line, Program& program) {
  const auto priority = std::make_shared<int>();
  add_job_command<v1::UpdateJobRequest>(
      line, program,
      {"priority",
       "Change the place of waiting jobs in the queue",
       "dccast priority high JOB\n  dccast priority low --label trial-7",
       {v1::QUEUED, v1::PAUSED}},
      &Stub::UpdateJob, std::make_shared<v1::UpdateJobRequest>(), new_state,
      [priority](v1::UpdateJobRequest& request) {
        request.set_priority(static_cast<v1::Priority>(*priority));
      },
      [priority](const Command& command) {
        command.choice("PRIORITY", *priority, priorities(), "low, normal or high", required);
      });
}

void add_pin(CommandLine& line, Program& program) {
  add_pin_command(line, program,
                  {"pin", "Keep jobs when the server deletes old ones", "dccast pin JOB"}, true);
}

void add_unpin(CommandLine& line, Program& program) {
  add_pin_command(line, program, {"unpin", "Undo pin", "dccast unpin JOB"}, false);
}

void add_show(CommandLine& line, Program& program) {
  const auto [command, options] = declare<ShowOptions>(
      line, program, run, "show", "Everything about one job, and what follows from its run so far",
      "dccast show JOB");
  command.option("JOB", options.id, job_help, required);
  command.json(options.json);
}

void add_cancel(CommandLine& line, Program& program) {
  const auto request = std::make_shared<v1::CancelJobRequest>();
  const Command command = add_job_command(
      line, program,
      {"cancel", "Stop jobs permanently; a job that has ended is not changed",
       "dccast cancel JOB --reason \"wrong alloy\"\n  dccast cancel --label trial-7", unfinished,
       true, v1::CANCELLED},
      &Stub::CancelJob, request);
  command.option(
      "--reason", *request->mutable_reason(), "Kept with the job",
      {.fault = [](const std::string& text) { return values::too_long("the reason", text); }});
}

void add_pause(CommandLine& line, Program& program) {
  add_job_command(line, program,
                  {"pause",
                   "Stop jobs at a checkpoint and keep them out of the queue",
                   "dccast pause JOB\n  dccast pause --label trial-7",
                   {v1::QUEUED, v1::RUNNING},
                   true,
                   v1::PAUSED},
                  &Stub::PauseJob, std::make_shared<v1::PauseJobRequest>());
}

void add_resume(CommandLine& line, Program& program) {
  add_job_command(line, program,
                  {"resume",
                   "Put paused jobs back into the queue",
                   "dccast resume JOB\n  dccast resume --label trial-7",
                   {v1::PAUSED},
                   false},
                  &Stub::ResumeJob, std::make_shared<v1::ResumeJobRequest>());
}

}  // namespace dccast::client
