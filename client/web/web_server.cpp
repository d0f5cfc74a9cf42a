#include "client/web/web_server.hpp"

#include <httplib.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

#include "client/model/json.hpp"
#include "client/session/socket.hpp"
#include "client/web/entrance.hpp"

namespace dccast::client::web {
namespace {

constexpr int most_threads = 64;            // a live page keeps one for its events
constexpr std::size_t most_body = 1 << 20;  // [bytes] of what a page sends

std::string fault(const std::string& text) {
  return Json{{"error", text}}.dump();
}

Request request_of(const httplib::Request& from) {
  Request request;
  if (from.matches.size() > 1) request.name = httplib::detail::decode_url(from.matches[1], false);
  request.query = from.params;
  request.body = from.body;
  return request;
}

constexpr const char* policy = "Content-Security-Policy";
constexpr const char* own_policy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src "
    "'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
constexpr const char* alone_policy =
    "sandbox allow-scripts allow-modals; default-src 'none'; script-src 'unsafe-inline'; style-src "
    "'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

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

std::unique_ptr<httplib::Server> server_for(const Listening& listening) {
  if (listening.certificate.empty()) return std::make_unique<httplib::Server>();
  auto server =
      std::make_unique<httplib::SSLServer>(listening.certificate.c_str(), listening.key.c_str());
  if (!server->is_valid())
    throw CommandFailed(ExitCode::invalid,
                        "--certificate " + listening.certificate + ", --key " + listening.key +
                            ": are not a certificate and its key; give PEM files");
  return server;
}

const X509* certificate_of(const httplib::Server& server) {
  const auto* tls = dynamic_cast<const httplib::SSLServer*>(&server);
  return tls == nullptr ? nullptr : SSL_CTX_get0_certificate(tls->ssl_context());
}

int bound(httplib::Server& server, const Listening& listening) {
  const int port = listening.port == 0 ? server.bind_to_any_port(listening.host)
                   : server.bind_to_port(listening.host, listening.port) ? listening.port
                                                                         : -1;
  if (port > 0) return port;
  throw CommandFailed(ExitCode::invalid,
                      listening.host + ":" + std::to_string(listening.port) +
                          ": is no address of this machine, or its port is taken by another "
                          "program; without a port, a free one is taken");
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
        entrance_(named(listening.host), bound(*server_, listening), certificate_of(*server_)) {
    server_->new_task_queue = [] { return new httplib::ThreadPool(most_threads); };
    server_->set_payload_max_length(most_body);
    server_->set_keep_alive_timeout(1);
    server_->set_tcp_nodelay(true);
    server_->set_pre_routing_handler([this](const auto& request, auto& response) {
      return admit(request, response) ? httplib::Server::HandlerResponse::Unhandled
                                      : httplib::Server::HandlerResponse::Handled;
    });
    server_->set_post_routing_handler([](const auto&, auto& response) {
      if (!response.has_header(policy)) response.set_header(policy, own_policy);
    });
    if (!entrance_.knows_itself())
      throw CommandFailed(ExitCode::invalid, "--certificate " + listening.certificate +
                                                 ": is not for " + named(listening.host) +
                                                 "; give --listen a name that stands in it");
  }

  std::string address() { return entrance_.address(); }
  httplib::Server& server() { return *server_; }

private:
  static std::string named(const std::string& host) {
    return host == "0.0.0.0" || host == "::" ? name_of_this_machine() : host;
  }

  /// Sets the headers of every reply. @return false: this one is complete
  bool admit(const httplib::Request& request, httplib::Response& response) {
    response.set_header("X-Content-Type-Options", "nosniff");
    response.set_header("Referrer-Policy", "no-referrer");
    response.set_header("Cross-Origin-Opener-Policy", "same-origin");
    response.set_header("Cross-Origin-Resource-Policy", "same-origin");
    response.set_header("Cache-Control", "no-store");
    const auto decision = entrance_.decide({.host = request.get_header_value("Host"),
                                            .origin = request.get_header_value("Origin"),
                                            .cookies = request.get_header_value("Cookie"),
                                            .key = request.get_param_value("key"),
                                            .changes = request.method != "GET",
                                            .is_first_page = request.path == "/"});
    if (decision.admitted) return true;
    if (decision.cookie.empty()) {
      response.status = 403;
      response.set_content(decision.refusal + "\n", "text/plain; charset=utf-8");
    } else {
      response.set_header("Set-Cookie", decision.cookie);
      response.set_redirect("/");
    }
    return false;
  }

  std::unique_ptr<httplib::Server> server_;
  Entrance entrance_;
};

WebServer::WebServer(const Listening& listening) : parts_(std::make_unique<Parts>(listening)) {}
WebServer::~WebServer() = default;

void WebServer::file(const std::string& path, const std::string& type, const std::string& text) {
  parts_->server().Get(path, [type, text](const httplib::Request&, httplib::Response& response) {
    response.set_content(text, type.c_str());
  });
}

namespace {

httplib::Server::Handler answering(WebServer::Handler handler) {
  return
      [handler = std::move(handler)](const httplib::Request& asked, httplib::Response& response) {
        Reply reply;
        try {
          reply = handler(request_of(asked));
        } catch (const CommandFailed& error) {
          reply = {.body = fault(error.what()), .status = status_of(error.code())};
        } catch (const std::exception& error) {
          reply = {.body = fault(error.what()), .status = 500};
        }
        response.status = reply.status;
        if (reply.stands_alone) response.set_header(policy, alone_policy);
        response.set_content(reply.body, reply.type.c_str());
      };
}

std::string with_name(const std::string& path) {
  return path + "/([^/]*)";
}

/// Server-sent events of a source that runs in a thread of its own, on their way to the browser.
/// The thread ends with this object.
class EventStream {
public:
  explicit EventStream(Source source)
      : thread_([this, source = std::move(source)] { run(source); }) {}
  ~EventStream() {
    change([this] { left_ = true; });
    gone_->come();
    thread_.join();
  }
  EventStream(const EventStream&) = delete;

