#include "server/jobs/job_store.hpp"

#include <utility>

#include "proto/values/digests.hpp"
#include "proto/values/printable.hpp"
#include "server/jobs/events.hpp"
#include "server/jobs/job_schema.hpp"
#include "server/jobs/log.hpp"

namespace dccast::jobs {

namespace {

/// What a job of the page has to fulfil; its question marks are bound in list().
std::string condition_of(const JobStore::Page& page) {
  std::string sql = "(created_ms, id) < (?, ?)";
  if (!page.states.empty()) {
    sql += " AND state IN (";
    for (const v1::JobState state : page.states) sql += std::to_string(state) + ",";
    sql.back() = ')';
  }
  // The second condition is implied; it lets SQLite use the index of the jobs that have a study.
  if (!page.study.empty()) sql += " AND study = ? AND study <> ''";
  if (!page.owner.empty()) sql += " AND owner = ?";
  if (!page.id_prefix.empty()) sql += " AND id >= ? AND id < ?";
  if (page.since_ms > 0) sql += " AND created_ms >= " + std::to_string(page.since_ms);
  if (!page.title.empty()) sql += " AND title GLOB ?";
  for (std::size_t i = 0; i < page.labels.size(); ++i) sql += " AND instr(labels, ?) > 0";
  return sql;
}

void set_time(std::int64_t milliseconds, google::protobuf::Timestamp* time) {
  *time = timestamp(milliseconds);
}

/// `outcome` holds a Job with only the last step, the artifacts, the loss of validity, the
/// findings and the time it ran set.
std::string outcome_of(const v1::Job& job) {
  v1::Job outcome;
  if (job.has_last_step()) *outcome.mutable_last_step() = job.last_step();
  *outcome.mutable_artifacts() = job.artifacts();
  if (job.has_validity_loss()) *outcome.mutable_validity_loss() = job.validity_loss();
  *outcome.mutable_findings() = job.findings();
  outcome.set_run_s(job.run_s());
  return outcome.SerializeAsString();
}

void read_labels(const std::string& lines, v1::Job& job) {
  for (std::size_t begin = 1; begin < lines.size();) {
    const std::size_t end = lines.find('\n', begin);
    job.add_labels(values::escaped(lines.substr(begin, end - begin)));
    begin = end + 1;
  }
}

/// In the order in which read_row() takes them.
constexpr std::string_view job_columns =
    "id, request_id, case_sha256, title, priority, state, created_ms, started_ms, ended_ms, "
    "attempts, failure, outcome, losses, lost_step, first_loss, "
    "study, owner, bytes, labels, changes, answer_key, solver";

/// The labels of a job, one a line, each between two line ends.
std::string label_lines(const v1::Job& job) {
  std::string lines;
  for (const std::string& label : job.labels()) lines += (lines.empty() ? "\n" : "") + label + "\n";
  return lines;
}

/// A serialised Job with only the changes, the jobs before it and what has no column set.
std::string changes_of(const v1::Job& job) {
  v1::Job changes;
  *changes.mutable_changes() = job.changes();
  *changes.mutable_after() = job.after();
  changes.set_pinned(job.pinned());
  changes.set_time_limit_s(job.time_limit_s());
  changes.set_mail(job.mail());
  changes.set_estimated_s(job.estimated_s());
  return changes.SerializeAsString();
}

/// Texts of an earlier version may hold characters that are refused now, and go to terminals.
JobRecord read_row(const Statement& statement) {
  JobRecord record;
  v1::Job& job = record.job;
  job.ParseFromString(statement.text(11));
  job.MergeFromString(statement.text(19));
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
  record.losses = static_cast<int>(statement.integer(12));
  record.lost_step = statement.integer(13);
  record.first_loss = statement.text(14);
  job.set_study(statement.text(15));
  job.set_owner(statement.text(16));
  record.bytes = statement.integer(17);
  read_labels(statement.text(18), job);
  record.answer_key = statement.text(20);
  record.solver = statement.text(21);
  return record;
}

/// Binds the columns that change in a job's life, in the order of JobStore::update().
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
      .bind(record.losses)
      .bind(record.lost_step)
      .bind(record.first_loss)
      .bind(record.solver)
      .bind(record.bytes);
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
    store_.probe();  // a commit that waits for the disk takes all before it along
  } catch (const StoreError& error) {
    log::error("{}", error.what());
  }
}

