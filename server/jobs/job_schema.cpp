#include "server/jobs/job_schema.hpp"

#include <sqlite3.h>

#include <cstdint>

namespace dccast::jobs {

namespace {

constexpr std::int64_t this_version = 7;

// Times are milliseconds since 1970, states and priorities the numbers of job.proto, the rest
// serialised messages of job.proto. Labels stand one a line, each between two line ends; `changes`
// is a Job with only these and the jobs that it waits for. Of studies, see
// server/studies/study_store: the request of each, and the job of each of its runs.
constexpr const char* schema = R"sql(
CREATE TABLE job (
  id TEXT PRIMARY KEY,
  request_id TEXT UNIQUE,
  case_sha256 TEXT NOT NULL,
  title TEXT NOT NULL,
  priority INTEGER NOT NULL,
  state INTEGER NOT NULL,
  created_ms INTEGER NOT NULL,
  started_ms INTEGER NOT NULL DEFAULT 0,
  ended_ms INTEGER NOT NULL DEFAULT 0,
  attempts INTEGER NOT NULL DEFAULT 0,
  failure BLOB,
  outcome BLOB,
  losses INTEGER NOT NULL DEFAULT 0,
  lost_step INTEGER NOT NULL DEFAULT -1,
  first_loss TEXT NOT NULL DEFAULT '',
  study TEXT NOT NULL,
  owner TEXT NOT NULL,
  bytes INTEGER NOT NULL,
  labels TEXT NOT NULL,
  changes BLOB,
  answer_key TEXT NOT NULL,
  solver TEXT NOT NULL DEFAULT ''
) STRICT;
CREATE INDEX job_by_age ON job (created_ms, id);
CREATE INDEX job_by_state ON job (state);
CREATE INDEX job_by_study ON job (study) WHERE study <> '';
CREATE INDEX job_by_answer ON job (answer_key, solver) WHERE answer_key <> '';
CREATE TABLE probe (id INTEGER PRIMARY KEY CHECK (id = 1), at_ms INTEGER NOT NULL) STRICT;
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
PRAGMA user_version = 7;
)sql";

}  // namespace

void require_schema(Database& database, const std::filesystem::path& path) {
  std::int64_t version = 0;
  {
    Statement statement(database, "PRAGMA user_version");
    statement.step();
    version = statement.integer(0);
  }
  if (version == this_version) return;
  if (version > this_version)
    throw StoreError("job store " + path.string() + " was written by a later version of dccastd (" +
                         std::to_string(version) + "); use that one, or another data_directory",
                     0);
  if (version > 0)
    throw StoreError("job store " + path.string() + " is of an earlier version (" +
                         std::to_string(version) + ")",
                     SQLITE_SCHEMA);
  Transaction transaction(database);
  database.execute(schema);
  transaction.commit();
}

}  // namespace dccast::jobs
