#include "client/study_creation.hpp"

#include <iostream>

#include "client/case_faults.hpp"
#include "client/case_options.hpp"
#include "client/connection.hpp"
#include "client/render/study_text.hpp"
#include "client/study_watch.hpp"
#include "proto/values/uuid.hpp"

namespace dccast::client {
namespace {

v1::CreateStudyRequest request_of(const StudyCase& base, const CaseUnderCheck& checked) {
  v1::CreateStudyRequest request;
  request.set_request_id(values::random_uuid());
  *request.mutable_case_() = checked.description;
  *request.mutable_attachments() = {checked.read.attachments.begin(),
                                    checked.read.attachments.end()};
  *request.mutable_changes() = {checked.changes.begin(), checked.changes.end()};
  *request.mutable_labels() = {base.labels.begin(), base.labels.end()};
  return request;
}

/// What is wrong with a plan or one of its cases, a line each.
void print_refusal(const grpc::Status& status, const CaseUnderCheck& checked) {
  const std::string& message = status.error_message();
  const std::string run =
      message.starts_with("run ") ? message.substr(0, message.find(": the case has")) + ": " : "";
  for (const v1::Fault& fault : faults_of(status))
    std::cerr << run << describe(fault, checked.read.source) << '\n';
}

}  // namespace

std::optional<v1::Study> create_study(
    Connection& connection, const StudyCase& base,
    const std::function<void(v1::CreateStudyRequest&)>& add_plan) {
  const CaseUnderCheck checked = read_case(base.file, changes_of(base.set));
  if (!checked.faults.empty()) {
    print_faults(checked, std::cerr);
    return std::nullopt;
  }
  v1::CreateStudyRequest request = request_of(base, checked);
  add_plan(request);
  v1::Study study;
  const grpc::Status status = connection.try_call(&Stub::CreateStudy, request, study);
  if (!faults_of(status).empty()) {
    print_refusal(status, checked);
    return std::nullopt;
  }
  check(status, connection.server());
  return study;
}

void follow_with_progress(Connection& connection, const std::string& id,
                          const std::string& come_back) {
  try {
    render::StudyProgress progress(std::cerr, render::terminal_of(2));
    follow_study(
        connection, id, [&](const v1::Study& study) { progress.show(study); }, std::cerr);
  } catch (const Interrupted&) {
    throw Interrupted("the study goes on. Come back: " + come_back);
  }
}

}  // namespace dccast::client
