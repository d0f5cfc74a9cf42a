#include "server/worker/run_job.hpp"

#include <algorithm>
#include <filesystem>
#include <new>
#include <system_error>
#include <utility>
#include <vector>

#include "core/case/case.hpp"
#include "core/casting/casting_run.hpp"
#include "core/casting/simulation.hpp"
#include "core/storage/storage_error.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/job_folder.hpp"
#include "server/jobs/worker_claim.hpp"
#include "server/translate/case_to_core.hpp"
#include "server/translate/to_proto.hpp"

namespace dccast::worker {

namespace {

/// Makes events of what the run reports, and brings it requests to stop.
class ReportingObserver : public casting::StepObserver {
public:
  ReportingObserver(RunLink& link, const casting::Case& of_run) : link_(link), case_(of_run) {}
  casting::Order on_step(const results::StepReport& report) override;
  std::vector<results::StepReport> reported_steps(std::int64_t step) override;
  void sync_reports() override { link_.sync(); }
  void on_resumed(std::int64_t step, double time) override;
  void on_validity_lost(const results::ValidityLoss& loss) override;
  void on_finding(const results::Finding& finding) override;
  void on_message(std::string_view text) override;

private:
  RunLink& link_;
  const casting::Case& case_;
};

casting::Order ReportingObserver::on_step(const results::StepReport& report) {
  v1::JobEvent event;
  *event.mutable_step() = translate::to_proto(report, case_.monitors);
  link_.send(std::move(event));
  return link_.order();
}

std::vector<results::StepReport> ReportingObserver::reported_steps(std::int64_t step) {
  std::vector<results::StepReport> reports;
  for (const v1::StepReport& each : link_.steps(static_cast<std::size_t>(step)))
    reports.push_back(translate::to_core(each, mesh::dimension_of(case_.section.kind)));
  return reports;
}

void ReportingObserver::on_resumed(std::int64_t step, double time) {
  v1::JobEvent event;
  event.mutable_resumed()->set_step(step);
  event.mutable_resumed()->set_time_s(time);
  link_.send(std::move(event));
}

void ReportingObserver::on_validity_lost(const results::ValidityLoss& loss) {
  v1::JobEvent event;
  *event.mutable_validity_lost() = translate::to_proto(loss);
  link_.send(std::move(event));
}

void ReportingObserver::on_finding(const results::Finding& finding) {
  v1::JobEvent event;
  *event.mutable_finding() = translate::to_proto(finding);
  link_.send(std::move(event));
}

void ReportingObserver::on_message(std::string_view text) {
  v1::JobEvent event;
  event.mutable_message()->set_level(v1::JobEvent::Message::INFO);
  event.mutable_message()->set_text(std::string(text));
  link_.send(std::move(event));
}

}  // namespace

namespace {

namespace fs = std::filesystem;
using Finished = v1::RunEnd;

Finished failed(v1::Failure::Kind kind, const std::string& message) {
  Finished finished;
  finished.set_outcome(Finished::FAILED);
  finished.mutable_failure()->set_kind(kind);
  finished.mutable_failure()->set_message(message);
  return finished;
}

/// What the run left, with sizes and checksums: computed once, here, while the files are still in
/// the page cache and the daemon has better things to do.
void add_artifacts(const fs::path& directory, Finished& finished) {
  for (const char* name : {"results.h5", "results.xdmf"}) {
    if (!fs::exists(directory / name)) continue;
    auto* artifact = finished.add_artifacts();
    artifact->set_name(name);
    artifact->set_size_bytes(static_cast<std::int64_t>(fs::file_size(directory / name)));
    artifact->set_sha256(values::sha256_of_file(directory / name));
  }
}

Finished::Outcome to_proto(casting::RunEnd end) {
  switch (end) {
    case casting::RunEnd::succeeded:
      return Finished::SUCCEEDED;
    case casting::RunEnd::failed:
      return Finished::FAILED;
    case casting::RunEnd::stopped:
      return Finished::STOPPED;
    case casting::RunEnd::cancelled:
      return Finished::CANCELLED;
    case casting::RunEnd::other_version:
      return Finished::OTHER_VERSION_FOUND;
  }
  return Finished::OUTCOME_UNSPECIFIED;
}

/// What keeps the artifacts from being read comes after what the run failed with.
void note_storage_failure(const std::system_error& error, Finished& finished) {
  if (finished.has_failure())
    finished.mutable_failure()->add_further_causes(std::string("STORAGE: ") + error.what());
  else
    finished = failed(v1::Failure::STORAGE, error.what());
}

Finished to_finished(const casting::RunOutcome& outcome, const v1::SolveCase& order) {
  Finished finished;
  finished.set_outcome(to_proto(outcome.end));
  if (!outcome.failures.empty())
    *finished.mutable_failure() = translate::to_proto(outcome.failures);
  const bool ended =
      outcome.end == casting::RunEnd::succeeded || outcome.end == casting::RunEnd::failed;
  if (!ended || order.job_id().empty()) return finished;
  try {
    add_artifacts(order.directory(), finished);
  } catch (const std::system_error& error) {
    note_storage_failure(error, finished);
  }
  return finished;
}

casting::OtherVersion to_core(v1::OtherVersion what) {
  if (what == v1::PAUSE) return casting::OtherVersion::wait;
  return what == v1::FAIL ? casting::OtherVersion::fail : casting::OtherVersion::begin_anew;
}

casting::RunDirectory directory_of(const v1::SolveCase& order) {
  return {.path = order.directory(),
          .resume = order.resume(),
          .other_version = to_core(order.other_version()),
          .leaves_run_files = true,
          .keeps_nothing = order.job_id().empty()};
}

Finished run(const v1::SolveCase& order, RunLink& link) {
  const fs::path directory = order.directory();
  const auto casting_case = translate::to_core(order.case_(), directory / jobs::attachments_folder);
  ReportingObserver observer(link, casting_case);
  const auto outcome =
      casting::run(casting_case, directory_of(order), observer, std::max(order.threads(), 1));
  return to_finished(outcome, order);
}

}  // namespace

Finished run_job(const v1::SolveCase& order, RunLink& link) {
  try {
    return run(order, link);
  } catch (const InvalidCase& error) {
    return failed(v1::Failure::INVALID_CASE, translate::in_words(error.faults()));
  } catch (const std::system_error& error) {
    if (storage::is_memory_fault(error.code()))
      return failed(v1::Failure::OUT_OF_MEMORY, jobs::out_of_memory_text);
    return failed(v1::Failure::STORAGE, error.what());
  } catch (const std::bad_alloc&) {
    return failed(v1::Failure::OUT_OF_MEMORY, jobs::out_of_memory_text);
  } catch (const std::exception& error) {
    return failed(v1::Failure::INTERNAL, error.what());
  }
}

}  // namespace dccast::worker
