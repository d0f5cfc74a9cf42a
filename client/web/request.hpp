#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "proto/http/message.hpp"

namespace dccast::client {

/// What a browser or program asks for.
struct Request : http::Request {
  bool is_of_file = false;  ///< of this server, which is for everybody
  std::string name{};       ///< the part of the path that a "*" stands for, decoded
  std::string token{};      ///< of its user, for the daemon; empty where the socket proves the user
  std::string user{};       ///< whose token it is, as the caller states it; empty: not stated
  std::string set_cookie{};       ///< for the reply; empty: none
  std::shared_ptr<void> place{};  ///< among the requests of its user; held until it is answered

  /// The first value of a query key; empty if there is none.
  std::string value(const std::string& key) const;
  /// All values of a query key, in their order.
  std::vector<std::string> values(const std::string& key) const;
};

using http::Reply;

/// A reply of status 200.
inline Reply json_reply(std::string body) {
  return {.body = std::move(body), .type = "application/json"};
}

}  // namespace dccast::client
