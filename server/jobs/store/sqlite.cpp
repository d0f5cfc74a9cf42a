#include "server/jobs/store/sqlite.hpp"

#include <fmt/format.h>
#include <google/protobuf/message_lite.h>
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <map>

#include "core/storage/file.hpp"
#include "server/jobs/folder/format.hpp"
#include "server/jobs/log.hpp"

namespace dccast::jobs {

namespace {

/// Meanings of primary result codes, for the user.
const std::map<int, std::string> meanings{
    {SQLITE_FULL, "the disk is full"},
    {SQLITE_IOERR, "the disk cannot be read or written"},
    {SQLITE_READONLY, "the file or its file system is read-only"},
    {SQLITE_CANTOPEN, "the file cannot be opened"},
    {SQLITE_CORRUPT, "the file is damaged"},
    {SQLITE_NOTADB, "the file is no job store, or its beginning is damaged"},
    {SQLITE_BUSY, "another process holds the file"},
    {SQLITE_LOCKED, "another process holds the file"},
    {SQLITE_NOMEM, "there is not enough memory"}};

[[noreturn]] void fail(sqlite3* handle, std::string_view action) {
  const int code = sqlite3_errcode(handle) & 0xff;
  if (code != SQLITE_BUSY)  // it is tried again, and the caller names it if it lasts
    log::error("job store: {} (SQLite {}, system error {}) in: {}", sqlite3_errmsg(handle),
               sqlite3_extended_errcode(handle), sqlite3_system_errno(handle), action);

  const auto known = meanings.find(code);
  const std::string meaning =
      known != meanings.end() ? known->second : fmt::format("SQLite refused with code {}", code);
  throw StoreError(fmt::format("the job store failed: {}", meaning), code);
}

/// SQLite follows links and waits for named pipes, with unclear messages. The store can be rebuilt,
/// so anything but a regular file counts as damage.
void require_regular_files(const std::filesystem::path& store) {
  for (const char* suffix : {"", "-wal", "-shm"}) {
    const std::filesystem::path path = store.string() + suffix;
    const std::string kind = storage::kind_of_entry(path);
    if (kind.empty() || kind == storage::regular_file) continue;
    throw StoreError(fmt::format("{} is {}, not {}; `dccastd check --repair` rebuilds the store",
                                 path.string(), kind, storage::regular_file),
                     SQLITE_NOTADB);
  }
}

}  // namespace

Database::Database(const std::filesystem::path& path) {
  require_regular_files(path);

  constexpr int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
  if (sqlite3_open_v2(path.c_str(), &handle_, flags, nullptr) == SQLITE_OK) return;

  log::error("job store {}: {}", path.string(), sqlite3_errmsg(handle_));
  sqlite3_close(handle_);
  throw StoreError(fmt::format("the job store {} cannot be opened", path.string()),
                   SQLITE_CANTOPEN);
}

Database::~Database() {
  sqlite3_close(handle_);
}

void Database::execute(const char* sql) {
  if (sqlite3_exec(handle_, sql, nullptr, nullptr, nullptr) != SQLITE_OK) fail(handle_, sql);
}

int Database::changes() const {
  return sqlite3_changes(handle_);
}

bool must_be_rebuilt(const StoreError& error) {
  return error.code() == SQLITE_CORRUPT || error.code() == SQLITE_NOTADB ||
         error.code() == SQLITE_SCHEMA;
}

bool is_locked(const StoreError& error) {
  return error.code() == SQLITE_BUSY;
}

bool is_passing(const StoreError& error) {
  constexpr std::array passing{SQLITE_FULL,     SQLITE_IOERR, SQLITE_READONLY,
                               SQLITE_CANTOPEN, SQLITE_BUSY,  SQLITE_NOMEM};
  return std::ranges::find(passing, error.code()) != passing.end();
}

Statement::Statement(Database& database, std::string_view sql) : database_(database) {
  if (sqlite3_prepare_v2(database.handle(), sql.data(), static_cast<int>(sql.size()), &statement_,
                         nullptr) != SQLITE_OK)
    fail(database.handle(), sql);
}

Statement::~Statement() {
  sqlite3_finalize(statement_);
}

void Statement::check(int code) {
  if (code != SQLITE_OK) fail(database_.handle(), "binding a value");
}

Statement& Statement::bind(std::int64_t value) {
  check(sqlite3_bind_int64(statement_, ++bound_, value));
  return *this;
}

Statement& Statement::bind(std::string_view text) {
  check(sqlite3_bind_text64(statement_, ++bound_, text.empty() ? "" : text.data(), text.size(),
                            SQLITE_TRANSIENT, SQLITE_UTF8));
  return *this;
}

Statement& Statement::bind(const std::vector<std::string>& texts) {
  for (const std::string& text : texts) bind(text);
  return *this;
}

Statement& Statement::bind(const google::protobuf::MessageLite& message) {
  const std::string bytes = framed_part(message.SerializeAsString());
  check(sqlite3_bind_blob64(statement_, ++bound_, bytes.data(), bytes.size(), SQLITE_TRANSIENT));
  return *this;
}

bool Statement::step() {
  const int code = sqlite3_step(statement_);
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  fail(database_.handle(), sqlite3_sql(statement_));
}

std::int64_t Statement::integer(int column) const {
  return sqlite3_column_int64(statement_, column);
}

std::string Statement::text(int column) const {
  const void* bytes = sqlite3_column_blob(statement_, column);
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
  return bytes == nullptr ? std::string() : std::string(static_cast<const char*>(bytes), size);
}

void Statement::message(int column, google::protobuf::MessageLite& to) const {
  const std::string bytes = text(column);
  to.Clear();
  if (bytes.empty()) return;

  const auto part = first_part(bytes);
  if (!part || !to.ParseFromString(std::string(part->content)))
    throw StoreError("the job store failed: a row is damaged", SQLITE_CORRUPT);
}

Transaction::~Transaction() {
  if (!open_) return;
  try {
    database_.execute("ROLLBACK");
  } catch (const StoreError& error) {
    // SQLite rolls back by itself when the disk is full. The exception with the cause is on its
    // way.
    log::warn("{}", error.what());
  }
}

void Transaction::commit() {
  database_.execute("COMMIT");
  open_ = false;
}

}  // namespace dccast::jobs
