#include "client/session/case_faults.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>

#include "client/session/download.hpp"
#include "proto/case_file/override.hpp"

namespace dccast::client {
namespace {

/// A local fault in a point or a part of a key means that the key as a whole did not reach the
/// server.
bool known_locally(const std::vector<v1::Fault>& local, const v1::Fault& remote) {
  return std::any_of(local.begin(), local.end(), [&](const v1::Fault& fault) {
    return case_file::covers(fault.field(), remote.field()) ||
           case_file::covers(remote.field(), fault.field());
  });
}

void sort_by_place(CaseUnderCheck& checked) {
  const auto place = [&](const v1::Fault& fault) {
    const case_file::Position at = checked.read.source.find(fault.field());
    return std::pair(at.line, at.column);
  };
  std::stable_sort(checked.faults.begin(), checked.faults.end(),
                   [&](const v1::Fault& a, const v1::Fault& b) { return place(a) < place(b); });
}

Json fault_json(const v1::Fault& fault, const case_file::SourceMap& source) {
  Json json = to_json(fault);
  const case_file::Position at = source.find(fault.field());
  json["file"] = source.origin_of(fault.field());
  json["line"] = at.line;
  json["column"] = at.column;
  return json;
}

/// @return  empty if the server cannot be reached and only local faults can be reported
std::optional<v1::ValidateCaseResponse> ask(Connection& connection, const CaseUnderCheck& checked) {
  try {
    upload_files(connection, checked.read.attachments);
    v1::ValidateCaseRequest request;
    *request.mutable_case_() = checked.description;
    name_files(checked, request);
    // What follows from keys that could not be read is not judged.
    for (const v1::Fault& fault : checked.faults) request.add_faulty_keys(fault.field());
    return connection.call(&Stub::ValidateCase, request);
  } catch (const Interrupted&) {
    throw;
  } catch (const CommandFailed& failure) {
    if (checked.faults.empty()) throw;
    std::cerr << "dccast: not checked by the server: " << failure.what() << '\n';
    return std::nullopt;
  }
}

/// A file that could not be parsed cannot be checked further.
bool cannot_be_judged(const std::vector<v1::Fault>& faults) {
  return faults.size() == 1 && faults.front().field().empty();
}

/// The case with its changes, if the file could be parsed.
void apply(const std::vector<v1::CaseChange>& changes, CaseUnderCheck& checked) {
  checked.changes.insert(checked.changes.end(), changes.begin(), changes.end());
  // Changes cannot be applied to a file that could not be parsed.
  if (!cannot_be_judged(checked.read.faults))
    case_file::apply_changes(checked.description, changes, checked.read);
  checked.faults = checked.read.faults;
}

}  // namespace

CaseUnderCheck read_case(const std::string& file, const std::vector<v1::CaseChange>& changes) {
  if (file == "-")
    return read_case_text({std::istreambuf_iterator<char>(std::cin), {}}, "standard input",
                          changes);
  std::error_code error;
  if (std::filesystem::is_directory(file, error))
    throw invalid(file + " is a directory; give a case file in it");

  CaseUnderCheck checked;
  checked.read = case_file::read_file(file, checked.description);
  std::ifstream stream(file, std::ios::binary);
  checked.text.assign(std::istreambuf_iterator<char>(stream), {});
  apply(changes, checked);
  return checked;
}

CaseUnderCheck read_case_text(const std::string& text, const std::string& name,
                              const std::vector<v1::CaseChange>& changes) {
  CaseUnderCheck checked;
  checked.read = case_file::read_text(text, name, checked.description);
  checked.text = text;
  apply(changes, checked);
  return checked;
}

CaseUnderCheck read_case_elsewhere(const std::string& text, const std::string& name,
                                   const std::vector<v1::CaseChange>& changes) {
  CaseUnderCheck checked;
  checked.read = case_file::read_elsewhere(text, name, checked.description);
  checked.text = text;

  for (const std::string& file : checked.read.files) {
    v1::Fault& fault = checked.read.faults.emplace_back();
    fault.set_message(fmt::format("the case names the file {}, which is not part of it", file));
    fault.set_remedy("use dccast submit, which sends the files of a case with it");
  }
  apply(changes, checked);
  return checked;
}

CaseUnderCheck read_case_of_job(Connection& connection, const std::string& id,
                                const std::vector<v1::CaseChange>& changes) {
  const v1::Job job = connection.call(&Stub::GetJob, id);
  CaseUnderCheck checked =
      read_case_text(read_file_of_job(connection, id, "case.toml"), "the case of job " + id);

  // One by one, since a change of the job may stand on an earlier one of the same key.
  for (const v1::CaseChange& change : job.changes())
    if (!std::ranges::count(changes, change.key(), &v1::CaseChange::key)) apply({change}, checked);
  apply(changes, checked);
  return checked;
}

v1::SubmitJobRequest submission_of(const CaseUnderCheck& checked, Connection& connection) {
  constexpr std::size_t longest_file = 1 << 20;  // service.proto
  v1::SubmitJobRequest request;
  if (checked.text.size() <= longest_file) request.set_case_file(checked.text);
  put_case(checked, connection, request);
  return request;
}

std::vector<v1::Fault> merge_faults(const std::vector<v1::Fault>& local,
                                    const std::vector<v1::Fault>& remote) {
  std::vector<v1::Fault> merged = local;
  for (const v1::Fault& fault : remote)
    if (!known_locally(local, fault)) merged.push_back(fault);
  return merged;
}

void check_with_server(CaseUnderCheck& checked, Connection& connection) {
  if (cannot_be_judged(checked.faults)) return;
  const auto response = ask(connection, checked);
  if (!response) return;
  checked.faults =
      merge_faults(checked.faults, {response->faults().begin(), response->faults().end()});
  checked.warnings.assign(response->warnings().begin(), response->warnings().end());
  if (response->has_estimate() && checked.faults.empty()) checked.estimate = response->estimate();
  if (checked.faults.empty()) checked.findings = response->findings();
  if (response->has_complete()) checked.uncertain = case_file::uncertain_keys(response->complete());
  sort_by_place(checked);
}

v1::ValidateCaseResponse verdict_of(const grpc::Status& status) {
  v1::ValidateCaseResponse verdict;
  refusal::read_detail(status.error_details(), verdict);
  return verdict;
}

std::vector<v1::Fault> faults_of(const grpc::Status& status) {
  const v1::ValidateCaseResponse verdict = verdict_of(status);
  return {verdict.faults().begin(), verdict.faults().end()};
}

void print_faults(const CaseUnderCheck& checked, std::ostream& stream) {
  for (const v1::Fault& fault : checked.faults)
    stream << describe(fault, checked.read.source) << '\n';
  for (const v1::Fault& warning : checked.warnings)
    stream << "warning: " << describe(warning, checked.read.source) << '\n';
}

Json faults_json(const CaseUnderCheck& checked) {
  // Line and column are known to the client alone, which has the file.
  const auto placed = [&](const v1::Fault& fault) {
    return fault_json(fault, checked.read.source);
  };
  Json json{{"valid", checked.faults.empty()},
            {"faults", json_list(checked.faults, placed)},
            {"warnings", json_list(checked.warnings, placed)},
            {"findings", json_list(checked.findings, to_json)}};
  if (checked.estimate) json["estimate"] = to_json(*checked.estimate);
  json["uncertain"] =
      json_list(checked.uncertain, [](const case_file::UncertainKey& datum) -> Json {
        return {{"key", datum.key}, {"range", datum.range}, {"origin", datum.origin}};
      });
  return json;
}

}  // namespace dccast::client
