#include "server/jobs/job_rows.hpp"

#include "proto/values/printable.hpp"
#include "server/jobs/events.hpp"

namespace dccast::jobs {

namespace {

void set_time(std::int64_t milliseconds, google::protobuf::Timestamp* time) {
  *time = timestamp(milliseconds);
}

/// `outcome` holds a Job with only the last step, the artifacts, the loss of validity and the
/// findings set.
std::string outcome_of(const v1::Job& job) {
  v1::Job outcome;
  if (job.has_last_step()) *outcome.mutable_last_step() = job.last_step();
  *outcome.mutable_artifacts() = job.artifacts();
  if (job.has_validity_loss()) *outcome.mutable_validity_loss() = job.validity_loss();
  *outcome.mutable_findings() = job.findings();
  return outcome.SerializeAsString();
}

void read_labels(const std::string& lines, v1::Job& job) {
  for (std::size_t begin = 1; begin < lines.size();) {
    const std::size_t end = lines.find('\n', begin);
    job.add_labels(values::escaped(lines.substr(begin, end - begin)));
    begin = end + 1;
  }
}

}  // namespace

const std::string_view job_columns =
    "id, request_id, case_sha256, title, priority, state, created_ms, started_ms, ended_ms, "
    "attempts, failure, outcome, wish, wish_reason, losses, lost_step, first_loss, "
    "study, owner, bytes, labels, changes, answer_key, solver";

std::string label_lines(const v1::Job& job) {
  std::string lines;
  for (const std::string& label : job.labels()) lines += (lines.empty() ? "\n" : "") + label + "\n";
  return lines;
}

std::string changes_of(const v1::Job& job) {
  v1::Job changes;
  *changes.mutable_changes() = job.changes();
  return changes.SerializeAsString();
}

/// Texts of an earlier version may hold characters that are refused now, and go to terminals.
JobRecord read_row(const Statement& statement) {
  JobRecord record;
  v1::Job& job = record.job;
  job.ParseFromString(statement.text(11));
  job.MergeFromString(statement.text(21));
  job.set_id(statement.text(0));
  job.set_request_id(values::escaped(statement.text(1)));
  job.set_case_sha256(statement.text(2));
  job.set_title(values::escaped(statement.text(3)));
  job.set_priority(static_cast<v1::Priority>(statement.integer(4)));
  job.set_state(static_cast<v1::JobState>(statement.integer(5)));
  set_time(statement.integer(6), job.mutable_create_time());
  if (statement.integer(7) != 0) set_time(statement.integer(7), job.mutable_start_time());
  if (statement.integer(8) != 0) set_time(statement.integer(8), job.mutable_end_time());
  job.set_attempts(static_cast<int>(statement.integer(9)));
  if (const std::string failure = statement.text(10); !failure.empty())
    job.mutable_failure()->ParseFromString(failure);
  record.requested_action = static_cast<RequestedAction>(statement.integer(12));
  record.request_reason = values::escaped(statement.text(13));
  record.losses = static_cast<int>(statement.integer(14));
  record.lost_step = statement.integer(15);
  record.first_loss = statement.text(16);
  job.set_study(statement.text(17));
  job.set_owner(statement.text(18));
  record.bytes = statement.integer(19);
  read_labels(statement.text(20), job);
  record.answer_key = statement.text(22);
  record.solver = statement.text(23);
  return record;
}

void bind_changing(Statement& statement, const JobRecord& record) {
  const v1::Job& job = record.job;
  statement.bind(job.state())
      .bind(milliseconds(job.start_time()))
      .bind(milliseconds(job.end_time()))
      .bind(job.attempts());
  if (job.has_failure())
    statement.bind_blob(job.failure().SerializeAsString());
  else
    statement.bind_null();
  statement.bind_blob(outcome_of(job))
      .bind(static_cast<int>(record.requested_action))
      .bind(record.request_reason)
      .bind(record.losses)
      .bind(record.lost_step)
      .bind(record.first_loss)
      .bind(record.solver);
}

}  // namespace dccast::jobs
