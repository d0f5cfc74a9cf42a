#pragma once

#include <iostream>
#include <memory>
#include <string>

#include "client/commands/commands.hpp"
#include "client/job_id.hpp"
#include "client/message_json.hpp"

namespace dccast::client::commands {

/// Help texts of a command about one job.
struct JobCommand {
  const char* name;
  const char* description;
  const char* example;
  bool repeatable = true;  ///< a repeated call has the same result
};

/// "0f2b9a4e-... paused", one line: the output of commands that change a job.
std::string new_state(const v1::Job& job);

/// Adds a subcommand that makes one call about one job and prints the job. The request holds the
/// options: JOB, and those that the caller adds to the returned subcommand.
/// @param text  formats the job as text; --json prints all of it
template <typename Request>
CLI::App* add_job_command(CLI::App& app, Program& program, const JobCommand& about,
                          grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&,
                                                       v1::Job*),
                          std::shared_ptr<Request> request,
                          std::string (*text)(const v1::Job&) = new_state) {
  CLI::App* const command = subcommand(app, about.name, about.description, about.example);
  const auto json = std::make_shared<bool>(false);
  command->add_option("JOB", *request->mutable_id(), job_help)->required();
  command->add_flag("--json", *json, "As JSON");
  command->callback([=, &program] {
    program.action = [=, &program] {
      Connection connection = program.connect();
      request->set_id(resolve_job(connection, request->id()));
      const v1::Job job = about.repeatable ? connection.call(method, *request)
                                           : connection.call_once(method, *request);
      std::cout << (*json ? to_json(job).dump() + "\n" : text(job));
      return ExitCode::done;
    };
  });
  return command;
}

}  // namespace dccast::client::commands
