#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace dccast::http {

/// A request that is whole and within the limits of the server.
struct Request {
  std::string method;  ///< "GET" (also for HEAD, whose reply is sent without its body) or "POST"
  std::string path;    ///< as sent, without the query: "/job/7"
  std::multimap<std::string, std::string> query;  ///< decoded
  std::string host, origin, cookies;              ///< headers; empty: not sent
  std::string body{};
};

struct Reply {
  std::string body{};
  std::string type = "text/plain; charset=utf-8";
  int status = 200;
  std::vector<std::pair<std::string, std::string>> headers{};  ///< further ones
  /// Set: the reply is a stream, of parts instead of `body`. Called again and again until a part is
  /// empty; each call must return within a second, so that a server that stops is noticed.
  std::function<std::string()> next_part{};
};

/// Answers a request in a thread of its connection. An exception is answered with status 500.
using Handler = std::function<Reply(const Request&)>;

}  // namespace dccast::http
