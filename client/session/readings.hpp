#pragma once

#include <atomic>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "client/session/connection.hpp"
#include "client/session/mqtt.hpp"
#include "client/session/readings_table.hpp"

namespace dccast::client {

/// Adds readings to the record of a job, each once and in order. While the server is away it goes
/// on trying.
class RecordSender {
public:
  /// @param remark  receives what is left out, and why
  /// Throws CommandFailed: the job follows no readings.
  RecordSender(Connection& connection, std::string id, Remark remark);

  /// Sends readings; those that the record has already are left out. Throws CommandFailed,
  /// Interrupted. @return false if the job takes no more
  bool send(std::vector<ReadingOfLine> readings);
  /// Sends the end of the record. Throws CommandFailed, Interrupted.
  void close();
  /// Remarks how many values of each sensor were left out, and how many readings were refused,
  /// where that was more than one.
  void remark_left_out();
  /// Whether the record holds a value that was measured, from this sender or before it. Safe to
  /// call from another thread.
  bool has_values() const { return has_values_; }

private:
  /// One call, repeated until the server has answered.
  grpc::Status append(const v1::AppendReadingsRequest& request);
  /// Sends readings with the next numbers. @return as send()
  bool send_numbered(std::span<const ReadingOfLine> readings);
  void remark_known();
  /// Remarks the first value of each sensor that the server has left out of these readings.
  /// @param before  number of the reading before the first of them
  void count_left_out(std::span<const ReadingOfLine> readings, std::int64_t before);

  Connection& connection_;
  std::string id_;
  Remark remark_;
  v1::AppendReadingsResponse kept_;      ///< what the server has
  std::map<std::string, int> left_out_;  ///< values that no plant has, by LeftOutValue.name
  std::size_t known_ = 0;  ///< readings that the server had, and that are not remarked yet
  int refused_ = 0;
  std::atomic<bool> has_values_;
};

}  // namespace dccast::client
