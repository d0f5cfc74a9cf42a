#include "server/jobs/store/job_store.hpp"

#include <fmt/ranges.h>
#include <sqlite3.h>

#include <sstream>
#include <utility>

#include "server/jobs/log.hpp"

namespace dccast::jobs {

namespace {

constexpr std::int64_t this_version = 9;

// Columns of the tables, one a line. Times are milliseconds since 1970, states and priorities are
// numbers of job.proto, blobs are serialised messages of job.proto. Labels are stored one a line,
// each between two line ends. `changes` is a Job with the fields that have no column. The tables of
// studies belong to server/studies/study_store.
constexpr const char* job_columns = R"sql(
id TEXT PRIMARY KEY
request_id TEXT UNIQUE
case_sha256 TEXT NOT NULL
title TEXT NOT NULL
priority INTEGER NOT NULL
state INTEGER NOT NULL
created_ms INTEGER NOT NULL
started_ms INTEGER NOT NULL DEFAULT 0
ended_ms INTEGER NOT NULL DEFAULT 0
attempts INTEGER NOT NULL DEFAULT 0
failure BLOB
outcome BLOB
losses INTEGER NOT NULL DEFAULT 0
lost_step INTEGER NOT NULL DEFAULT -1
first_loss TEXT NOT NULL DEFAULT ''
study TEXT NOT NULL
owner TEXT NOT NULL
bytes INTEGER NOT NULL
labels TEXT NOT NULL
changes BLOB
answer_key TEXT NOT NULL
solver TEXT NOT NULL DEFAULT ''
)sql";

constexpr const char* study_columns = R"sql(
id TEXT PRIMARY KEY
request_id TEXT UNIQUE
owner TEXT NOT NULL
created_ms INTEGER NOT NULL
changed_ms INTEGER NOT NULL
removing INTEGER NOT NULL
case_sha256 TEXT NOT NULL
request BLOB NOT NULL
)sql";

constexpr const char* study_run_columns = R"sql(
study TEXT NOT NULL REFERENCES study (id) ON DELETE CASCADE
number INTEGER NOT NULL
attempt INTEGER NOT NULL
job TEXT NOT NULL
outcome INTEGER NOT NULL
failure BLOB
)sql";

constexpr const char* indexes = R"sql(
CREATE INDEX job_by_age ON job (created_ms, id);
CREATE INDEX job_by_state ON job (state);
CREATE INDEX job_by_study ON job (study) WHERE study <> '';
CREATE INDEX job_by_answer ON job (answer_key, solver) WHERE answer_key <> '';
CREATE INDEX study_by_age ON study (created_ms, id);
CREATE INDEX study_run_to_queue ON study_run (study, number) WHERE job = '' AND outcome = 0;
CREATE TABLE probe (id INTEGER PRIMARY KEY CHECK (id = 1), at_ms INTEGER NOT NULL) STRICT;
)sql";

/// The statement that creates a table. SQLite has no checksums, so a flipped bit in a row would go
/// unnoticed: each row holds a checksum of its columns, which `PRAGMA integrity_check` verifies.
/// @param table_constraint  "", or one that begins with a comma
std::string create_table(const std::string& name, const std::string& columns,
                         const std::string& table_constraint = "") {
  std::string definitions;
  std::string names;
  std::istringstream lines(columns);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty()) continue;
    definitions += line + ", ";
    names += (names.empty() ? "" : ", ") + line.substr(0, line.find(' '));
  }

  const std::string sum = fmt::format("sum_of({})", names);
  return fmt::format(
      "CREATE TABLE {} ({}sum INTEGER NOT NULL AS ({}) STORED CHECK (sum = {}){}) STRICT", name,
      definitions, sum, sum, table_constraint);
}

std::string schema() {
  const std::string study_run =
      create_table("study_run", study_run_columns, ", PRIMARY KEY (study, number)");
  return fmt::format("{};{};{}, WITHOUT ROWID;{}PRAGMA user_version = {}",
                     create_table("job", job_columns), create_table("study", study_columns),
                     study_run, indexes, this_version);
}

