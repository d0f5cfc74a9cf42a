#pragma once

#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "client/session/connection.hpp"

namespace dccast::client {

/// Where lines come from: standard input, or a file.
class LineSource {
public:
  /// @param path     "-" for standard input
  /// @param growing  at the end of the file further lines are awaited
  /// Throws CommandFailed: the file cannot be read.
  LineSource(const std::string& path, bool growing);
  LineSource(const LineSource&) = delete;
  ~LineSource();

  /// The complete lines that are there, at least one; waits for it. Empty: there are no more, or
  /// the stop was requested.
  std::vector<std::string> next(const std::stop_token& stop);

private:
  /// Reads what is there. @return whether there may be more
  bool read_some(const std::stop_token& stop);

  int descriptor_;
  bool growing_;
  std::string rest_;  ///< begin of the next line
};

/// Adds readings to the record of a job, each once and in order. While the server is away it goes on
/// trying.
class RecordSender {
public:
  /// @param remark  receives what is left out, and why
  /// Throws CommandFailed: the job follows no readings.
  RecordSender(Connection& connection, std::string id, std::function<void(const std::string&)> remark);

  /// Sends readings; those that the record has already are left out. Throws CommandFailed,
  /// Interrupted. @return false if the job takes no more
  bool send(std::vector<v1::Reading> readings);
  /// Sends the end of the record. Throws CommandFailed, Interrupted.
  void close();

private:
  /// One call, repeated until the server has answered.
  grpc::Status append(const v1::AppendReadingsRequest& request);
  /// Sends readings with the next numbers. @return as send()
  bool send_numbered(const std::vector<v1::Reading>& readings);

  Connection& connection_;
  std::string id_;
  std::function<void(const std::string&)> remark_;
  v1::AppendReadingsResponse kept_;  ///< what the server has
};

}  // namespace dccast::client
