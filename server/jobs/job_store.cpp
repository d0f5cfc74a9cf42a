#include "server/jobs/job_store.hpp"

#include <array>
#include <utility>

#include "server/jobs/events.hpp"

namespace dccast::jobs {

namespace {

// The schema as the steps that led to it: the one at index i makes version i + 1 out of version i,
// and is never changed again, as there are stores that took it. Version 0 is an empty file.
//
// Times are milliseconds since 1970, states and priorities the numbers of job.proto, the rest
// serialised messages of job.proto.
constexpr std::array schema_steps{
    R"sql(
CREATE TABLE job (
  id TEXT PRIMARY KEY,
  request_id TEXT UNIQUE,
  case_sha256 TEXT NOT NULL,
  title TEXT NOT NULL,
  priority INTEGER NOT NULL,
  state INTEGER NOT NULL,
  created_ms INTEGER NOT NULL,
  started_ms INTEGER NOT NULL,
  ended_ms INTEGER NOT NULL,
  attempts INTEGER NOT NULL,
  failure BLOB,
  outcome BLOB,
  wish INTEGER NOT NULL,
  wish_reason TEXT NOT NULL,
  losses INTEGER NOT NULL,
  lost_step INTEGER NOT NULL,
  first_loss TEXT NOT NULL,
  worker_process INTEGER NOT NULL,
  worker_start_ticks INTEGER NOT NULL
) STRICT;
CREATE INDEX job_by_age ON job (created_ms, id);
CREATE INDEX job_by_state ON job (state);
CREATE TABLE job_case (
  id TEXT PRIMARY KEY REFERENCES job (id) ON DELETE CASCADE,
  submitted BLOB NOT NULL,
  complete BLOB NOT NULL
) STRICT;
PRAGMA user_version = 1;
)sql",
    R"sql(
ALTER TABLE job ADD COLUMN study TEXT NOT NULL DEFAULT '';
CREATE INDEX job_by_study ON job (study) WHERE study <> '';
PRAGMA user_version = 2;
)sql",
    R"sql(
ALTER TABLE job ADD COLUMN owner TEXT NOT NULL DEFAULT '';
ALTER TABLE job ADD COLUMN bytes INTEGER NOT NULL DEFAULT 0;
ALTER TABLE job ADD COLUMN worker_handle TEXT NOT NULL DEFAULT '';
ALTER TABLE job DROP COLUMN worker_process;
ALTER TABLE job DROP COLUMN worker_start_ticks;
CREATE TABLE probe (id INTEGER PRIMARY KEY CHECK (id = 1), at_ms INTEGER NOT NULL) STRICT;
PRAGMA user_version = 3;
)sql",
    // Labels stand one a line, each between two line ends; `changes` is a Job with only these.
    R"sql(
ALTER TABLE job ADD COLUMN labels TEXT NOT NULL DEFAULT '';
ALTER TABLE job ADD COLUMN changes BLOB;
ALTER TABLE job ADD COLUMN answer_key TEXT NOT NULL DEFAULT '';
ALTER TABLE job ADD COLUMN solver TEXT NOT NULL DEFAULT '';
CREATE INDEX job_by_answer ON job (answer_key, solver) WHERE answer_key <> '';
PRAGMA user_version = 4;
)sql",
    // Studies, see server/studies/study_store: the request of each, and the job of each of its runs.
    R"sql(
CREATE TABLE study (
  id TEXT PRIMARY KEY,
  request_id TEXT UNIQUE,
  owner TEXT NOT NULL,
  created_ms INTEGER NOT NULL,
  changed_ms INTEGER NOT NULL,
  removing INTEGER NOT NULL,
  case_sha256 TEXT NOT NULL,
  request BLOB NOT NULL
) STRICT;
CREATE INDEX study_by_age ON study (created_ms, id);
CREATE TABLE study_run (
  study TEXT NOT NULL REFERENCES study (id) ON DELETE CASCADE,
  number INTEGER NOT NULL,
  attempt INTEGER NOT NULL,
  job TEXT NOT NULL,
  outcome INTEGER NOT NULL,
  failure BLOB,
  PRIMARY KEY (study, number)
) STRICT, WITHOUT ROWID;
CREATE INDEX study_run_to_queue ON study_run (study, number) WHERE job = '' AND outcome = 0;
PRAGMA user_version = 5;
)sql"};

