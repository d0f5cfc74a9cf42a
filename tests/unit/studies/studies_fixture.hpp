#pragma once

#include <google/protobuf/util/delimited_message_util.h>

#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "server/studies/study_evaluation.hpp"
#include "server/studies/study_file.hpp"
#include "server/studies/study_requests.hpp"
#include "tests/unit/jobs/scheduler_fixture.hpp"

namespace dccast::studies {

/// The parts of Studies over a real queue. The test plays the workers of jobs, and a program stands
/// for the worker that checks cases.
class StudiesTest : public jobs::SchedulerTest {
protected:
  /// Checks a case: finds no fault in it, or what set_verdict() says.
  static constexpr const char* finds_no_fault = R"(#!/usr/bin/python3
import os, socket
link = socket.socket(fileno=0)
def read(size):
    data = b""
    while len(data) < size:
        more = link.recv(size - len(data))
        if not more: raise SystemExit
        data += more
    return data
while True:
    length = shift = 0
    while True:
        byte = read(1)[0]
        length |= (byte & 127) << shift
        shift += 7
        if byte < 128: break
    read(length)
    answer = b"\x02\x1a\x00"
    if os.path.exists(__file__ + ".answer"):
        answer = open(__file__ + ".answer", "rb").read()
    link.sendall(answer)
)";
  /// Ends at the first byte of a request.
  static constexpr const char* crashes = "#!/bin/sh\nhead -c 1 > /dev/null\nkill -ABRT $$\n";

  /// @param checker  program that checks cases
  explicit StudiesTest(const char* checker = finds_no_fault)
      : program_(written_program(folder_ / "checker", checker)) {}

  /// What the program finds in cases from now on.
  void set_verdict(const v1::ValidateCaseResponse& verdict) {
    v1::WorkerAnswer answer;
    *answer.mutable_verdict() = verdict;
    std::ofstream file(program_.string() + ".answer", std::ios::binary);
    google::protobuf::util::SerializeDelimitedToOstream(answer, &file);
  }

  static v1::Case sound_case(const std::string& title = "a casting") {
    v1::Case sound;
    sound.set_title(title);
    sound.mutable_section()->set_half_width_m(0.25);
    sound.mutable_section()->set_initial_depth_m(0.066);
    sound.mutable_time()->set_end_s(600.0);
    v1::Monitor& monitor = *sound.add_monitor();
    monitor.set_name("lip");
    monitor.set_x_m(0.25);
    monitor.set_y_m(0.0);
    return sound;
  }

  /// A Latin hypercube over the speed.
  static v1::CreateStudyRequest sweep(int runs, const std::string& request_id = "") {
    v1::CreateStudyRequest request;
    request.set_request_id(request_id);
    *request.mutable_case_() = sound_case();

    request.mutable_sweep()->set_design(v1::SweepPlan::LATIN_HYPERCUBE);
    request.mutable_sweep()->set_runs(runs);
    v1::SweepPlan::Axis& axis = *request.mutable_sweep()->add_axes();
    axis.set_key("schedule.casting_speed");
    axis.add_values("40 mm/min");
    axis.add_values("60 mm/min");
    return request;
  }
  static v1::CreateStudyRequest refinement(int levels, const std::string& request_id) {
    v1::CreateStudyRequest request;
    request.set_request_id(request_id);
    request.mutable_refinement()->set_levels(levels);
    return request;
  }

  std::string create(const v1::CreateStudyRequest& request) {
    return requests_.create(request, {}, owner).id();
  }
  v1::Study found(const std::string& id) { return requests_.find(id).value(); }
  std::vector<RunRecord> runs(const std::string& id) { return store_.runs(id); }

  /// Runs the next job that the queue starts to its end. @param steps  its history
  void run_next_job(const std::vector<v1::StepReport>& steps,
                    v1::RunEnd::Outcome outcome = v1::RunEnd::SUCCEEDED) {
    jobs::FakeWorker worker(queue_.executor.wait_for_launch(++launches_));
    for (const v1::StepReport& step : steps) {
      v1::JobEvent event;
      *event.mutable_step() = step;
      worker.append(event);
    }
    worker.end(outcome);
    queue_.executor.end(worker.launch(), "exit code 0", 0);
    const std::string id = worker.launch().job_id;
    ASSERT_TRUE(eventually([&] { return jobs::is_terminal(queue_.scheduler.find(id)->state()); }));
  }
  /// A step of a history. @param curl_m  of the monitor "lip"
  static v1::StepReport step(int number, double curl_m) {
    v1::StepReport step;
    step.set_step(number);
    step.set_time_s(10.0 * number);
    step.set_cast_length_m(0.01 * number);
    v1::MonitorValue& monitor = *step.add_monitors();
    monitor.set_name("lip");
    monitor.set_curl_m(curl_m);
    return step;
  }

private:
  static std::filesystem::path created(const std::filesystem::path& directory) {
    std::filesystem::create_directories(directory);
    return directory;
  }
  static std::filesystem::path written_program(const std::filesystem::path& path,
                                               const char* text) {
    std::ofstream(path) << text;
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
    return path;
  }

  const std::filesystem::path program_;
  std::size_t launches_ = 0;

protected:
  static inline const std::string owner = "someone";

  const StudyOptions options_{.directory = created(folder_.path() / "studies"),
                              .jobs_directory = created(folder_.path() / "jobs")};
  jobs::Daemon queue_{options_.jobs_directory};
  StudyStore store_{options_.jobs_directory / "jobs.sqlite"};
  jobs::WarmWorkers workers_{program_};
  const intake::CaseIntake intake_{workers_,
                                   "",
                                   created(folder_.path() / "check"),
                                   {.nodes = 1'000'000, .steps = 1'000'000, .memory_bytes = 1e12}};
  StudiesState state_{options_, store_, queue_.scheduler, intake_};
  RunResults results_{state_};
  SweepSurfaces surfaces_{state_, results_};
  StudyFeeder feeder_{state_, results_};
  StudyRequests requests_{state_, feeder_, results_, surfaces_};
  StudyEvaluation evaluation_{state_, results_, surfaces_};
};

}  // namespace dccast::studies
