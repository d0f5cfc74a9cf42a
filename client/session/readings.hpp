#pragma once

#include <string>
#include <vector>

#include "client/session/connection.hpp"
#include "client/session/mqtt.hpp"

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
  Remark remark_;
  v1::AppendReadingsResponse kept_;  ///< what the server has
};

}  // namespace dccast::client
