#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include <grpcpp/support/status.h>

#include "client/model/json.hpp"
#include "client/session/connection.hpp"
#include "client/session/uploads.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/uncertainty.hpp"

namespace dccast::client {

/// A case file as read, with all known faults.
struct CaseUnderCheck {
  /// The case as read, and what the reader has found.
  v1::Case description;
  case_file::ReadOutcome read;
  /// Local faults and those of the server, in the order of the file
  std::vector<v1::Fault> faults;
  /// Faults that do not prevent a run, and expected size and time, from the server's check.
  std::vector<v1::Fault> warnings;
  std::optional<v1::ValidateCaseResponse::Estimate> estimate;
  google::protobuf::RepeatedPtrField<v1::Finding> findings;  ///< only without faults
  std::vector<case_file::UncertainKey> uncertain;            ///< data with a range; without faults
  std::vector<v1::CaseChange> changes;                       ///< changes applied to `description`
  std::string text;                                          ///< of the file, byte by byte
};

/// Reads a case file ("-" is standard input) and applies the changes; reports local faults only.
CaseUnderCheck read_case(const std::string& file, const std::vector<v1::CaseChange>& changes = {});

/// The same of a text. @param name  of its file, for messages
CaseUnderCheck read_case_text(const std::string& text, const std::string& name,
                              const std::vector<v1::CaseChange>& changes = {});

/// The same of a text from another machine: no file of this one is read, and one that the text
/// names is a fault.
CaseUnderCheck read_case_elsewhere(const std::string& text, const std::string& name,
                                   const std::vector<v1::CaseChange>& changes = {});

/// The case of a job as it was submitted, with the changes made then and further ones. Throws
/// CommandFailed for a job that was submitted without its file, and Interrupted.
CaseUnderCheck read_case_of_job(Connection& connection, const std::string& id,
                                const std::vector<v1::CaseChange>& changes);

/// Names the files of a case in a request.
template <typename Request>
void name_files(const CaseUnderCheck& checked, Request& request) {
  for (const case_file::AttachedFile& file : checked.read.attachments) {
    v1::Attachment& named = *request.add_attachments();
    named.set_name(file.name);
    named.set_sha256(file.sha256);
    named.set_size_bytes(file.bytes);
  }
}

/// Gives a request the case, its changes and its files, which are uploaded. Throws as
/// upload_files().
template <typename Request>
void put_case(const CaseUnderCheck& checked, Connection& connection, Request& request) {
  upload_files(connection, checked.read.attachments);
  name_files(checked, request);
  *request.mutable_case_() = checked.description;
  request.mutable_changes()->Assign(checked.changes.begin(), checked.changes.end());
}

/// A request that submits a case without faults, whose files are uploaded; without its id and
/// priority.
v1::SubmitJobRequest submission_of(const CaseUnderCheck& checked, Connection& connection);

/// Adds the faults that ValidateCase of the server finds in the parts that could be read. If the
/// server cannot be reached, local faults are reported alone, with a message on standard error;
/// without local faults CommandFailed is thrown. Throws Interrupted.
void check_with_server(CaseUnderCheck& checked, Connection& connection);

/// Merges local faults and those of the server. Server faults of a key, or part of a key, that
/// already has a local fault are left out: the key did not reach the server.
std::vector<v1::Fault> merge_faults(const std::vector<v1::Fault>& local,
                                    const std::vector<v1::Fault>& remote);

/// The verdict in the details of a status: faults, and of a study the run whose case has them;
/// without faults where there is none.
v1::ValidateCaseResponse verdict_of(const grpc::Status& status);

/// The faults of that verdict.
std::vector<v1::Fault> faults_of(const grpc::Status& status);

/// Prints each fault and warning as `file:line:column: key = value: ...`.
void print_faults(const CaseUnderCheck& checked, std::ostream& stream);

/// {valid, faults [{field, value, message, permitted, remedy, file, line, column}], warnings,
/// findings, estimate, uncertain [{key, range, origin}]}
Json faults_json(const CaseUnderCheck& checked);

}  // namespace dccast::client