constexpr std::string_view columns =
    "id, request_id, case_sha256, title, priority, state, created_ms, started_ms, ended_ms, "
    "attempts, failure, outcome, wish, wish_reason, losses, lost_step, first_loss, "
    "worker_handle, study, owner, bytes, labels, changes, answer_key, solver";

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

std::string label_lines(const v1::Job& job) {
  std::string lines;
  for (const std::string& label : job.labels()) lines += (lines.empty() ? "\n" : "") + label + "\n";
  return lines;
}

void read_labels(const std::string& lines, v1::Job& job) {
  for (std::size_t begin = 1; begin < lines.size();) {
    const std::size_t end = lines.find('\n', begin);
    job.add_labels(lines.substr(begin, end - begin));
    begin = end + 1;
  }
}

std::string changes_of(const v1::Job& job) {
  v1::Job changes;
  *changes.mutable_changes() = job.changes();
  return changes.SerializeAsString();
}

JobRecord row(const Statement& statement) {
  JobRecord record;
  v1::Job& job = record.job;
  job.ParseFromString(statement.text(11));
  job.MergeFromString(statement.text(22));
  job.set_id(statement.text(0));
  job.set_request_id(statement.text(1));
  job.set_case_sha256(statement.text(2));
  job.set_title(statement.text(3));
  job.set_priority(static_cast<v1::Priority>(statement.integer(4)));
  job.set_state(static_cast<v1::JobState>(statement.integer(5)));
  set_time(statement.integer(6), job.mutable_create_time());
  if (statement.integer(7) != 0) set_time(statement.integer(7), job.mutable_start_time());
  if (statement.integer(8) != 0) set_time(statement.integer(8), job.mutable_end_time());
  job.set_attempts(static_cast<int>(statement.integer(9)));
  if (const std::string failure = statement.text(10); !failure.empty())
    job.mutable_failure()->ParseFromString(failure);
  record.requested_action = static_cast<RequestedAction>(statement.integer(12));
  record.request_reason = statement.text(13);
  record.losses = static_cast<int>(statement.integer(14));
  record.lost_step = statement.integer(15);
  record.first_loss = statement.text(16);
  record.worker_handle = statement.text(17);
  job.set_study(statement.text(18));
  job.set_owner(statement.text(19));
  record.bytes = statement.integer(20);
  read_labels(statement.text(21), job);
  record.answer_key = statement.text(23);
  record.solver = statement.text(24);
  return record;
}

/// Binds the columns that change in a job's life, in the order of the UPDATE below.
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
      .bind(record.worker_handle)
      .bind(record.solver);
}

/// What a job of the page has to fulfil; its question marks are bound in list().
std::string condition_of(const JobStore::Page& page) {
  std::string sql = "(created_ms < ? OR (created_ms = ? AND id < ?))";
  if (!page.states.empty()) {
    sql += " AND state IN (";
    for (const v1::JobState state : page.states) sql += std::to_string(state) + ",";
    sql.back() = ')';
  }
  // The second condition is implied; it lets SQLite use the index of the jobs that have a study.
  if (!page.study.empty()) sql += " AND study = ? AND study <> ''";
  if (!page.owner.empty()) sql += " AND owner = ?";
  if (!page.id_prefix.empty()) sql += " AND id >= ? AND id < ?";
  for (std::size_t i = 0; i < page.labels.size(); ++i) sql += " AND instr(labels, ?) > 0";
  return sql;
}

}  // namespace

JobStore::JobStore(const std::filesystem::path& path) : database_(path) {
  database_.execute(
      "PRAGMA busy_timeout = 2000; PRAGMA journal_mode = WAL; PRAGMA foreign_keys = ON");
  bring_up_to_date(path);
}