/// Creates the tables in an empty file. @throws StoreError  also for a store of another version,
/// which is rebuilt from the folders of the jobs
void require_schema(Database& database, const std::filesystem::path& path) {
  std::int64_t version = 0;
  database.read("PRAGMA user_version", [&](const Statement& row) { version = row.integer(0); });
  if (version == this_version) return;

  if (version != 0)
    throw StoreError(fmt::format("job store {} is of another version ({})", path.string(), version),
                     SQLITE_SCHEMA);

  Transaction transaction(database);
  database.execute(schema().c_str());
  transaction.commit();
}

/// The labels of a job, one a line, each between two line ends, so that a whole label can be found.
std::string label_lines(const v1::Job& job) {
  std::string lines;
  for (const std::string& label : job.labels()) lines += (lines.empty() ? "\n" : "") + label + "\n";
  return lines;
}

/// The content of the column `outcome`: the fields of a job that its run sets.
v1::Job select_outcome(const v1::Job& job) {
  v1::Job outcome;
  if (job.has_last_step()) *outcome.mutable_last_step() = job.last_step();
  *outcome.mutable_artifacts() = job.artifacts();
  if (job.has_validity_loss()) *outcome.mutable_validity_loss() = job.validity_loss();
  *outcome.mutable_findings() = job.findings();
  outcome.set_run_s(job.run_s());
  return outcome;
}

/// The content of the column `changes`: the other fields of a job that have no column.
v1::Job select_changes(const v1::Job& job) {
  v1::Job changes;
  *changes.mutable_changes() = job.changes();
  *changes.mutable_after() = job.after();
  changes.set_pinned(job.pinned());
  changes.set_time_limit_s(job.time_limit_s());
  changes.set_mail(job.mail());
  changes.set_quality(job.quality());
  changes.set_estimated_s(job.estimated_s());
  return changes;
}

/// Reads a row of the table `job`.
JobRecord read_record(const Statement& row) {
  JobRecord record;
  v1::Job& job = record.job;
  job.ParseFromString(row.text(11));
  job.MergeFromString(row.text(19));

  job.set_id(row.text(0));
  job.set_request_id(row.text(1));
  job.set_case_sha256(row.text(2));
  job.set_title(row.text(3));
  job.set_priority(static_cast<v1::Priority>(row.integer(4)));
  job.set_state(static_cast<v1::JobState>(row.integer(5)));

  *job.mutable_create_time() = timestamp(row.integer(6));
  if (row.integer(7) != 0) *job.mutable_start_time() = timestamp(row.integer(7));
  if (row.integer(8) != 0) *job.mutable_end_time() = timestamp(row.integer(8));
  job.set_attempts(static_cast<int>(row.integer(9)));
  if (const std::string failure = row.text(10); !failure.empty())
    job.mutable_failure()->ParseFromString(failure);

  record.losses = static_cast<int>(row.integer(12));
  record.lost_step = row.integer(13);
  record.first_loss = row.text(14);

  job.set_study(row.text(15));
  job.set_owner(row.text(16));
  record.bytes = row.integer(17);

  std::istringstream labels(row.text(18));
  for (std::string label; std::getline(labels, label);)
    if (!label.empty()) job.add_labels(label);

  record.answer_key = row.text(20);
  record.solver = row.text(21);

  return record;
}

}  // namespace

JobStore::JobStore(const std::filesystem::path& path) : database_(path) {
  database_.execute(
      "PRAGMA busy_timeout = 2000; PRAGMA journal_mode = WAL; PRAGMA foreign_keys = ON");
  require_schema(database_, path);
  reader_.emplace(path);
  reader_->execute("PRAGMA busy_timeout = 2000");
}

JobStore::Bulk::~Bulk() {
  store_.bulk_ = false;
  try {
    store_.probe();  // one durable commit makes all earlier ones durable
  } catch (const StoreError& error) {
    log::error("{}", error.what());
  }
}

template <typename... Values>
void JobStore::write(Durability durability, std::string_view sql, const Values&... values) {
  const std::lock_guard lock(mutex_);
  const char* synchronous = durability == Durability::full ? "FULL" : "NORMAL";
  if (bulk_) synchronous = "OFF";
  database_.execute(fmt::format("PRAGMA synchronous = {}", synchronous).c_str());
  Statement(database_, sql, values...).step();
}

