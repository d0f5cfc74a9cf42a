#include "server/jobs/job_schema.hpp"

#include <array>
#include <cstdint>

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
    // Studies, see server/studies/study_store: the request of each, and the job of each of its
    // runs.
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
)sql",
    R"sql(
ALTER TABLE job ADD COLUMN worker_token_sha256 TEXT NOT NULL DEFAULT '';
PRAGMA user_version = 6;
)sql"};

}  // namespace

void bring_up_to_date(Database& database, const std::filesystem::path& path) {
  std::int64_t version = 0;
  {
    Statement statement(database, "PRAGMA user_version");
    statement.step();
    version = statement.integer(0);
  }
  constexpr auto newest = static_cast<std::int64_t>(schema_steps.size());
  if (version > newest)
    throw StoreError("job store " + path.string() + " was written by a later version of dccastd (" +
                         std::to_string(version) + "); use that one, or another data_directory",
                     0);
  if (version == newest) return;
  Transaction transaction(database);
  for (std::int64_t step = version; step < newest; ++step)
    database.execute(schema_steps[static_cast<std::size_t>(step)]);
  transaction.commit();
}

}  // namespace dccast::jobs