void JobStore::bring_up_to_date(const std::filesystem::path& path) {
  std::int64_t version = 0;
  {
    Statement statement(database_, "PRAGMA user_version");
    statement.step();
    version = statement.integer(0);
  }
  constexpr auto newest = static_cast<std::int64_t>(schema_steps.size());
  if (version > newest)
    throw StoreError("job store " + path.string() + " was written by a later version of dccastd (" +
                         std::to_string(version) + "); use that one, or another data_directory",
                     0);
  if (version == newest) return;
  Transaction transaction(database_);
  for (std::int64_t step = version; step < newest; ++step)
    database_.execute(schema_steps[static_cast<std::size_t>(step)]);
  transaction.commit();
}

void JobStore::set_durability(Durability durability) {
  database_.execute(durability == Durability::full ? "PRAGMA synchronous = FULL"
                                                   : "PRAGMA synchronous = NORMAL");
}

std::optional<JobRecord> JobStore::insert(const JobRecord& record, std::string_view submitted_case,
                                          std::string_view complete_case) {
  const v1::Job& job = record.job;
  if (!job.request_id().empty())
    if (auto there = find_request(job.request_id())) return there;
  const std::lock_guard lock(mutex_);
  set_durability(Durability::full);
  Transaction transaction(database_);
  {
    Statement statement(database_,
                        "INSERT INTO job (" + std::string(columns) +
                            ") VALUES (?, ?, ?, ?, ?, ?, ?, 0, 0, 0, NULL, NULL, 0, '', 0, -1, '', "
                            "'', ?, ?, ?, ?, ?, ?, '')");
    statement.bind(job.id());
    if (job.request_id().empty())
      statement.bind_null();
    else
      statement.bind(job.request_id());
    statement.bind(job.case_sha256())
        .bind(job.title())
        .bind(job.priority())
        .bind(job.state())
        .bind(milliseconds(job.create_time()))
        .bind(job.study())
        .bind(job.owner())
        .bind(record.bytes)
        .bind(label_lines(job))
        .bind_blob(changes_of(job))
        .bind(record.answer_key)
        .step();
  }
  {
    Statement statement(database_,
                        "INSERT INTO job_case (id, submitted, complete) VALUES (?, ?, ?)");
    statement.bind(job.id()).bind_blob(submitted_case).bind_blob(complete_case).step();
  }
  transaction.commit();
  return std::nullopt;
}

void JobStore::update(const JobRecord& record, Durability durability) {
  const std::lock_guard lock(mutex_);
  set_durability(durability);
  Statement statement(database_,
                      "UPDATE job SET state = ?, started_ms = ?, ended_ms = ?, attempts = ?, "
                      "failure = ?, outcome = ?, wish = ?, wish_reason = ?, losses = ?, "
                      "lost_step = ?, first_loss = ?, worker_handle = ?, solver = ? WHERE id = ?");
  bind_changing(statement, record);
  statement.bind(record.job.id()).step();
}

bool JobStore::erase(const std::string& id) {
  const std::lock_guard lock(mutex_);
  set_durability(Durability::full);
  Statement statement(database_, "DELETE FROM job WHERE id = ?");
  statement.bind(id).step();
  return database_.changes() > 0;
}

std::vector<JobRecord> JobStore::select(std::string_view where_and_order,
                                        const std::string& argument) {
  const std::lock_guard lock(mutex_);
  Statement statement(
      database_, "SELECT " + std::string(columns) + " FROM job " + std::string(where_and_order));
  if (!argument.empty()) statement.bind(argument);
  std::vector<JobRecord> records;
  while (statement.step()) records.push_back(row(statement));
  return records;
}

std::optional<JobRecord> JobStore::find(const std::string& id) {
  auto found = select("WHERE id = ?", id);
  if (found.empty()) return std::nullopt;
  return std::move(found.front());
}

std::optional<JobRecord> JobStore::find_request(const std::string& request_id) {
  auto found = select("WHERE request_id = ?", request_id);
  if (found.empty()) return std::nullopt;
  return std::move(found.front());
}

