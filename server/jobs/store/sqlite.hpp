#pragma once

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

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

/// One SQLite connection. Not safe to use from several threads; its owner has a mutex.
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
