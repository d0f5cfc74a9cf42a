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

http::Reply answer_of(const WebServer::Handler& handler, const Request& request) {
  Reply reply;
  try {
    reply = handler(request);
  } catch (const CommandFailed& failure) {
    reply = error_reply(status_of(failure), "");
  } catch (const http::CutBody& cut) {
    reply = error_reply({grpc::INVALID_ARGUMENT, cut.what()}, "");
  } catch (const std::exception& error) {
    reply = error_reply({grpc::INTERNAL, error.what()}, "");
  }
  http::Reply sent{.body = std::move(reply.body),
                   .type = std::move(reply.type),
                   .status = reply.status,
                   .headers = std::move(reply.headers),
                   .stream = std::move(reply.stream)};
  if (reply.stands_alone) sent.headers.emplace_back(policy, alone_policy);
  if (!reply.set_cookie.empty()) sent.headers.emplace_back(set_cookie, reply.set_cookie);
  return sent;
}

bool has(const http::Reply& reply, const std::string& header) {
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

class WebServer::Parts {
public:
  Parts(const http::Server::Listening& listening, bool is_behind_proxy)
      : server_(server_for(listening, is_behind_proxy)) {}

  const http::Server& server() const { return *server_; }

  using Answer = std::function<http::Reply(const Request&)>;
  void add(const std::string& method, const std::string& path, Answer answer) {
    answers_[method + " " + path] = std::move(answer);
  }
  void add_file(const std::string& path, const http::Reply& reply) { files_[path] = reply; }

  void serve(Entrance& entrance, Interruption& interruption) {
    server_->start([&](const std::string& host) { return entrance.is_own_name(host); },
                   [&](const http::Request& request) { return reply_to(request, entrance); });
    try {
      while (true) interruption.sleep(std::chrono::hours(1));
    } catch (const Interrupted&) {
      server_->stop();
    }
  }

private:
  http::Reply reply_to(const http::Request& received, Entrance& entrance) {
    Request request{received};
    request.is_of_file = request.method == "GET" && files_.contains(request.path);
    auto refused = entrance.judge(request);
    http::Reply reply = refused ? std::move(*refused) : answer(request);

    if (!request.set_cookie.empty() && !has(reply, set_cookie))
      reply.headers.emplace_back(set_cookie, request.set_cookie);
    if (!has(reply, policy)) reply.headers.emplace_back(policy, own_policy);
    for (const auto& header : {std::pair{"X-Content-Type-Options", "nosniff"},
                               std::pair{"Referrer-Policy", "no-referrer"},
                               std::pair{"Cross-Origin-Opener-Policy", "same-origin"},
                               std::pair{"Cross-Origin-Resource-Policy", "same-origin"},
                               std::pair{"Cache-Control", "no-store"}})
      reply.headers.emplace_back(header);
    return reply;
  }

  http::Reply answer(Request& request) const {
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
    return found->second(request);
  }

  std::unique_ptr<http::Server> server_;
  std::map<std::string, http::Reply> files_;  // by path
  std::map<std::string, Answer> answers_;     // by method and path
};

WebServer::WebServer(const http::Server::Listening& listening, bool is_behind_proxy)
    : parts_(std::make_unique<Parts>(listening, is_behind_proxy)) {}
WebServer::~WebServer() = default;

void WebServer::file(const std::string& path, const std::string& type, const std::string& text) {
  parts_->add_file(path, {.body = text, .type = type});
}

void WebServer::answer(const std::string& method, const std::string& path, Handler handler) {
  parts_->add(method, path, [handler = std::move(handler)](const Request& request) {
    return answer_of(handler, request);
  });
}

const http::Server& WebServer::server() const {
  return parts_->server();
}

void WebServer::serve(Entrance& entrance, Interruption& interruption) {
  parts_->serve(entrance, interruption);
}

}  // namespace dccast::client
