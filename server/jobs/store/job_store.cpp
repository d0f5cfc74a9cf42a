#include "server/jobs/store/job_store.hpp"

#include <fmt/ranges.h>
#include <sqlite3.h>

#include <utility>

namespace dccast::jobs {

namespace {

constexpr std::int64_t this_version = 10;

// The columns are those that queries filter by, and the job itself. Times are milliseconds since
// 1970, states are numbers of job.proto. Labels are stored one a line, each between two line ends.
constexpr const char* schema = R"sql(
CREATE TABLE job (
  id TEXT PRIMARY KEY,
  request_id TEXT UNIQUE,
  study TEXT NOT NULL,
  owner TEXT NOT NULL,
  title TEXT NOT NULL,
  labels TEXT NOT NULL,
  pinned INTEGER NOT NULL,
  state INTEGER NOT NULL,
  created_ms INTEGER NOT NULL,
  ended_ms INTEGER NOT NULL,
  bytes INTEGER NOT NULL,
  answer_key TEXT NOT NULL,
  solver TEXT NOT NULL,
  sequence INTEGER NOT NULL,
  losses BLOB NOT NULL,
  job BLOB NOT NULL
) STRICT;
CREATE INDEX job_by_age ON job (created_ms, id);
CREATE INDEX job_by_state ON job (state);
CREATE INDEX job_by_study ON job (study) WHERE study <> '';
CREATE INDEX job_by_answer ON job (answer_key, solver) WHERE answer_key <> '';
)sql";

constexpr const char* insert_row =
    "INSERT INTO job (id, request_id, study, owner, title, labels, pinned, state, created_ms, "
    "ended_ms, bytes, answer_key, solver, sequence, losses, job) "
    "VALUES (?, NULLIF(?, ''), ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?) ";

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
  database.execute(fmt::format("{} PRAGMA user_version = {}", schema, this_version).c_str());
  transaction.commit();
}

/// The labels of a job, one a line, each between two line ends, so that a whole label can be found.
std::string label_lines(const v1::Job& job) {
  std::string lines;
  for (const std::string& label : job.labels()) lines += (lines.empty() ? "\n" : "") + label + "\n";
  return lines;
}

constexpr const char* select_rows =
    "SELECT id, state, bytes, answer_key, solver, sequence, losses, job FROM job ";

/// @throws StoreError  the row is damaged
JobRecord read_record(const Statement& row) {
  JobRecord record;
  record.bytes = row.integer(2);
  record.answer_key = row.text(3);
  record.solver = row.text(4);
  record.sequence = row.integer(5);
  row.message(6, record.losses);
  row.message(7, record.job);

  if (record.job.id() != row.text(0) || record.job.state() != row.integer(1))
    throw StoreError(fmt::format("the row of job {} is damaged", record.job.id()), SQLITE_CORRUPT);
  return record;
}

}  // namespace

JobStore::JobStore(const std::filesystem::path& path) : writer_(path) {
  writer_.write([&](Database& database) {
    database.execute(
        "PRAGMA journal_mode = WAL; PRAGMA foreign_keys = ON; PRAGMA synchronous = NORMAL");
    require_schema(database, path);
  });
  reader_.emplace(path);
}

template <typename... Values>
int JobStore::write(std::string_view sql, const Values&... values) {
  return writer_.write([&](Database& database) {
    Statement(database, sql, values...).step();
    return database.changes();
  });
}

int JobStore::write_row(const JobRecord& record, const std::string& on_conflict) {
  const v1::Job& job = record.job;
  return write(insert_row + on_conflict, job.id(), job.request_id(), job.study(), job.owner(),
               job.title(), label_lines(job), job.pinned(), job.state(),
               milliseconds(job.create_time()), milliseconds(job.end_time()), record.bytes,
               record.answer_key, record.solver, record.sequence, record.losses, job);
}

template <typename Take, typename... Values>
void JobStore::read(std::string_view sql, const Take& take, const Values&... values) {
  reader_->read([&](Database& database) { database.read(sql, take, values...); });
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
      select_rows + where_and_order,
      [&](const Statement& row) { records.push_back(read_record(row)); }, values...);
  return records;
}

std::optional<JobRecord> JobStore::insert(const JobRecord& record) {
  const int added = write_row(record, "ON CONFLICT (request_id) DO NOTHING");
  return added > 0 ? std::nullopt : find_request(record.job.request_id());
}

void JobStore::put(const JobRecord& record) {
  write_row(record,
            "ON CONFLICT (id) DO UPDATE SET request_id = excluded.request_id, "
            "study = excluded.study, owner = excluded.owner, title = excluded.title, "
            "labels = excluded.labels, pinned = excluded.pinned, state = excluded.state, "
            "created_ms = excluded.created_ms, ended_ms = excluded.ended_ms, "
            "bytes = excluded.bytes, answer_key = excluded.answer_key, "
            "solver = excluded.solver, sequence = excluded.sequence, losses = excluded.losses, "
            "job = excluded.job");
}

void JobStore::erase(const std::string& id) {
  writer_.write([&](Database& database) {
    database.execute("PRAGMA synchronous = FULL");
    Statement(database, "DELETE FROM job WHERE id = ?", id).step();
    database.execute("PRAGMA synchronous = NORMAL");
  });
}

void JobStore::probe() {
  writer_.write([](Database& database) {
    database.execute(fmt::format("PRAGMA user_version = {}", this_version).c_str());
  });
}

std::string JobStore::first_fault() {
  std::string answer;
  writer_.read([&](Database& database) {
    database.read("PRAGMA integrity_check(1)", [&](const Statement& row) { answer = row.text(0); });
  });
  return answer == "ok" ? "" : answer;
}

void JobStore::copy_to(const std::filesystem::path& path) {
  writer_.read(
      [&](Database& database) { Statement(database, "VACUUM INTO ?", path.native()).step(); });
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

std::vector<JobStore::Ended> JobStore::ended() {
  std::vector<Ended> ended;
  read(
      "SELECT id, ended_ms, bytes, pinned FROM job WHERE state BETWEEN 4 AND 6 AND study = '' "
      "ORDER BY ended_ms, id",
      [&](const Statement& row) {
        ended.push_back({row.text(0), row.integer(1), row.integer(2), row.integer(3) != 0});
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
