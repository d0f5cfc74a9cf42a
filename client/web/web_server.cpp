#include "client/web/web_server.hpp"

#include <fmt/format.h>

#include <chrono>
#include <map>

#include "client/model/json.hpp"
#include "client/session/socket.hpp"
#include "client/web/entrance.hpp"
#include "proto/http/server.hpp"
#include "proto/http/target.hpp"

namespace dccast::client {
namespace {

/// Bodies hold calls of the service, which take messages of 2 MiB.
constexpr http::Limits limits{.body_bytes = 2'200'000, .connections = 1024, .handlers = 32};

std::string fault(const std::string& text) {
  return Json{{"error", text}}.dump();
}

constexpr const char* policy = "Content-Security-Policy";
constexpr const char* own_policy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src "
    "'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
constexpr const char* alone_policy =
    "sandbox allow-scripts allow-modals allow-downloads; default-src 'none'; script-src "
    "'unsafe-inline' data:; style-src "
    "'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// A browser sends a strict cookie only from a page of this origin, not with the redirection that
/// sets it if another page, such as a file, led there. This page therefore forwards to the first
/// page; its script keeps the fragment, which names the page to show.
constexpr const char* threshold_path = "/entered";
constexpr const char* threshold_page =
    "<!DOCTYPE html>\n<meta charset=\"utf-8\">\n<title>dccast</title>\n"
    "<script src=\"/entered.js\"></script>\n"
    "<noscript><meta http-equiv=\"refresh\" content=\"0; url=/\"></noscript>\n";

int status_of(ExitCode code) {
  switch (code) {
    case ExitCode::invalid:
      return 400;
    case ExitCode::not_found:
      return 404;
    case ExitCode::wrong_state:
      return 409;
    default:
      return 502;  // the server of the jobs, not this one
  }
}

std::unique_ptr<http::Server> server_for(const Listening& at) {
  try {
    return std::make_unique<http::Server>(
        http::Server::Listening{
            .host = at.host, .port = at.port, .certificate = at.certificate, .key = at.key},
        limits);
  } catch (const http::BadCertificate&) {
    // The library's message names neither option nor remedy.
    throw CommandFailed(ExitCode::invalid,
                        fmt::format("--certificate {}, --key {}: are not a certificate and its "
                                    "key; give PEM files",
                                    at.certificate, at.key));
  } catch (const http::CannotListen&) {
    throw CommandFailed(ExitCode::invalid,
                        fmt::format("{}:{}: is no address of this machine, or its port is taken by "
                                    "another program; without a port, a free one is taken",
                                    at.host, at.port));
  }
}

http::Reply answer_of(const WebServer::Handler& handler, const Request& request) {
  Reply reply;
  try {
    reply = handler(request);
  } catch (const CommandFailed& error) {
    reply = {.body = fault(error.what()), .status = status_of(error.code())};
  } catch (const std::exception& error) {
    reply = {.body = fault(error.what()), .status = 500};
  }
  return {.body = std::move(reply.body),
          .type = std::move(reply.type),
          .status = reply.status,
          .headers = {{policy, reply.stands_alone ? alone_policy : own_policy}},
          .stream = std::move(reply.stream)};
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
  explicit Parts(const Listening& listening)
      : server_(server_for(listening)),
        entrance_(named(listening.host), server_->port(), server_->certificate()) {
    if (!entrance_.knows_itself())
      throw CommandFailed(ExitCode::invalid,
                          fmt::format("--certificate {}: is not for {}; give --listen a name that "
                                      "stands in it",
                                      listening.certificate, named(listening.host)));
  }

  /// @param path  of a file, or "/report/" for "/report/NAME"
  using Answer = std::function<http::Reply(const Request&)>;
  void add(const std::string& method, const std::string& path, Answer answer) {
    answers_[method + " " + path] = std::move(answer);
  }

  std::string address() { return entrance_.address(); }
  void when_entered(std::function<void()> call) { when_entered_ = std::move(call); }

  void serve(Interruption& interruption) {
    server_->start([this](const std::string& host) { return entrance_.is_own_name(host); },
                   [this](const http::Request& request) { return reply_to(request); });
    try {
      while (true) interruption.sleep(std::chrono::hours(1));
    } catch (const Interrupted&) {
      server_->stop();
    }
  }

private:
  static std::string named(const std::string& host) {
    return host == "0.0.0.0" || host == "::" ? host_name() : host;
  }

  http::Reply reply_to(const http::Request& request) {
    http::Reply reply = admitted_reply(request);
    for (const auto& header : {std::pair{"X-Content-Type-Options", "nosniff"},
                               std::pair{"Referrer-Policy", "no-referrer"},
                               std::pair{"Cross-Origin-Opener-Policy", "same-origin"},
                               std::pair{"Cross-Origin-Resource-Policy", "same-origin"},
                               std::pair{"Cache-Control", "no-store"}})
      reply.headers.emplace_back(header);
    return reply;
  }

  http::Reply admitted_reply(const http::Request& request) {
    if (request.path == threshold_path)
      return {.body = threshold_page,
              .type = "text/html; charset=utf-8",
              .headers = {{policy, own_policy}}};

    const auto key = request.query.find("key");
    const auto decision = entrance_.decide({.host = request.header("host"),
                                            .origin = request.header("origin"),
                                            .cookies = request.header("cookie"),
                                            .key = key == request.query.end() ? "" : key->second,
                                            .changes = request.method != "GET",
                                            .is_first_page = request.path == "/"});
    if (decision.admitted) return answer(request);

    // Neither a session nor a key that gives one.
    if (decision.cookie.empty())
      return {.body = decision.refusal + "\n", .status = 403, .headers = {{policy, own_policy}}};
    when_entered_();
    return {
        .status = 302,
        .headers = {
            {"Set-Cookie", decision.cookie}, {"Location", threshold_path}, {policy, own_policy}}};
  }

  /// Each file has its own path; "/report/7" is answered by "/report/" for the name "7".
  http::Reply answer(const http::Request& request) const {
    const auto name_at = request.path.rfind('/') + 1;
    auto found = answers_.find(request.method + " " + request.path);
    if (found == answers_.end() && name_at > 1)
      found = answers_.find(request.method + " " + request.path.substr(0, name_at));

    if (found == answers_.end())
      return {.body = "There is no such page.\n", .status = 404, .headers = {{policy, own_policy}}};
    return found->second(Request{{request}, http::decoded(request.path.substr(name_at))});
  }

  std::unique_ptr<http::Server> server_;
  Entrance entrance_;
  std::map<std::string, Answer> answers_;
  std::function<void()> when_entered_ = [] {};
};

WebServer::WebServer(const Listening& listening) : parts_(std::make_unique<Parts>(listening)) {}
WebServer::~WebServer() = default;

void WebServer::file(const std::string& path, const std::string& type, const std::string& text) {
  parts_->add("GET", path, [type, text](const Request&) {
    return http::Reply{.body = text, .type = type, .headers = {{policy, own_policy}}};
  });
}

void WebServer::get(const std::string& path, Handler handler) {
  parts_->add("GET", path + "/", [handler = std::move(handler)](const Request& request) {
    return answer_of(handler, request);
  });
}

void WebServer::post(const std::string& path, Handler handler) {
  parts_->add("POST", path + "/", [handler = std::move(handler)](const Request& request) {
    return answer_of(handler, request);
  });
}

std::string WebServer::address() {
  return parts_->address();
}

void WebServer::when_entered(std::function<void()> call) {
  parts_->when_entered(std::move(call));
}

void WebServer::serve(Interruption& interruption) {
  parts_->serve(interruption);
}

}  // namespace dccast::client
