#pragma once

#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "client/session/connection.hpp"

namespace dccast::client::web {

/// Writes one event to the browser.
using Send = std::function<void(const std::string& json)>;
/// Sends events until it returns. It shall end soon after `gone` comes: the browser has left.
using Source = std::function<void(std::shared_ptr<Interruption> gone, const Send& send)>;

/// Server-sent events of a source that runs in a thread of its own. It ends with this object.
class EventStream {
public:
  explicit EventStream(Source source);
  ~EventStream();
  EventStream(const EventStream&) = delete;

  /// What is to be written next: all events that wait, or a comment after a while without any.
  /// @return empty at the end
  std::string take();

private:
  class Mailbox;
  void run(const Source& source);

  std::unique_ptr<Mailbox> box_;
  std::shared_ptr<Interruption> gone_ = std::make_shared<Interruption>();
  std::thread thread_;  // last: it uses the others
};

}  // namespace dccast::client::web
