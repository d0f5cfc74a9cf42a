// The tables are made by the schema steps of jobs/job_store.
#include "server/studies/study_store.hpp"

#include <algorithm>
#include <utility>

namespace dccast::studies {

namespace {

using jobs::Statement;
using jobs::Transaction;

constexpr const char* columns =
    "id, owner, created_ms, changed_ms, case_sha256, request FROM study ";
constexpr const char* run_columns = "number, attempt, job, outcome, failure FROM study_run ";

StudyRecord record_of(const Statement& row) {
  StudyRecord record;
  record.id = row.text(0);
  record.owner = row.text(1);
  record.created_ms = row.integer(2);
  record.changed_ms = row.integer(3);
  record.case_sha256 = row.text(4);
  record.request.ParseFromString(row.text(5));
  return record;
}

RunRecord run_of(const Statement& row) {
  RunRecord run;
  run.number = static_cast<int>(row.integer(0));
  run.attempt = static_cast<int>(row.integer(1));
  run.job = row.text(2);
  run.outcome = static_cast<v1::JobState>(row.integer(3));
  run.failure.ParseFromString(row.text(4));
  return run;
}

}  // namespace

int RunCounts::of(v1::JobState state) const {
  const auto found = by_state.find(state);
  return found == by_state.end() ? 0 : found->second;
}

int RunCounts::all() const {
  int sum = 0;
  for (const auto& [state, count] : by_state) sum += count;
  return sum;
}

int RunCounts::ended() const {
  return of(v1::SUCCEEDED) + of(v1::FAILED) + of(v1::CANCELLED);
}

StudyStore::StudyStore(const std::filesystem::path& path) : database_(path) {
  database_.execute(
      "PRAGMA busy_timeout = 10000; PRAGMA journal_mode = WAL; PRAGMA foreign_keys = ON; "
      "PRAGMA synchronous = FULL");
}

bool StudyStore::insert(const StudyRecord& record, const std::vector<RunRecord>& runs) {
  const std::lock_guard lock(mutex_);
  Transaction transaction(database_);
  {
    Statement statement(database_,
                        "INSERT OR IGNORE INTO study (id, request_id, owner, created_ms, "
                        "changed_ms, removing, case_sha256, request) "
                        "VALUES (?, ?, ?, ?, ?, 0, ?, ?)");
    statement.bind(record.id);
    if (record.request.request_id().empty())
      statement.bind_null();
    else
      statement.bind(record.request.request_id());
    statement.bind(record.owner)
        .bind(record.created_ms)
        .bind(record.changed_ms)
        .bind(record.case_sha256)
        .bind_blob(record.request.SerializeAsString())
        .step();
    if (database_.changes() == 0) return false;
  }
  for (const RunRecord& run : runs) insert_run(record.id, run);
  transaction.commit();
  return true;
}

void StudyStore::insert_run(const std::string& id, const RunRecord& run) {
  Statement statement(database_,
                      "INSERT INTO study_run (study, number, attempt, job, outcome, failure) "
                      "VALUES (?, ?, ?, ?, ?, ?)");
  statement.bind(id)
      .bind(run.number)
      .bind(run.attempt)
      .bind(run.job)
      .bind(run.outcome)
      .bind_blob(run.failure.SerializeAsString())
      .step();
}

void StudyStore::extend(const StudyRecord& record, const std::vector<RunRecord>& more) {
  const std::lock_guard lock(mutex_);
  Transaction transaction(database_);
  {
    Statement statement(database_, "UPDATE study SET request = ? WHERE id = ?");
    statement.bind_blob(record.request.SerializeAsString()).bind(record.id).step();
  }
  for (const RunRecord& run : more) insert_run(record.id, run);
  transaction.commit();
}

void StudyStore::begin_removal(const std::string& id) {
  const std::lock_guard lock(mutex_);
  Statement statement(database_, "UPDATE study SET removing = 1 WHERE id = ?");
  statement.bind(id).step();
}

void StudyStore::erase(const std::string& id) {
  const std::lock_guard lock(mutex_);
  Statement statement(database_, "DELETE FROM study WHERE id = ?");
  statement.bind(id).step();
}

std::vector<StudyRecord> StudyStore::select(const std::string& where_and_order,
                                            const std::string& argument) {
  const std::lock_guard lock(mutex_);
  Statement statement(database_, std::string("SELECT ") + columns + where_and_order);
  statement.bind(argument);
  std::vector<StudyRecord> records;
  while (statement.step()) records.push_back(record_of(statement));
  return records;
}

std::optional<StudyRecord> StudyStore::find(const std::string& id) {
  auto found = select("WHERE id = ? AND removing = 0", id);
  if (found.empty()) return std::nullopt;
  return std::move(found.front());
}

std::optional<StudyRecord> StudyStore::find_request(const std::string& request_id) {
  auto found = select("WHERE request_id = ?", request_id);
  if (found.empty()) return std::nullopt;
  return std::move(found.front());
}

std::vector<std::string> StudyStore::select_ids(const std::string& sql) {
  const std::lock_guard lock(mutex_);
  Statement statement(database_, sql);
  std::vector<std::string> ids;
  while (statement.step()) ids.push_back(statement.text(0));
  return ids;
}

std::vector<std::string> StudyStore::ids() {
  return select_ids("SELECT id FROM study WHERE removing = 0");
}

std::vector<std::string> StudyStore::removing() {
  return select_ids("SELECT id FROM study WHERE removing = 1");
}

std::vector<StudyRecord> StudyStore::list(const Page& page) {
  const std::lock_guard lock(mutex_);
  Statement statement(database_,
                      std::string("SELECT ") + columns +
                          "WHERE removing = 0 AND (created_ms < ? OR (created_ms = ? AND id < ?)) "
                          "AND (? = '' OR owner = ?) "
                          "ORDER BY created_ms DESC, id DESC LIMIT ?");
  statement.bind(page.before_ms).bind(page.before_ms).bind(page.before_id);
  statement.bind(page.owner).bind(page.owner).bind(page.size);
  std::vector<StudyRecord> records;
  while (statement.step()) records.push_back(record_of(statement));
  return records;
}

RunCounts StudyStore::counts(const std::string& id) {
  const std::lock_guard lock(mutex_);
  // A run without a job is QUEUED until it has an outcome. A job that was deleted has no state.
  Statement statement(
      database_,
      "SELECT CASE WHEN run.job <> '' THEN job.state WHEN run.outcome = 0 THEN 1 "
      "ELSE run.outcome END AS run_state, COUNT(*), MAX(COALESCE(job.ended_ms, 0)), "
      "SUM(run.job <> '') FROM study_run AS run LEFT JOIN job ON job.id = run.job "
      "WHERE run.study = ? GROUP BY 1 HAVING run_state IS NOT NULL");
  statement.bind(id);
  RunCounts counts;
  while (statement.step()) {
    const auto state = static_cast<v1::JobState>(statement.integer(0));
    counts.by_state[state] = static_cast<int>(statement.integer(1));
    counts.last_end_ms = std::max(counts.last_end_ms, statement.integer(2));
    if (state == v1::QUEUED) counts.waiting = static_cast<int>(statement.integer(3));
  }
  return counts;
}

std::vector<RunRecord> StudyStore::select_runs(const std::string& id,
                                               const std::string& where_and_order) {
  const std::lock_guard lock(mutex_);
  Statement statement(database_, std::string("SELECT ") + run_columns + where_and_order);
  statement.bind(id);
  std::vector<RunRecord> runs;
  while (statement.step()) runs.push_back(run_of(statement));
  return runs;
}

std::vector<RunRecord> StudyStore::runs(const std::string& id) {
  return select_runs(id, "WHERE study = ? ORDER BY number");
}

std::vector<std::string> StudyStore::to_feed() {
  return select_ids(
      "SELECT id FROM study WHERE removing = 0 AND EXISTS (SELECT 1 FROM study_run WHERE "
      "study = study.id AND job = '' AND outcome = 0) ORDER BY created_ms, id");
}

std::optional<RunRecord> StudyStore::next_to_queue(const std::string& id) {
  auto found =
      select_runs(id, "WHERE study = ? AND job = '' AND outcome = 0 ORDER BY number LIMIT 1");
  if (found.empty()) return std::nullopt;
  return std::move(found.front());
}

bool StudyStore::set_job(const std::string& id, const RunRecord& run, bool followed) {
  const std::lock_guard lock(mutex_);
  Transaction transaction(database_);
  {
    Statement statement(database_,
                        "UPDATE study_run SET job = ?, attempt = ? "
                        "WHERE study = ? AND number = ? AND outcome = 0");
    statement.bind(run.job).bind(run.attempt).bind(id).bind(run.number).step();
  }
  const bool done = database_.changes() > 0;
  if (done && followed) {
    Statement statement(database_,
                        "INSERT OR IGNORE INTO study_run (study, number, attempt, job, outcome) "
                        "VALUES (?, ?, 0, '', 0)");
    statement.bind(id).bind(run.number + 1).step();
  }
  transaction.commit();
  return done;
}

void StudyStore::drop(const std::string& id, int number) {
  const std::lock_guard lock(mutex_);
  Statement statement(database_,
                      "DELETE FROM study_run "
                      "WHERE study = ? AND number = ? AND job = '' AND outcome = 0");
  statement.bind(id).bind(number).step();
}

void StudyStore::refuse(const std::string& id, int number, const v1::Failure& failure,
                        std::int64_t now_ms) {
  const std::lock_guard lock(mutex_);
  Transaction transaction(database_);
  {
    Statement statement(database_,
                        "UPDATE study_run SET outcome = ?, failure = ? "
                        "WHERE study = ? AND number = ? AND job = '' AND outcome = 0");
    statement.bind(v1::FAILED).bind_blob(failure.SerializeAsString()).bind(id).bind(number).step();
  }
  {
    Statement statement(database_, "UPDATE study SET changed_ms = ? WHERE id = ?");
    statement.bind(now_ms).bind(id).step();
  }
  transaction.commit();
}

void StudyStore::cancel_waiting(const std::string& id, std::int64_t now_ms) {
  const std::lock_guard lock(mutex_);
  Transaction transaction(database_);
  {
    Statement statement(database_,
                        "UPDATE study_run SET outcome = ? "
                        "WHERE study = ? AND job = '' AND outcome = 0");
    statement.bind(v1::CANCELLED).bind(id).step();
  }
  {
    Statement statement(database_, "UPDATE study SET changed_ms = ? WHERE id = ?");
    statement.bind(now_ms).bind(id).step();
  }
  transaction.commit();
}

void StudyStore::queue_again(const std::string& id, const std::vector<int>& numbers) {
  const std::lock_guard lock(mutex_);
  Transaction transaction(database_);
  for (const int number : numbers) {
    Statement statement(database_,
                        "UPDATE study_run SET job = '', outcome = 0, failure = NULL "
                        "WHERE study = ? AND number = ?");
    statement.bind(id).bind(number).step();
  }
  transaction.commit();
}

}  // namespace dccast::studies