  /// What is to be written next: all events that wait, or a comment after a while without any.
  /// @return empty at the end
  std::string take() {
    // At this interval a comment shows whether the browser is still there, and a server that stops
    // is noticed.
    constexpr std::chrono::milliseconds pulse{500};
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, pulse, [&] { return ended_ || !waiting_.empty(); });
    std::string text;
    for (const std::string& event : waiting_) text += event;
    waiting_.clear();
    if (text.empty() && !ended_) text = ": still here\n\n";
    changed_.notify_all();
    return text;
  }

private:
  /// Waits while the browser has many to take. Throws Interrupted once it has gone.
  void put(std::string text) {
    constexpr std::size_t most_waiting = 1000;  // events that a slow browser has not taken
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return left_ || waiting_.size() < most_waiting; });
    if (left_) throw Interrupted("");
    waiting_.push_back(std::move(text));
    changed_.notify_all();
  }

  template <class Change>
  void change(const Change& what) {
    const std::lock_guard lock(mutex_);
    what();
    changed_.notify_all();
  }

  void run(const Source& source) {
    try {
      try {
        source(gone_, [&](const std::string& json) { put("data: " + json + "\n\n"); });
      } catch (const Interrupted&) {
        throw;
      } catch (const std::exception& error) {
        put("event: fault\ndata: " + fault(error.what()) + "\n\n");
      }
    } catch (const Interrupted&) {
    }
    change([this] { ended_ = true; });
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::string> waiting_;
  bool ended_ = false, left_ = false;
  std::shared_ptr<Interruption> gone_ = std::make_shared<Interruption>();
  std::thread thread_;  // last: it uses the others
};

}  // namespace

void WebServer::get(const std::string& path, Handler handler) {
  parts_->server().Get(with_name(path), answering(std::move(handler)));
}

void WebServer::post(const std::string& path, Handler handler) {
  parts_->server().Post(with_name(path), answering(std::move(handler)));
}

void WebServer::events(const std::string& path, SourceOf source) {
  parts_->server().Get(with_name(path), [source = std::move(source)](const httplib::Request& asked,
                                                                     httplib::Response& response) {
    const auto stream = std::make_shared<EventStream>(source(request_of(asked)));
    response.set_chunked_content_provider(
        "text/event-stream", [stream](std::size_t, httplib::DataSink& sink) {
          const std::string text = stream->take();
          if (text.empty()) sink.done();
          return text.empty() || sink.write(text.data(), text.size());
        });
  });
}

std::string WebServer::address() {
  return parts_->address();
}

void WebServer::serve(Interruption& interruption) {
  std::thread watch([&] {
    try {
      while (true) interruption.sleep(std::chrono::hours(1));
    } catch (const Interrupted&) {
      parts_->server().stop();
    }
  });
  parts_->server().listen_after_bind();
  watch.join();
}

}  // namespace dccast::client::web
