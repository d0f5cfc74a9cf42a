#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include <grpcpp/support/status.h>

#include "client/connection.hpp"
#include "client/message_json.hpp"
#include "proto/case_file/case_file.hpp"

namespace dccast::client {

/// A case file as read, and every fault known of it.
struct CaseUnderCheck {
  v1::Case description;
  case_file::ReadOutcome read;
  std::vector<v1::Fault> faults;  ///< local ones and the server's, in the order of the file
  std::vector<v1::Fault> warnings;
  std::optional<v1::ValidateCaseResponse::Estimate> estimate;
  google::protobuf::RepeatedPtrField<v1::Finding> findings;  ///< only without faults
  std::vector<v1::CaseChange> changes;  ///< made in `description`
};

/// Reads a case file, "-" is standard input, and makes the changes in it; faults are the local
/// ones.
CaseUnderCheck read_case(const std::string& file, const std::vector<v1::CaseChange>& changes = {});

/// Adds what the server's ValidateCase finds in what could be read. If the server cannot be asked,
/// local faults are an answer already, which it says on standard error; without them it throws
/// CommandFailed. Throws Interrupted.
void check_with_server(CaseUnderCheck& checked, Connection& connection);

/// Local faults and the server's together. What the server says of a key that already has a local
/// fault (or of a part of it) is left out: the key did not reach it.
std::vector<v1::Fault> merge_faults(const std::vector<v1::Fault>& local,
                                    const std::vector<v1::Fault>& remote);

/// The faults that came with SubmitJob's INVALID_ARGUMENT; empty if there are none in it.
std::vector<v1::Fault> faults_of(const grpc::Status& status);

/// Prints each fault and warning as `file:line:column: key = value: ...`.
void print_faults(const CaseUnderCheck& checked, std::ostream& stream);

/// {valid, faults [{field, value, message, permitted, remedy, file, line, column}], warnings,
/// findings, estimate}
Json faults_json(const CaseUnderCheck& checked);

}  // namespace dccast::client
