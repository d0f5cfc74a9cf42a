#include "client/job_id.hpp"

#include <algorithm>
#include <set>

#include <pwd.h>
#include <unistd.h>

namespace dccast::client {
namespace {

constexpr std::size_t id_length = 36;
constexpr std::size_t shortest = 8;
constexpr int most_candidates = 5;  // that are listed

bool can_begin_an_id(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789abcdef-") == std::string::npos;
}

std::string user_name() {
  const passwd* const user = ::getpwuid(::getuid());
  return user == nullptr ? "" : user->pw_name;
}

/// The server calls the owner by the name of the local user; over a tunnel that may be another one.
std::string last_job(Connection& connection) {
  v1::ListJobsRequest request;
  request.set_page_size(1);
  request.set_owner(user_name());
  const auto found = connection.call(&Stub::ListJobs, request);
  if (found.jobs().empty())
    throw CommandFailed(ExitCode::not_found, "'last': no job on " + connection.server() +
                                                 " belongs to " + user_name() +
                                                 "; name one by its id (dccast list)");
  return found.jobs(0).id();
}

std::string ambiguous(const std::string& prefix, const v1::ListJobsResponse& found) {
  std::string text = "'" + prefix + "' is the beginning of more than one job:";
  for (int i = 0; i < std::min(most_candidates, found.jobs_size()); ++i)
    text += "\n  " + found.jobs(i).id() + "  " + found.jobs(i).title();
  if (found.jobs_size() > most_candidates) text += "\n  and more";
  return text;
}

std::string job_that_begins(Connection& connection, const std::string& prefix) {
  v1::ListJobsRequest request;
  request.set_page_size(most_candidates + 1);
  request.set_id_prefix(prefix);
  const auto found = connection.call(&Stub::ListJobs, request);
  if (found.jobs().empty())
    throw CommandFailed(ExitCode::not_found, "no job on " + connection.server() + " begins with '" +
                                                 prefix + "' (dccast list)");
  if (found.jobs_size() > 1) throw CommandFailed(ExitCode::invalid, ambiguous(prefix, found));
  return found.jobs(0).id();
}

}  // namespace

std::string resolve_job(Connection& connection, const std::string& text) {
  if (text == "last") return last_job(connection);
  if (text.size() < id_length && can_begin_an_id(text)) return job_that_begins(connection, text);
  return text;
}

std::vector<std::string> resolve_jobs(Connection& connection,
                                      const std::vector<std::string>& texts) {
  std::vector<std::string> ids;
  for (const std::string& text : texts) ids.push_back(resolve_job(connection, text));
  return ids;
}

std::size_t short_id_length(const std::vector<std::string>& ids) {
  for (std::size_t length = shortest; length < id_length; ++length) {
    std::set<std::string> beginnings;
    for (const std::string& id : ids) beginnings.insert(id.substr(0, length));
    if (beginnings.size() == ids.size()) return length;
  }
  return id_length;
}

}  // namespace dccast::client
