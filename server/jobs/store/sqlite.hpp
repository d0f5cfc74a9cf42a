#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "core/storage/file_lock.hpp"

namespace google::protobuf {
class MessageLite;
}
struct sqlite3;
struct sqlite3_stmt;

namespace dccast::jobs {

/// The store cannot be read or written. The text is one sentence for the user; the statement and
/// the message of SQLite are in the program's log.
class StoreError : public std::runtime_error {
public:
  StoreError(const std::string& what, int code) : std::runtime_error(what), code_(code) {}
  int code() const { return code_; }  ///< primary result code of SQLite

private:
  int code_;
};

/// Whether the file is damaged or of another version, so that it must be rebuilt.
bool must_be_rebuilt(const StoreError& error);

/// Whether the fault may pass: the disk is full or out of reach, or memory is short.
bool is_passing(const StoreError& error);

/// Whether another connection has the file locked.
bool is_locked(const StoreError& error);

/// One SQLite connection. Not safe to use from several threads: see SharedDatabase.
class Database {
public:
  /// @throws StoreError
  explicit Database(const std::filesystem::path& path);
  Database(const Database&) = delete;
  /// Closes the database.
  ~Database();
  /// Runs statements without values. @throws StoreError
  void execute(const char* sql);
  /// Runs a query. @param take  called with each row  @param values  for the question marks
  template <typename Take, typename... Values>
  void read(std::string_view sql, const Take& take, const Values&... values);
  /// Rows changed by the last statement.
  int changes() const;
  sqlite3* handle() const { return handle_; }

private:
  sqlite3* handle_ = nullptr;
};

/// A connection that several threads use, one at a time. Of this process one connection writes at a
/// time. While another process has the file locked, a call tries again, for a second at most, and
/// other threads have their turn meanwhile.
class SharedDatabase {
public:
  /// @throws StoreError
  explicit SharedDatabase(const std::filesystem::path& path) : database_(path) {}

  /// @param action  called with the Database; it may be called again unless it has changed anything
  /// @return what it returns @throws StoreError
  template <typename Action>
  auto read(const Action& action);
  template <typename Action>
  auto write(const Action& action);

private:
  template <typename Action>
  static auto try_for_a_while(const Action& action);

  static inline std::mutex writing_;
  std::mutex mutex_;  ///< guards all below
  Database database_;
};

/// A prepared statement: bind() in the order of the question marks, then step().
class Statement {
public:
  /// Prepares a statement. @throws StoreError  SQL that the database does not accept
  Statement(Database& database, std::string_view sql);
  /// @param values  for the first question marks
  template <typename... Values>
  Statement(Database& database, std::string_view sql, const Values&... values)
      : Statement(database, sql) {
    (bind(values), ...);
  }
  Statement(const Statement&) = delete;
  ~Statement();

  /// Binds the next value.
  Statement& bind(std::int64_t value);
  Statement& bind(std::string_view text);
  Statement& bind(const std::vector<std::string>& texts);  ///< for one question mark each
  /// As a blob: the framed part of folder/format.hpp.
  Statement& bind(const google::protobuf::MessageLite& message);
  /// @return whether there is a row @throws StoreError
  bool step();

  /// Value of a column of the present row.
  std::int64_t integer(int column) const;
  std::string text(int column) const;  ///< text or blob; empty for NULL
  /// A message that was bound; an empty one for NULL. @throws StoreError  it is damaged
  void message(int column, google::protobuf::MessageLite& to) const;

private:
  /// @throws StoreError  the code of SQLite is an error
  void check(int code);

  Database& database_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

template <typename Take, typename... Values>
void Database::read(std::string_view sql, const Take& take, const Values&... values) {
  Statement statement(*this, sql, values...);
  while (statement.step()) take(statement);
}

template <typename Action>
auto SharedDatabase::try_for_a_while(const Action& action) {
  constexpr std::chrono::milliseconds between_tries{2};
  const auto end = std::chrono::steady_clock::now() + storage::longest_lock_wait;
  for (;; std::this_thread::sleep_for(between_tries)) {
    try {
      return action();
    } catch (const StoreError& error) {
      if (!is_locked(error) || std::chrono::steady_clock::now() > end) throw;
    }
  }
}

template <typename Action>
auto SharedDatabase::read(const Action& action) {
  return try_for_a_while([&] {
    const std::lock_guard lock(mutex_);
    return action(database_);
  });
}

template <typename Action>
auto SharedDatabase::write(const Action& action) {
  return try_for_a_while([&] {
    const std::scoped_lock lock(mutex_, writing_);
    return action(database_);
  });
}

/// BEGIN IMMEDIATE ... COMMIT; the destructor rolls back unless commit() was called.
class Transaction {
public:
  explicit Transaction(Database& database) : database_(database) {
    database_.execute("BEGIN IMMEDIATE");
  }
  Transaction(const Transaction&) = delete;
  /// Rolls back unless commit() was called.
  ~Transaction();
  /// @throws StoreError  the disk does not take the change
  void commit();

private:
  Database& database_;
  bool open_ = true;
};

}  // namespace dccast::jobs
