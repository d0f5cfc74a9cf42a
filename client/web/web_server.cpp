#include "client/web/web_server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>

#include "client/web/connect_messages.hpp"
#include "proto/http/target.hpp"

namespace dccast::client {
namespace {

/// Bodies hold calls of the service, which take messages of 2 MiB. Handlers wait for it.
/// The daemon has the limit of attachments, which is smaller.
constexpr http::Limits limits{.body_bytes = 2'200'000,
                              .upload_bytes = std::size_t{1} << 30,
                              .connections = 1024,
                              .handlers = 128};

http::Limits limits_of(bool is_behind_proxy) {
  http::Limits own = limits;
  if (is_behind_proxy) own.connections_of_address = own.connections;
  return own;
}

constexpr const char* policy = "Content-Security-Policy";
constexpr const char* set_cookie = "Set-Cookie";
constexpr const char* own_policy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src "
    "'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
constexpr const char* alone_policy =
    "sandbox allow-scripts allow-modals allow-downloads; default-src 'none'; script-src "
    "'unsafe-inline' data:; style-src "
    "'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// What a handler has thrown, as the status of a call.
grpc::Status status_of(const CommandFailed& failure) {
  const grpc::Status& call = failure.status();
  if (refusal_of(call)) return call;
  if (!call.ok()) return {call.error_code(), failure.what()};
  const auto code = failure.code() == ExitCode::invalid       ? grpc::INVALID_ARGUMENT
                    : failure.code() == ExitCode::not_found   ? grpc::NOT_FOUND
                    : failure.code() == ExitCode::wrong_state ? grpc::FAILED_PRECONDITION
                                                              : grpc::UNAVAILABLE;
  return {code, failure.what()};
}

std::unique_ptr<http::Server> server_for(const http::Server::Listening& at, bool is_behind_proxy) {
  try {
    return std::make_unique<http::Server>(at, limits_of(is_behind_proxy));
  } catch (const http::BadCertificate&) {
    // The library's message names neither option nor remedy.
    throw invalid(
        fmt::format("--certificate {}, --key {}: are not a certificate and its key; give "
                    "PEM files",
                    at.certificate, at.key));
  } catch (const http::CannotListen& error) {
    if (!at.socket.empty())
      throw invalid(
          fmt::format("--listen unix:{}: {}; give a path in a folder of this program's "
                      "user, where no other program listens",
                      at.socket, error.what()));
    throw invalid(
        fmt::format("{}:{}: is no address of this machine, or its port is taken by "
                    "another program; without a port, a free one is taken",
                    at.host, at.port));
  }
}

Reply answer_of(const WebServer::Handler& handler, const Request& request) {
  try {
    return handler(request);
  } catch (const CommandFailed& failure) {
    return error_reply(status_of(failure), "");
  } catch (const http::CutBody& cut) {
    return error_reply({grpc::INVALID_ARGUMENT, cut.what()}, "");
  } catch (const std::exception& error) {
    return error_reply({grpc::INTERNAL, error.what()}, "");
  }
}

bool has(const Reply& reply, const std::string& header) {
  return std::ranges::any_of(reply.headers,
                             [&](const auto& entry) { return entry.first == header; });
}

}  // namespace

std::string Request::value(const std::string& key) const {
  const auto found = query.find(key);
  return found == query.end() ? "" : found->second;
}

std::vector<std::string> Request::values(const std::string& key) const {
  std::vector<std::string> all;
  const auto [begin, end] = query.equal_range(key);
  for (auto at = begin; at != end; ++at) all.push_back(at->second);
  return all;
}

Reply page_alone(std::string html) {
  return {.body = std::move(html),
          .type = "text/html; charset=utf-8",
          .headers = {{policy, alone_policy}}};
}

WebServer::WebServer(const http::Server::Listening& listening, bool is_behind_proxy)
    : server_(server_for(listening, is_behind_proxy)) {}

void WebServer::serve(Entrance& entrance, Interruption& interruption) {
  server_->start([&](const std::string& host) { return entrance.is_own_name(host); },
                 [&](const http::Request& request) { return reply_to(request, entrance); });
  try {
    while (true) interruption.sleep(std::chrono::hours(1));
  } catch (const Interrupted&) {
    server_->stop();
  }
}

Reply WebServer::reply_to(const http::Request& received, Entrance& entrance) const {
  Request request{received};
  request.is_of_file = request.method == "GET" && files_.contains(request.path);
  auto refused = entrance.judge(request);
  Reply reply = refused ? std::move(*refused) : answer(request);

  if (!request.set_cookie.empty() && !has(reply, set_cookie))
    reply.headers.emplace_back(set_cookie, request.set_cookie);
  if (!has(reply, policy)) reply.headers.emplace_back(policy, own_policy);
  for (const auto& header :
       {std::pair{"X-Content-Type-Options", "nosniff"}, std::pair{"Referrer-Policy", "no-referrer"},
        std::pair{"Cross-Origin-Opener-Policy", "same-origin"},
        std::pair{"Cross-Origin-Resource-Policy", "same-origin"},
        std::pair{"Cache-Control", "no-store"}})
    reply.headers.emplace_back(header);
  return reply;
}

Reply WebServer::answer(Request& request) const {
  if (request.is_of_file) return files_.at(request.path);

  auto found = answers_.find(request.method + " " + request.path);
  // "/jobs/7/report" is answered by "/jobs/*/report", with the name "7".
  for (std::size_t begin = request.path.find('/'), end = 0;
       found == answers_.end() && begin != std::string::npos; begin = end) {
    end = request.path.find('/', ++begin);
    const std::string name = request.path.substr(begin, end - begin);
    std::string path = request.path;
    found = answers_.find(request.method + " " + path.replace(begin, name.size(), "*"));
    request.name = http::decoded(name);
  }
  if (found == answers_.end()) return {.body = "There is no such page.\n", .status = 404};
  return answer_of(found->second, request);
}

}  // namespace dccast::client
