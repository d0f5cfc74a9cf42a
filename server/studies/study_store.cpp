#include "server/studies/study_store.hpp"

#include <algorithm>
#include <utility>

namespace dccast::studies {

namespace {

using jobs::Database;
using jobs::Statement;
using jobs::Transaction;

/// @param values  in the order of the question marks
template <class... Values>
void execute(Database& database, std::string_view sql, const Values&... values) {
  Statement(database, sql, values...).step();
}

/// @param read  makes of a row what is returned
template <class Read, class... Values>
auto rows(Database& database, const std::string& sql, const Read& read, const Values&... values) {
  std::vector<decltype(read(std::declval<const Statement&>()))> found;
  database.read(
      sql, [&](const Statement& row) { found.push_back(read(row)); }, values...);
  return found;
}

template <class Record>
std::optional<Record> first_of(std::vector<Record> found) {
  if (found.empty()) return std::nullopt;
  return std::move(found.front());
}

// `request` and `failure` are messages of study.proto and job.proto. When this changes, the version
// in jobs/store/job_store.cpp increases by one.
constexpr const char* tables = R"sql(
CREATE TABLE IF NOT EXISTS study (
  id TEXT PRIMARY KEY,
  request_id TEXT UNIQUE,
  owner TEXT NOT NULL,
  created_ms INTEGER NOT NULL,
  changed_ms INTEGER NOT NULL,
  removing INTEGER NOT NULL,
  case_sha256 TEXT NOT NULL,
  request BLOB NOT NULL
) STRICT;
CREATE TABLE IF NOT EXISTS study_run (
  study TEXT NOT NULL REFERENCES study (id) ON DELETE CASCADE,
  number INTEGER NOT NULL,
  attempt INTEGER NOT NULL,
  job TEXT NOT NULL,
  outcome INTEGER NOT NULL,
  failure BLOB,
  PRIMARY KEY (study, number)
) STRICT, WITHOUT ROWID;
CREATE INDEX IF NOT EXISTS study_by_age ON study (created_ms, id);
CREATE INDEX IF NOT EXISTS study_run_to_queue ON study_run (study, number)
  WHERE job = '' AND outcome = 0;
)sql";

const std::string select_studies =
    "SELECT id, owner, created_ms, changed_ms, case_sha256, request FROM study ";
const std::string select_runs =
    "SELECT number, attempt, job, outcome, failure FROM study_run WHERE study = ? ";

StudyRecord record_of(const Statement& row) {
  StudyRecord record{row.text(0), row.text(1), row.integer(2), row.integer(3), row.text(4), {}};
  row.message(5, record.request);
  return record;
}

RunRecord run_of(const Statement& row) {
  RunRecord run{static_cast<int>(row.integer(0)),
                static_cast<int>(row.integer(1)),
                row.text(2),
                static_cast<v1::JobState>(row.integer(3)),
                {}};
  row.message(4, run.failure);
  return run;
}

std::string id_of(const Statement& row) {
  return row.text(0);
}

bool has_labels(const StudyRecord& study, const std::vector<std::string>& labels) {
  return std::ranges::all_of(labels, [&](const std::string& label) {
    return std::ranges::find(study.request.labels(), label) != study.request.labels().end();
  });
}

void insert_runs(Database& database, const std::string& id, const std::vector<RunRecord>& runs) {
  for (const RunRecord& run : runs)
    execute(database,
            "INSERT INTO study_run (study, number, attempt, job, outcome, failure) "
            "VALUES (?, ?, ?, ?, ?, ?)",
            id, run.number, run.attempt, run.job, run.outcome, run.failure);
}

void set_changed(Database& database, const std::string& id, std::int64_t now_ms) {
  execute(database, "UPDATE study SET changed_ms = ? WHERE id = ?", now_ms, id);
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
  database_.write([](Database& database) {
    database.execute(
        "PRAGMA journal_mode = WAL; PRAGMA foreign_keys = ON; PRAGMA synchronous = FULL");
    database.execute(tables);
  });
}

bool StudyStore::insert(const StudyRecord& record, const std::vector<RunRecord>& runs) {
  return database_.write([&](Database& database) {
    Transaction transaction(database);
    execute(database,
            "INSERT OR IGNORE INTO study (id, request_id, owner, created_ms, changed_ms, removing, "
            "case_sha256, request) VALUES (?, NULLIF(?, ''), ?, ?, ?, 0, ?, ?)",
            record.id, record.request.request_id(), record.owner, record.created_ms,
            record.changed_ms, record.case_sha256, record.request);
    if (database.changes() == 0) return false;
    insert_runs(database, record.id, runs);
    transaction.commit();
    return true;
  });
}

void StudyStore::extend(const StudyRecord& record, const std::vector<RunRecord>& more) {
  database_.write([&](Database& database) {
    Transaction transaction(database);
    execute(database, "UPDATE study SET request = ? WHERE id = ?", record.request, record.id);
    insert_runs(database, record.id, more);
    transaction.commit();
  });
}

void StudyStore::begin_removal(const std::string& id) {
  database_.write([&](Database& database) {
    execute(database, "UPDATE study SET removing = 1 WHERE id = ?", id);
  });
}

void StudyStore::erase(const std::string& id) {
  database_.write(
      [&](Database& database) { execute(database, "DELETE FROM study WHERE id = ?", id); });
}

std::optional<StudyRecord> StudyStore::find(const std::string& id) {
  return database_.read([&](Database& database) {
    return first_of(
        rows(database, select_studies + "WHERE id = ? AND removing = 0", record_of, id));
  });
}

std::optional<StudyRecord> StudyStore::find_request(const std::string& request_id) {
  return database_.read([&](Database& database) {
    return first_of(rows(database, select_studies + "WHERE request_id = ?", record_of, request_id));
  });
}

std::vector<std::string> StudyStore::ids() {
  return database_.read([&](Database& database) {
    return rows(database, "SELECT id FROM study WHERE removing = 0", id_of);
  });
}

std::vector<StudyRecord> StudyStore::removing() {
  return database_.read([&](Database& database) {
    return rows(database, select_studies + "WHERE removing = 1", record_of);
  });
}

std::vector<StudyRecord> StudyStore::list(const Page& page) {
  if (page.labels.empty()) return with_any_label(page);

  // Labels stand in the request alone, which SQLite cannot read.
  constexpr int rows_at_a_time = 100;
  std::vector<StudyRecord> found;
  Page rest = page;
  rest.size = rows_at_a_time;
  for (;;) {
    std::vector<StudyRecord> studies = with_any_label(rest);
    for (StudyRecord& study : studies) {
      rest.before_ms = study.created_ms;
      rest.before_id = study.id;
      if (has_labels(study, page.labels)) found.push_back(std::move(study));
      if (static_cast<int>(found.size()) == page.size) return found;
    }
    if (static_cast<int>(studies.size()) < rows_at_a_time) return found;
  }
}

std::vector<StudyRecord> StudyStore::with_any_label(const Page& page) {
  return database_.read([&](Database& database) {
    // '~' sorts after every character of an id: these are hexadecimal digits and '-'.
    return rows(
        database,
        select_studies +
            "WHERE removing = 0 AND (created_ms, id) < (?, ?) AND (? = '' OR owner = ?) "
            "AND (? = '' OR (id >= ? AND id < ?)) ORDER BY created_ms DESC, id DESC LIMIT ?",
        record_of, page.before_ms, page.before_id, page.owner, page.owner, page.id_prefix,
        page.id_prefix, page.id_prefix + "~", page.size);
  });
}

RunCounts StudyStore::counts(const std::string& id) {
  return database_.read([&](Database& database) {
    // A run without a job is QUEUED until it has an outcome. A job that was deleted has no state.
    RunCounts counts;
    const auto add = [&](const Statement& row) {
      const auto state = static_cast<v1::JobState>(row.integer(0));
      counts.by_state[state] = static_cast<int>(row.integer(1));
      counts.last_end_ms = std::max(counts.last_end_ms, row.integer(2));
      if (state == v1::QUEUED) counts.waiting = static_cast<int>(row.integer(3));
    };

    database.read(
        "SELECT CASE WHEN run.job <> '' THEN job.state WHEN run.outcome = 0 THEN 1 "
        "ELSE run.outcome END AS run_state, COUNT(*), MAX(COALESCE(job.ended_ms, 0)), "
        "SUM(run.job <> '') FROM study_run AS run LEFT JOIN job ON job.id = run.job "
        "WHERE run.study = ? GROUP BY 1 HAVING run_state IS NOT NULL",
        add, id);
    return counts;
  });
}

std::vector<RunRecord> StudyStore::runs(const std::string& id) {
  return database_.read([&](Database& database) {
    return rows(database, select_runs + "ORDER BY number", run_of, id);
  });
}

std::vector<std::string> StudyStore::to_feed() {
  return database_.read([&](Database& database) {
    return rows(database,
                "SELECT id FROM study WHERE removing = 0 AND EXISTS (SELECT 1 FROM study_run WHERE "
                "study = study.id AND job = '' AND outcome = 0) ORDER BY created_ms, id",
                id_of);
  });
}

std::optional<RunRecord> StudyStore::next_to_queue(const std::string& id) {
  return database_.read([&](Database& database) {
    return first_of(rows(database,
                         select_runs + "AND job = '' AND outcome = 0 ORDER BY number LIMIT 1",
                         run_of, id));
  });
}

bool StudyStore::set_job(const std::string& id, const RunRecord& run, bool followed) {
  return database_.write([&](Database& database) {
    Transaction transaction(database);
    execute(database,
            "UPDATE study_run SET job = ?, attempt = ? "
            "WHERE study = ? AND number = ? AND outcome = 0",
            run.job, run.attempt, id, run.number);
    const bool done = database.changes() > 0;

    if (done && followed)
      execute(database,
              "INSERT OR IGNORE INTO study_run (study, number, attempt, job, outcome) "
              "VALUES (?, ?, 0, '', 0)",
              id, run.number + 1);

    transaction.commit();
    return done;
  });
}

void StudyStore::drop(const std::string& id, int number) {
  database_.write([&](Database& database) {
    execute(database,
            "DELETE FROM study_run WHERE study = ? AND number = ? AND job = '' AND outcome = 0", id,
            number);
  });
}

void StudyStore::refuse(const std::string& id, int number, const v1::Finding& failure,
                        std::int64_t now_ms) {
  database_.write([&](Database& database) {
    Transaction transaction(database);
    execute(database,
            "UPDATE study_run SET outcome = ?, failure = ? "
            "WHERE study = ? AND number = ? AND job = '' AND outcome = 0",
            v1::FAILED, failure, id, number);
    set_changed(database, id, now_ms);
    transaction.commit();
  });
}

void StudyStore::cancel_waiting(const std::string& id, std::int64_t now_ms) {
  database_.write([&](Database& database) {
    Transaction transaction(database);
    execute(database,
            "UPDATE study_run SET outcome = ? WHERE study = ? AND job = '' AND outcome = 0",
            v1::CANCELLED, id);
    set_changed(database, id, now_ms);
    transaction.commit();
  });
}

void StudyStore::queue_again(const std::string& id, const std::vector<RunRecord>& runs) {
  database_.write([&](Database& database) {
    Transaction transaction(database);
    for (const RunRecord& run : runs)
      execute(database,
              "UPDATE study_run SET job = '', outcome = 0, failure = NULL "
              "WHERE study = ? AND number = ?",
              id, run.number);
    transaction.commit();
  });
}

}  // namespace dccast::studies
