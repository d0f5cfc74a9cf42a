#include "client/web/web_server.hpp"

#include <httplib.h>
#include <openssl/crypto.h>
#include <openssl/rand.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <set>
#include <thread>

#include "client/model/json.hpp"

namespace dccast::client::web {
namespace {

constexpr int most_threads = 64;            // a live page keeps one for its events
constexpr std::size_t most_body = 1 << 20;  // [bytes] of what a page sends
constexpr std::size_t most_keys = 16;       // that are waiting to be used
constexpr std::size_t most_waiting = 1000;  // events that a slow browser has not taken
// So often a comment tells whether the browser is still there, and a server that stops is noticed.
constexpr std::chrono::milliseconds pulse{500};

/// 256 random bits in hexadecimal digits.
std::string secret() {
  std::array<unsigned char, 32> bytes;
  if (RAND_bytes(bytes.data(), bytes.size()) != 1)
    throw CommandFailed(ExitCode::invalid, "no random numbers are to be had for the session's key");
  std::string text;
  for (const unsigned char byte : bytes)
    for (const int digit : {byte >> 4, byte & 15}) text += "0123456789abcdef"[digit];
  return text;
}

/// In a time that does not depend on where they differ.
bool equal(const std::string& a, const std::string& b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

/// The value of a cookie; empty: there is none.
std::string cookie(const httplib::Request& request, const std::string& name) {
  const std::string all = "; " + request.get_header_value("Cookie");
  const std::string begin = "; " + name + "=";
  const auto at = all.find(begin);
  if (at == std::string::npos) return {};
  const auto from = at + begin.size();
  return all.substr(from, all.find(';', from) - from);
}

std::string fault(const std::string& text) {
  return Json{{"error", text}}.dump();
}

/// Events on their way from their source to the browser.
class Mailbox {
public:
  /// Waits while the browser has many to take. Throws Interrupted once it has gone.
  void put(std::string text) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return gone_ || waiting_.size() < most_waiting; });
    if (gone_) throw Interrupted("");
    waiting_.push_back(std::move(text));
    changed_.notify_all();
  }
  void end() {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_all();
  }
  void leave() {
    const std::lock_guard lock(mutex_);
    gone_ = true;
    changed_.notify_all();
  }
  /// All that wait, or a comment after a while without any. @return false at the end
  bool take(std::string& text) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, pulse, [&] { return ended_ || !waiting_.empty(); });
    text.clear();
    for (const std::string& event : waiting_) text += event;
    waiting_.clear();
    if (text.empty() && !ended_) text = ": still here\n\n";
    changed_.notify_all();
    return !text.empty();
  }

private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::string> waiting_;
  bool ended_ = false, gone_ = false;
};

/// A source of events with its thread. It ends with the response that carries them.
class Stream {
public:
  Stream(const WebServer::Source& source, Request request)
      : thread_([this, source, request = std::move(request)] { run(source, request); }) {}
  ~Stream() {
    box_.leave();
    gone_->come();
    thread_.join();
  }
  bool write(httplib::DataSink& sink) {
    std::string text;
    if (box_.take(text)) return sink.write(text.data(), text.size());
    sink.done();
    return true;
  }

private:
  void run(const WebServer::Source& source, const Request& request) {
    try {
      source(request, gone_, [&](const std::string& json) { box_.put("data: " + json + "\n\n"); });
    } catch (const Interrupted&) {
    } catch (const std::exception& error) {
      try {
        box_.put("event: fault\ndata: " + fault(error.what()) + "\n\n");
      } catch (const Interrupted&) {
      }
    }
    box_.end();
  }

