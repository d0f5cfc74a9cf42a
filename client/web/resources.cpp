#include "client/web/resources.hpp"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <limits>
#include <optional>
#include <sstream>

#include "client/html/frame_bytes.hpp"
#include "client/html/pages.hpp"
#include "client/session/byte_call.hpp"
#include "client/session/jobs.hpp"
#include "client/session/studies.hpp"
#include "client/session/uploads.hpp"
#include "client/text/job_csv.hpp"
#include "client/web/connect_messages.hpp"
#include "proto/values/digests.hpp"

namespace dccast::client {
namespace {

constexpr const char* bytes_type = "application/octet-stream";

/// A whole number of a request. Throws CommandFailed.
/// @param name  of what it is, for the message
std::int64_t number_in(const std::string& text, const std::string& name, std::int64_t most) {
  std::int64_t number = -1;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, number);
  if (error == std::errc() && rest == end && number >= 0 && number <= most) return number;
  throw invalid(fmt::format("{} = {}: permitted: 0 to {}; give a whole number", name, text, most));
}

std::string job_named(Connection& connection, const Request& request) {
  return resolve_job(connection, request.name);
}

// ---- Pages and frames

Reply report(Connection& connection, const Request& request) {
  // The page itself states what is missing in it.
  std::ostringstream unused_messages;
  grpc::Status unused_status;
  const v1::Job job = connection.call(&Stub::GetJob, job_named(connection, request));
  return page_alone(report_of(connection, job, unused_messages, unused_status));
}

Reply frame(Connection& connection, const Request& request) {
  const std::string number = request.value("number"), field = request.value("field");
  constexpr std::int64_t most = std::numeric_limits<int>::max();
  const auto result =
      stored_frame(connection, job_named(connection, request),
                   number.empty() ? 0 : static_cast<int>(number_in(number, "number", most)), field);
  if (!field.empty())
    return {.body = float_bytes(result.frame().field().values(), Precision::full),
            .type = bytes_type};

  auto bytes = frame_bytes(result.frame(), Precision::full);
  if (!bytes) throw invalid("the stored frame is damaged and cannot be drawn");
  return {.body = std::move(*bytes), .type = bytes_type};
}

// ---- Tables

/// A spreadsheet states user and token; the token alone tells the daemon who it is.
void check_user(Connection& connection, const Request& request) {
  if (request.user.empty()) return;
  if (connection.call(&Stub::WhoAmI, v1::WhoAmIRequest()).name() == request.user) return;
  throw CommandFailed(ExitCode::not_found, "",
                      {grpc::UNAUTHENTICATED, "the token is of another user than " + request.user +
                                                  "; give the name of the user whose token it is"});
}

Reply table(std::string csv) {
  return {.body = std::move(csv), .type = "text/csv; charset=utf-8"};
}

Reply curl_table(Connection& connection, const Request& request) {
  check_user(connection, request);
  JobCurl curl = curl_of_job(connection, job_named(connection, request));
  curl.study = refinement_of(connection, curl.job);
  return table(curl_csv(curl));
}

v1::JobState state_of(std::string name) {
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::toupper(c); });
  v1::JobState state{};
  if (v1::JobState_Parse(name, &state) && state != v1::JOB_STATE_UNSPECIFIED) return state;
  throw invalid(fmt::format(
      "state = {}: permitted: queued, running, paused, succeeded, failed or cancelled", name));
}

Reply jobs_table(Connection& connection, const Request& request) {
  constexpr int usual = 1000, most = 100'000;
  check_user(connection, request);
  v1::ListJobsRequest wanted;
  for (const std::string& state : request.values("state")) wanted.add_states(state_of(state));
  for (const std::string& label : request.values("label")) wanted.add_labels(label);
  wanted.set_owner(request.value("owner"));
  wanted.set_study(request.value("study"));
  wanted.set_title(request.value("title"));

  const std::string limit = request.value("limit");
  return table(
      jobs_csv(list_jobs(connection, wanted,
                         limit.empty() ? usual : static_cast<int>(number_in(limit, "limit", most)))
                   .jobs));
}

// ---- Results

/// The first byte that is wanted of a file, from `Range: bytes=N-`. Other ranges are not known:
/// they get the whole file, as HTTP permits.
std::int64_t first_byte(const Request& request) {
  constexpr std::string_view unit = "bytes=";
  const std::string range = request.header("range");
  if (!range.starts_with(unit) || !range.ends_with('-')) return 0;
  return number_in(range.substr(unit.size(), range.size() - unit.size() - 1), "Range",
                   std::numeric_limits<std::int64_t>::max());
}