template <typename Take, typename... Values>
void JobStore::read(std::string_view sql, const Take& take, const Values&... values) {
  const std::lock_guard lock(reading_);
  reader_->read(sql, take, values...);
}

template <typename... Values>
std::int64_t JobStore::number(std::string_view sql, const Values&... values) {
  std::int64_t number = 0;
  read(
      sql, [&](const Statement& row) { number = row.integer(0); }, values...);
  return number;
}

template <typename... Values>
std::vector<JobRecord> JobStore::select(const std::string& where_and_order,
                                        const Values&... values) {
  std::vector<JobRecord> records;
  read(
      "SELECT * FROM job " + where_and_order,
      [&](const Statement& row) { records.push_back(read_record(row)); }, values...);
  return records;
}

std::optional<JobRecord> JobStore::insert(const JobRecord& record) {
  const v1::Job& job = record.job;
  if (!job.request_id().empty())
    if (auto existing = find_request(job.request_id())) return existing;
  write(Durability::full,
        "INSERT INTO job (id, request_id, case_sha256, title, priority, state, created_ms, study, "
        "owner, bytes, labels, changes, answer_key) "
        "VALUES (?, NULLIF(?, ''), ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
        job.id(), job.request_id(), job.case_sha256(), job.title(), job.priority(), job.state(),
        milliseconds(job.create_time()), job.study(), job.owner(), record.bytes, label_lines(job),
        select_changes(job), record.answer_key);
  return std::nullopt;
}

void JobStore::update(const JobRecord& record, Durability durability) {
  const v1::Job& job = record.job;
  write(durability,
        "UPDATE job SET state = ?, started_ms = ?, ended_ms = ?, attempts = ?, "
        "failure = NULLIF(?, x''), outcome = ?, losses = ?, lost_step = ?, first_loss = ?, "
        "solver = ?, bytes = ? WHERE id = ?",
        job.state(), milliseconds(job.start_time()), milliseconds(job.end_time()), job.attempts(),
        job.failure(), select_outcome(job), record.losses, record.lost_step, record.first_loss,
        record.solver, record.bytes, job.id());
}

void JobStore::update_marks(const v1::Job& job) {
  write(Durability::full, "UPDATE job SET labels = ?, changes = ? WHERE id = ?", label_lines(job),
        select_changes(job), job.id());
}

void JobStore::update_bytes(const std::string& id, std::int64_t bytes) {
  write(Durability::normal, "UPDATE job SET bytes = ? WHERE id = ?", bytes, id);
}

void JobStore::erase(const std::string& id) {
  write(Durability::full, "DELETE FROM job WHERE id = ?", id);
}

void JobStore::probe() {
  write(Durability::full,
        "INSERT INTO probe (id, at_ms) VALUES (1, ?) "
        "ON CONFLICT (id) DO UPDATE SET at_ms = excluded.at_ms",
        milliseconds(now()));
}

std::string JobStore::first_fault() {
  const std::lock_guard lock(mutex_);
  std::string answer;
  database_.read("PRAGMA integrity_check(1)", [&](const Statement& row) { answer = row.text(0); });
  return answer == "ok" ? "" : answer;
}

void JobStore::copy_to(const std::filesystem::path& path) {
  const std::lock_guard lock(mutex_);
  Statement(database_, "VACUUM INTO ?", path.native()).step();
}

std::optional<JobRecord> JobStore::find(const std::string& id) {
  auto found = select("WHERE id = ?", id);
  return found.empty() ? std::nullopt : std::optional(std::move(found.front()));
}

std::optional<JobRecord> JobStore::find_request(const std::string& request_id) {
  auto found = select("WHERE request_id = ?", request_id);
  return found.empty() ? std::nullopt : std::optional(std::move(found.front()));
}

// States in SQL: 1 to 3 are QUEUED, RUNNING, PAUSED; 4 to 6 are SUCCEEDED, FAILED, CANCELLED.