std::optional<std::string> JobStore::complete_case(const std::string& id) {
  const std::lock_guard lock(mutex_);
  Statement statement(database_, "SELECT complete FROM job_case WHERE id = ?");
  if (!statement.bind(id).step()) return std::nullopt;
  return statement.text(0);
}

std::optional<std::string> JobStore::submitted_case(const std::string& id) {
  const std::lock_guard lock(mutex_);
  Statement statement(database_, "SELECT submitted FROM job_case WHERE id = ?");
  if (!statement.bind(id).step()) return std::nullopt;
  return statement.text(0);
}

std::string JobStore::first_fault() {
  const std::lock_guard lock(mutex_);
  Statement statement(database_, "PRAGMA integrity_check(1)");
  if (!statement.step()) return {};
  return statement.text(0) == "ok" ? "" : statement.text(0);
}

void JobStore::copy_to(const std::filesystem::path& path) {
  const std::lock_guard lock(mutex_);
  Statement statement(database_, "VACUUM INTO ?");
  statement.bind(path.native()).step();
}

std::vector<JobRecord> JobStore::unfinished() {
  // 1 to 3: QUEUED, RUNNING, PAUSED of job.proto.
  return select("WHERE state BETWEEN 1 AND 3 ORDER BY created_ms, id", "");
}

std::int64_t JobStore::unfinished_bytes() {
  const std::lock_guard lock(mutex_);
  Statement statement(database_,
                      "SELECT COALESCE(SUM(bytes), 0) FROM job WHERE state BETWEEN 1 AND 3");
  statement.step();
  return statement.integer(0);
}

void JobStore::probe() {
  const std::lock_guard lock(mutex_);
  set_durability(Durability::full);
  Statement statement(database_,
                      "INSERT INTO probe (id, at_ms) VALUES (1, ?) "
                      "ON CONFLICT (id) DO UPDATE SET at_ms = excluded.at_ms");
  statement.bind(milliseconds(now())).step();
}

int JobStore::count(v1::JobState state) {
  const std::lock_guard lock(mutex_);
  Statement statement(database_, "SELECT COUNT(*) FROM job WHERE state = ?");
  statement.bind(state).step();
  return static_cast<int>(statement.integer(0));
}

std::set<std::string> JobStore::ids() {
  const std::lock_guard lock(mutex_);
  Statement statement(database_, "SELECT id FROM job");
  std::set<std::string> ids;
  while (statement.step()) ids.insert(statement.text(0));
  return ids;
}

std::optional<std::string> JobStore::find_answer(const std::string& answer_key,
                                                 const std::string& solver) {
  if (answer_key.empty() || solver.empty()) return std::nullopt;
  const std::lock_guard lock(mutex_);
  // 4: SUCCEEDED of job.proto. The condition on the key lets SQLite use the index.
  Statement statement(database_,
                      "SELECT id FROM job WHERE answer_key = ? AND answer_key <> '' AND solver = ? "
                      "AND state = 4 ORDER BY created_ms DESC LIMIT 1");
  if (!statement.bind(answer_key).bind(solver).step()) return std::nullopt;
  return statement.text(0);
}

std::vector<JobRecord> JobStore::list(const Page& page) {
  const std::string sql = "SELECT " + std::string(columns) + " FROM job WHERE " +
                          condition_of(page) + " ORDER BY created_ms DESC, id DESC LIMIT ?";
  const std::lock_guard lock(mutex_);
  Statement statement(database_, sql);
  statement.bind(page.before_ms).bind(page.before_ms).bind(page.before_id);
  for (const std::string& wanted : {page.study, page.owner})
    if (!wanted.empty()) statement.bind(wanted);
  // Behind every character of an id: they are hexadecimal digits and '-'.
  if (!page.id_prefix.empty()) statement.bind(page.id_prefix).bind(page.id_prefix + "~");
  for (const std::string& label : page.labels) statement.bind("\n" + label + "\n");
  statement.bind(page.size);
  std::vector<JobRecord> records;
  while (statement.step()) records.push_back(row(statement));
  return records;
}

}  // namespace dccast::jobs