  Mailbox box_;
  std::shared_ptr<Interruption> gone_ = std::make_shared<Interruption>();
  std::thread thread_;  // last: it uses the others
};

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
  explicit Parts(int port) : session_(secret()) {
    server_.new_task_queue = [] { return new httplib::ThreadPool(most_threads); };
    server_.set_payload_max_length(most_body);
    server_.set_keep_alive_timeout(1);
    server_.set_tcp_nodelay(true);
    server_.set_pre_routing_handler([this](const auto& request, auto& response) {
      return admit(request, response) ? httplib::Server::HandlerResponse::Unhandled
                                      : httplib::Server::HandlerResponse::Handled;
    });
    server_.set_post_routing_handler([](const auto&, auto& response) {
      if (!response.has_header(policy)) response.set_header(policy, own_policy);
    });
    port_ = port == 0 ? server_.bind_to_any_port(host_) : port;
    if (port_ < 0 || (port != 0 && !server_.bind_to_port(host_, port)))
      throw CommandFailed(ExitCode::invalid,
                          "--port " + std::to_string(port) +
                              ": is taken by another program; leave --port out for a free one");
  }

  std::string address() {
    const std::lock_guard lock(mutex_);
    if (keys_.size() >= most_keys) keys_.erase(keys_.begin());
    return "http://" + origin() + "/?key=" + *keys_.insert(secret()).first;
  }

  httplib::Server& server() { return server_; }
  int port() const { return port_; }

private:
  std::string origin() const { return std::string(host_) + ":" + std::to_string(port_); }
  /// Cookies do not distinguish ports.
  std::string cookie_name() const { return "dccast_" + std::to_string(port_); }

  bool is_own_name(const std::string& host) const {
    const std::string port = ":" + std::to_string(port_);
    return host == host_ + port || host == "localhost" + port || host == "[::1]" + port;
  }

  bool take_key(const std::string& key) {
    const std::lock_guard lock(mutex_);
    const auto found =
        std::ranges::find_if(keys_, [&](const std::string& known) { return equal(known, key); });
    if (found == keys_.end()) return false;
    keys_.erase(found);
    return true;
  }

  static bool refuse(httplib::Response& response, const std::string& text) {
    response.status = 403;
    response.set_content(text + "\n", "text/plain; charset=utf-8");
    return false;
  }

  /// Sets the headers of every reply. @return false: this one is complete
  bool admit(const httplib::Request& request, httplib::Response& response) {
    response.set_header("X-Content-Type-Options", "nosniff");
    response.set_header("Referrer-Policy", "no-referrer");
    response.set_header("Cross-Origin-Opener-Policy", "same-origin");
    response.set_header("Cross-Origin-Resource-Policy", "same-origin");
    response.set_header("Cache-Control", "no-store");
    const std::string host = request.get_header_value("Host");
    if (!is_own_name(host))
      return refuse(response, "This dashboard is at http://" + origin() + " only.");
    const std::string from = request.get_header_value("Origin");
    if (from.empty() ? request.method != "GET" : from != "http://" + host)
      return refuse(response, "Only pages of this dashboard may ask this.");
    if (equal(cookie(request, cookie_name()), session_)) return true;
    if (request.path != "/" || !take_key(request.get_param_value("key")))
      return refuse(response,
                    "The key in the address is missing or was used before. Start `dccast "
                    "dashboard` again, or press \"Another screen\" in the one that is open.");
    response.set_header("Set-Cookie",
                        cookie_name() + "=" + session_ + "; HttpOnly; SameSite=Strict; Path=/");
    response.set_redirect("/");
    return false;
  }

  static constexpr const char* host_ = "127.0.0.1";
  httplib::Server server_;
  int port_ = 0;
  const std::string session_;
  std::mutex mutex_;
  std::set<std::string> keys_;
};

WebServer::WebServer(int port) : parts_(std::make_unique<Parts>(port)) {}
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

}  // namespace

void WebServer::get(const std::string& path, Handler handler) {
  parts_->server().Get(with_name(path), answering(std::move(handler)));
}

void WebServer::post(const std::string& path, Handler handler) {
  parts_->server().Post(with_name(path), answering(std::move(handler)));
}

void WebServer::events(const std::string& path, Source source) {
  parts_->server().Get(with_name(path), [source = std::move(source)](const httplib::Request& asked,
                                                                     httplib::Response& response) {
    const auto stream = std::make_shared<Stream>(source, request_of(asked));
    response.set_chunked_content_provider(
        "text/event-stream",
        [stream](std::size_t, httplib::DataSink& sink) { return stream->write(sink); });
  });
}

int WebServer::port() const {
  return parts_->port();
}

std::string WebServer::address() {
  return parts_->address();
}

void WebServer::serve(const Interruption& interruption) {
  std::thread watch([&] {
    while (!interruption.came()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    parts_->server().stop();
  });
  parts_->server().listen_after_bind();
  watch.join();
}

}  // namespace dccast::client::web