std::vector<JobRecord> JobStore::unfinished() {
  return select("WHERE state BETWEEN 1 AND 3 ORDER BY created_ms, id");
}

std::int64_t JobStore::unfinished_bytes() {
  return number("SELECT COALESCE(SUM(bytes), 0) FROM job WHERE state BETWEEN 1 AND 3");
}

int JobStore::unfinished_of(const std::string& owner) {
  return static_cast<int>(
      number("SELECT COUNT(*) FROM job WHERE state BETWEEN 1 AND 3 AND owner = ?", owner));
}

std::int64_t JobStore::bytes_of(const std::string& owner) {
  return number("SELECT COALESCE(SUM(bytes), 0) FROM job WHERE owner = ?", owner);
}

int JobStore::count(v1::JobState state) {
  return static_cast<int>(number("SELECT COUNT(*) FROM job WHERE state = ?", state));
}

std::vector<JobStore::Group> JobStore::groups() {
  std::vector<Group> groups;
  read("SELECT owner, state, COUNT(*), SUM(bytes), MIN(created_ms) FROM job GROUP BY owner, state",
       [&](const Statement& row) {
         groups.push_back({row.text(0), static_cast<v1::JobState>(row.integer(1)), row.integer(2),
                           row.integer(3), row.integer(4)});
       });
  return groups;
}

std::vector<JobStore::Ended> JobStore::ended(Include include) {
  const char* condition = include == Include::jobs_alone ? " AND study = ''" : "";
  std::vector<Ended> ended;
  read(fmt::format("SELECT id, ended_ms, bytes, changes FROM job WHERE state BETWEEN 4 AND 6{} "
                   "ORDER BY ended_ms, id",
                   condition),
       [&](const Statement& row) {
         v1::Job changes;
         changes.ParseFromString(row.text(3));
         ended.push_back({row.text(0), row.integer(1), row.integer(2), changes.pinned()});
       });
  return ended;
}

std::set<std::string> JobStore::ids() {
  std::set<std::string> ids;
  read("SELECT id FROM job", [&](const Statement& row) { ids.insert(row.text(0)); });
  return ids;
}

std::optional<std::string> JobStore::find_answer(const std::string& answer_key,
                                                 const std::string& solver) {
  if (answer_key.empty() || solver.empty()) return std::nullopt;

  // The second condition on the key is implied; it lets SQLite use the index.
  std::optional<std::string> id;
  read(
      "SELECT id FROM job WHERE answer_key = ? AND answer_key <> '' AND solver = ? "
      "AND state = 4 ORDER BY created_ms DESC LIMIT 1",
      [&](const Statement& row) { id = row.text(0); }, answer_key, solver);
  return id;
}

std::vector<JobRecord> JobStore::list(const Page& page) {
  std::string sql = "WHERE (created_ms, id) < (?, ?)";
  std::vector<std::string> texts{page.before_id};
  const auto require = [&](const char* condition, const std::string& text) {
    sql += condition;
    texts.push_back(text);
  };

  if (!page.states.empty()) sql += fmt::format(" AND state IN ({:d})", fmt::join(page.states, ","));
  // The second condition is implied; it lets SQLite use the index of the jobs that have a study.
  if (!page.study.empty()) require(" AND study = ? AND study <> ''", page.study);
  if (!page.owner.empty()) require(" AND owner = ?", page.owner);
  if (!page.id_prefix.empty()) {
    require(" AND id >= ?", page.id_prefix);
    // '~' sorts after every character of an id: these are hexadecimal digits and '-'.
    require(" AND id < ?", page.id_prefix + "~");
  }
  if (page.since_ms > 0) sql += fmt::format(" AND created_ms >= {}", page.since_ms);
  if (!page.title.empty()) require(" AND title GLOB ?", page.title);
  for (const std::string& label : page.labels)
    require(" AND instr(labels, ?) > 0", fmt::format("\n{}\n", label));

  sql += fmt::format(" ORDER BY created_ms DESC, id DESC LIMIT {}", page.size);
  return select(sql, page.before_ms, texts);
}

}  // namespace dccast::jobs