void JobStore::set_durability(Durability durability) {
  if (bulk_) return database_.execute("PRAGMA synchronous = OFF");
  database_.execute(durability == Durability::full ? "PRAGMA synchronous = FULL"
                                                   : "PRAGMA synchronous = NORMAL");
}

std::optional<JobRecord> JobStore::insert(const JobRecord& record) {
  const v1::Job& job = record.job;
  if (!job.request_id().empty())
    if (auto there = find_request(job.request_id())) return there;
  const std::lock_guard lock(mutex_);
  set_durability(Durability::full);
  Statement statement(database_,
                      "INSERT INTO job (id, request_id, case_sha256, title, priority, state, "
                      "created_ms, study, owner, bytes, labels, changes, answer_key) "
                      "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
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
  return std::nullopt;
}

void JobStore::update(const JobRecord& record, Durability durability) {
  const std::lock_guard lock(mutex_);
  set_durability(durability);
  Statement statement(database_,
                      "UPDATE job SET state = ?, started_ms = ?, ended_ms = ?, attempts = ?, "
                      "failure = ?, outcome = ?, losses = ?, lost_step = ?, first_loss = ?, "
                      "solver = ?, bytes = ? WHERE id = ?");
  bind_changing(statement, record);
  statement.bind(record.job.id()).step();
}

void JobStore::update_marks(const v1::Job& job) {
  const std::lock_guard lock(mutex_);
  set_durability(Durability::full);
  Statement statement(database_, "UPDATE job SET labels = ?, changes = ? WHERE id = ?");
  statement.bind(label_lines(job)).bind_blob(changes_of(job)).bind(job.id()).step();
}

void JobStore::update_bytes(const std::string& id, std::int64_t bytes) {
  const std::lock_guard lock(mutex_);
  set_durability(Durability::normal);
  Statement statement(database_, "UPDATE job SET bytes = ? WHERE id = ?");
  statement.bind(bytes).bind(id).step();
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
  const std::lock_guard lock(reading_);
  Statement statement(
      *reader_, "SELECT " + std::string(job_columns) + " FROM job " + std::string(where_and_order));
  if (!argument.empty()) statement.bind(argument);
  std::vector<JobRecord> records;
  while (statement.step()) records.push_back(read_row(statement));
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
  const std::lock_guard lock(reading_);
  Statement statement(*reader_,
                      "SELECT COALESCE(SUM(bytes), 0) FROM job WHERE state BETWEEN 1 AND 3");
  statement.step();
  return statement.integer(0);
}

int JobStore::unfinished_of(const std::string& owner) {
  const std::lock_guard lock(reading_);
  Statement statement(*reader_,
                      "SELECT COUNT(*) FROM job WHERE state BETWEEN 1 AND 3 AND owner = ?");
  statement.bind(owner).step();
  return static_cast<int>(statement.integer(0));
}

std::int64_t JobStore::bytes_of(const std::string& owner) {
  const std::lock_guard lock(reading_);
  Statement statement(*reader_, "SELECT COALESCE(SUM(bytes), 0) FROM job WHERE owner = ?");
  statement.bind(owner).step();
  return statement.integer(0);
}

std::vector<JobStore::Group> JobStore::groups() {
  const std::lock_guard lock(reading_);
  Statement statement(*reader_,
                      "SELECT owner, state, COUNT(*), SUM(bytes), MIN(created_ms) FROM job "
                      "GROUP BY owner, state");
  std::vector<Group> groups;
  while (statement.step())
    groups.push_back({statement.text(0), static_cast<v1::JobState>(statement.integer(1)),
                      statement.integer(2), statement.integer(3), statement.integer(4)});
  return groups;
}

std::vector<JobStore::Ended> JobStore::ended(bool of_studies) {
  const std::lock_guard lock(reading_);
  // 4 to 6: SUCCEEDED, FAILED, CANCELLED of job.proto.
  Statement statement(
      *reader_, "SELECT id, ended_ms, bytes, changes FROM job WHERE state BETWEEN 4 AND 6" +
                    std::string(of_studies ? "" : " AND study = ''") + " ORDER BY ended_ms, id");
  std::vector<Ended> ended;
  while (statement.step()) {
    v1::Job changes;
    changes.ParseFromString(statement.text(3));
    ended.push_back(
        {statement.text(0), statement.integer(1), statement.integer(2), changes.pinned()});
  }
  return ended;
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
  const std::lock_guard lock(reading_);
  Statement statement(*reader_, "SELECT COUNT(*) FROM job WHERE state = ?");
  statement.bind(state).step();
  return static_cast<int>(statement.integer(0));
}

std::set<std::string> JobStore::ids() {
  const std::lock_guard lock(reading_);
  Statement statement(*reader_, "SELECT id FROM job");
  std::set<std::string> ids;
  while (statement.step()) ids.insert(statement.text(0));
  return ids;
}

std::optional<std::string> JobStore::find_answer(const std::string& answer_key,
                                                 const std::string& solver) {
  if (answer_key.empty() || solver.empty()) return std::nullopt;
  const std::lock_guard lock(reading_);
  // 4: SUCCEEDED of job.proto. The condition on the key lets SQLite use the index.
  Statement statement(*reader_,
                      "SELECT id FROM job WHERE answer_key = ? AND answer_key <> '' AND solver = ? "
                      "AND state = 4 ORDER BY created_ms DESC LIMIT 1");
  if (!statement.bind(answer_key).bind(solver).step()) return std::nullopt;
  return statement.text(0);
}

std::vector<JobRecord> JobStore::list(const Page& page) {
  const std::string sql = "SELECT " + std::string(job_columns) + " FROM job WHERE " +
                          condition_of(page) + " ORDER BY created_ms DESC, id DESC LIMIT ?";
  const std::lock_guard lock(reading_);
  Statement statement(*reader_, sql);
  statement.bind(page.before_ms).bind(page.before_id);
  for (const std::string& wanted : {page.study, page.owner})
    if (!wanted.empty()) statement.bind(wanted);
  // Behind every character of an id: they are hexadecimal digits and '-'.
  if (!page.id_prefix.empty()) statement.bind(page.id_prefix).bind(page.id_prefix + "~");
  if (!page.title.empty()) statement.bind(page.title);
  for (const std::string& label : page.labels) statement.bind("\n" + label + "\n");
  statement.bind(page.size);
  std::vector<JobRecord> records;
  while (statement.step()) records.push_back(read_row(statement));
  return records;
}

namespace {

v1::Job new_job_message(const NewJob& new_job) {
  v1::Job job;
  job.set_id(values::random_uuid());
  job.set_title(new_job.title);
  job.set_state(v1::QUEUED);
  job.set_priority(new_job.priority == v1::PRIORITY_UNSPECIFIED ? v1::NORMAL : new_job.priority);
  job.set_request_id(new_job.request_id);
  job.set_study(new_job.study);
  job.set_owner(new_job.owner);
  job.set_case_sha256(new_job.case_sha256);
  job.mutable_labels()->Assign(new_job.labels.begin(), new_job.labels.end());
  job.mutable_changes()->Assign(new_job.changes.begin(), new_job.changes.end());
  job.mutable_after()->Assign(new_job.after.begin(), new_job.after.end());
  job.set_time_limit_s(new_job.time_limit_s);
  job.set_mail(new_job.mail);
  job.set_estimated_s(new_job.estimated_s);
  *job.mutable_create_time() = timestamp(milliseconds(now()));  // as exactly as the store keeps it
  return job;
}

std::int64_t size_of(const NewJob& new_job, const Attachments& attachments) {
  auto bytes = static_cast<std::int64_t>(new_job.submitted_case.size() +
                                         new_job.complete_case.size() + new_job.case_file.size());
  for (const v1::Attachment& attachment : attachments)
    bytes += static_cast<std::int64_t>(attachment.content().size());
  return bytes;
}

}  // namespace

JobRecord record_of_new(const NewJob& new_job, const Attachments& attachments) {
  JobRecord record;
  record.job = new_job_message(new_job);
  record.bytes = size_of(new_job, attachments);
  record.answer_key = new_job.answer_key;
  return record;
}

}  // namespace dccast::jobs