/// The first part of a result file.
v1::FetchResultResponse first_part(Connection& connection, const v1::FetchResultRequest& wanted) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(1));
  const auto reader = connection.stub().FetchResult(&context, wanted);
  v1::FetchResultResponse part;
  const bool has_come = reader->Read(&part);
  if (has_come) context.TryCancel();
  const grpc::Status status = reader->Finish();
  if (!has_come) check(status, connection.server());
  return part;
}

/// Writes a file from a part of it on. It ends early if another file has taken its place: the reply
/// then has fewer bytes than it has stated.
void write_rest(const std::shared_ptr<grpc::Channel>& channel, v1::FetchResultRequest wanted,
                const v1::FetchResultResponse& part, const std::shared_ptr<void>& place,
                const std::shared_ptr<http::Stream>& stream) {
  wanted.set_offset(part.offset() + static_cast<std::int64_t>(part.data().size()));
  const auto received = [stream, sha256 = part.sha256()](const std::string& bytes, auto next) {
    v1::FetchResultResponse response;
    if (!response.ParseFromString(bytes) || response.sha256() != sha256) return next(false);
    if (response.data().empty()) return next(true);
    stream->write(std::move(*response.mutable_data()), std::move(next));
  };
  stream->when_left(
      begin_call(channel, {.method = *find_method("FetchResult"),
                           .requests = {wanted.SerializeAsString()},
                           .deadline = std::chrono::system_clock::time_point::max(),
                           .received = received,
                           .ended = [stream, place](const grpc::Status&) { stream->end(); }}));
}

Reply result_file(Connection& connection, const Request& request) {
  v1::FetchResultRequest wanted;
  wanted.set_id(job_named(connection, request));
  wanted.set_offset(first_byte(request));
  v1::FetchResultResponse part = first_part(connection, wanted);

  const std::string tag = "\"" + part.sha256() + "\"";
  Reply reply{.body = {}, .type = "application/x-hdf5", .headers = {{"ETag", tag}}};
  if (request.header("if-none-match") == tag) {
    reply.status = 304;
    return reply;
  }

  const std::int64_t rest = part.total_size_bytes() - part.offset();
  reply.headers.emplace_back("Accept-Ranges", "bytes");
  reply.headers.emplace_back("Content-Length", std::to_string(rest));
  if (part.offset() > 0) {
    reply.status = 206;
    reply.headers.emplace_back(
        "Content-Range", fmt::format("bytes {}-{}/{}", part.offset(), part.total_size_bytes() - 1,
                                     part.total_size_bytes()));
  }

  reply.stream = [channel = connection.channel(), wanted, part = std::move(part), rest,
                  place = request.place](const std::shared_ptr<http::Stream>& stream) {
    const bool is_whole = static_cast<std::int64_t>(part.data().size()) == rest;
    stream->write(part.data(), [=](bool sent) {
      if (sent && is_whole) stream->end();
      if (sent && !is_whole) write_rest(channel, wanted, part, place, stream);
    });
  };
  return reply;
}

// ---- Files of cases

Reply attachment(Connection& connection, const Request& request) {
  const std::string size = request.header("content-length");
  if (!values::is_sha256(request.name))
    throw invalid("/attachments/" + request.name +
                  ": permitted: the SHA-256 of the file, 64 hexadecimal digits in lower case; take "
                  "that of sha256sum");
  if (size.empty())
    throw invalid("Content-Length is missing; send the file with its size, not in chunks");

  v1::Attachment named;
  named.set_name(request.value("name").empty() ? request.name : request.value("name"));
  named.set_sha256(request.name);
  named.set_size_bytes(number_in(size, "Content-Length", std::numeric_limits<std::int64_t>::max()));
  v1::UploadAttachmentResponse response;
  check(upload_parts(connection, named, request.next_part, response), connection.server());
  return json_reply(to_json(response).dump());
}

}  // namespace

v1::QueryResultResponse stored_frame(Connection& connection, const std::string& id, int number,
                                     const std::string& field) {
  v1::QueryResultRequest request;
  request.set_id(id);
  request.set_frame(true);
  request.set_drawing(true);
  request.set_frame_number(number);
  request.set_field(field);
  request.set_page_size(1);
  return connection.call(&Stub::QueryResult, request);
}

void add_resources(WebServer& server, const Connect& connect) {
  server.get("/jobs.csv", connected(connect, jobs_table));
  server.get("/jobs/*/report", connected(connect, report));
  server.get("/jobs/*/results.h5", connected(connect, result_file));
  server.get("/jobs/*/curl.csv", connected(connect, curl_table));
  server.get("/jobs/*/frame", connected(connect, frame));
  server.put("/attachments/*", connected(connect, attachment));
}

}  // namespace dccast::client
