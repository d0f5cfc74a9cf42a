#include "server/jobs/job_schema.hpp"

#include <sqlite3.h>

#include <cstdint>
#include <sstream>
#include <string>

namespace dccast::jobs {

namespace {

constexpr std::int64_t this_version = 8;

// Times are milliseconds since 1970, states and priorities the numbers of job.proto, the rest
// serialised messages of job.proto. Labels stand one a line, each between two line ends; `changes`
// is a Job with only these and the jobs that it waits for. Of studies, see
// server/studies/study_store: the request of each, and the job of each of its runs.
// A column a line.
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

/// SQLite has no checksums of its own: a bit that flips in a row would be read. Each row keeps one
/// of its columns, and `PRAGMA integrity_check` computes it again.
std::string table(const std::string& name, const std::string& columns,
                  const std::string& key = "") {
  std::string definitions, names;
  std::istringstream lines(columns);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty()) continue;
    definitions += line + ", ";
    names += (names.empty() ? "" : ", ") + line.substr(0, line.find(' '));
  }
  const std::string sum = "sum_of(" + names + ")";
  return "CREATE TABLE " + name + " (" + definitions + "sum INTEGER NOT NULL AS (" + sum +
         ") STORED CHECK (sum = " + sum + ")" + key + ") STRICT";
}

std::string schema() {
  return table("job", job_columns) + ";" + table("study", study_columns) + ";" +
         table("study_run", study_run_columns, ", PRIMARY KEY (study, number)") +
         ", WITHOUT ROWID;" + indexes + "PRAGMA user_version = " + std::to_string(this_version);
}

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
  database.execute(schema().c_str());
  transaction.commit();
}

}  // namespace dccast::jobs
