#pragma once

#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace dccast::http {

/// The peer has left, is too slow, or sends more than the server takes.
struct CutBody : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A request that is whole and within the limits of the server.
struct Request {
  /// "GET" (also for HEAD, whose reply is sent without its body), "POST" or "PUT"
  std::string method;
  std::string path;                               ///< as sent, without the query: "/job/7"
  std::multimap<std::string, std::string> query;  ///< decoded
  std::map<std::string, std::string> headers;     ///< by name in small letters
  std::string body{};
  std::string address{};  ///< of the peer, without port
  /// Of a PUT, whose body is not read before the handler wants it: waits for the next part, of
  /// 64 KiB or more but for the last one. @return empty: there is no other. @throws CutBody
  std::function<std::string()> next_part{};

  /// Value of a header; empty: not sent. @param name  in small letters
  std::string header(const std::string& name) const {
    const auto found = headers.find(name);
    return found == headers.end() ? std::string() : found->second;
  }
};

/// The body of a reply that goes on, written by its source from any thread. It holds no thread
/// while nothing is written.
class Stream {
public:
  virtual ~Stream() = default;
  /// Sends the next part, which is not empty. One at a time: another may follow once `done` was
  /// called, with false if the peer has left.
  virtual void write(std::string part, std::function<void(bool sent)> done) = 0;
  /// Nothing follows.
  virtual void end() = 0;
  /// @param left  called once, when the peer has left or the server stops; at once if it has
  virtual void when_left(std::function<void()> left) = 0;
};

/// Answer to a request.
struct Reply {
  std::string body{};                                          ///< empty for a stream
  std::string type = "text/plain; charset=utf-8";              ///< header Content-Type
  int status = 200;                                            ///< of HTTP
  std::vector<std::pair<std::string, std::string>> headers{};  ///< further ones
  /// Set: the reply is a stream instead of `body`. Called once, in a thread of the handlers.
  std::function<void(std::shared_ptr<Stream>)> stream{};
};

/// Answers a request in a thread of the server. An exception is answered with status 500.
using Handler = std::function<Reply(const Request&)>;

}  // namespace dccast::http
