#pragma once

#include <grpcpp/support/server_callback.h>

#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "server/service/status.hpp"
#include "server/service/stream_call.hpp"
#include "server/service/work_pool.hpp"

namespace dccast::service {

/// What a stream does next: sends a message, or ends, or waits for news where there is neither.
template <class Message>
struct NextMessage {
  std::optional<Message> message = std::nullopt;
  std::optional<grpc::Status> end = std::nullopt;
  bool more = false;  ///< look again once the message is sent, without news
};

/// A stream that says what is new, one message under way at a time. It is opened in a lane, looks
/// for the next message whenever there is news, by one thread at a time, and lives until gRPC has
/// done with it and whoever brings the news has let go of it. Nothing but begin(), on_news() and
/// gRPC calls it.
template <class Message>
class NewsStream : public grpc::ServerWriteReactor<Message>,
                   public std::enable_shared_from_this<NewsStream<Message>> {
public:
  NewsStream(WorkPool& lane, StreamCall call) : lane_(lane), call_(std::move(call)) {}

  void begin() {
    self_ = this->shared_from_this();
    const bool taken = lane_.post([self = self_] { self->open_in_lane(); });
    if (!taken) end(too_many_waiting());
  }

  void on_news() {
    {
      const std::lock_guard lock(mutex_);
      news_ = true;
    }
    look();
  }

  void OnWriteDone(bool ok) final {
    {
      const std::lock_guard lock(mutex_);
      writing_ = false;
      cancelled_ = cancelled_ || !ok;
    }
    look();
  }

  void OnCancel() final {
    {
      const std::lock_guard lock(mutex_);
      cancelled_ = true;
    }
    look();
  }

  void OnDone() final { self_.reset(); }

protected:
  /// Finds what is watched and asks to be told of news.
  virtual grpc::Status open(const Call& call) = 0;
  virtual NextMessage<Message> next() = 0;
  /// Whether next() is for a thread of the lane, as it reads the store; else whoever brings the
  /// news does it. A lane that is full drops it: news must come again.
  virtual bool looks_in_lane() const = 0;

private:
  void open_in_lane() {
    const grpc::Status status = guarded([&] {
      const Call call = call_.call([this] { return cancelled(); });
      const auto unwanted = no_longer_wanted(call);
      return unwanted ? *unwanted : open(call);
    });
    if (!status.ok()) return end(status);
    {
      const std::lock_guard lock(mutex_);
      open_ = true;
      news_ = true;
    }
    look();
  }

  bool cancelled() {
    const std::lock_guard lock(mutex_);
    return cancelled_;
  }

  void end(const grpc::Status& status) {
    {
      const std::lock_guard lock(mutex_);
      if (std::exchange(ended_, true)) return;
    }
    this->Finish(status);
  }

  /// When there is news and nothing else is under way.
  void look() {
    {
      const std::lock_guard lock(mutex_);
      if (!open_ || writing_ || looking_ || ended_ || !(news_ || cancelled_)) return;
      looking_ = true;
      news_ = false;
    }
    if (!looks_in_lane()) return send_next();
    if (lane_.post([self = this->shared_from_this()] { self->send_next(); })) return;
    const std::lock_guard lock(mutex_);
    looking_ = false;
  }

  NextMessage<Message> guarded_next() {
    if (cancelled()) return {.end = grpc::Status::CANCELLED};
    NextMessage<Message> found;
    const grpc::Status status = guarded([&] {
      found = next();
      return grpc::Status::OK;
    });
    if (!status.ok()) return {.end = status};
    return found;
  }

  void send_next() {
    NextMessage<Message> found = guarded_next();
    {
      const std::lock_guard lock(mutex_);
      looking_ = false;
      writing_ = found.message.has_value();
      news_ = news_ || found.more;
      if (found.message) message_ = std::move(*found.message);
    }
    if (found.message) return this->StartWrite(&message_);
    if (found.end) return end(*found.end);
    look();  // what came meanwhile
  }

  WorkPool& lane_;
  const StreamCall call_;
  std::shared_ptr<NewsStream> self_;
  std::mutex mutex_;  ///< of all below
  Message message_;
  bool open_ = false;
  bool news_ = false;
  bool looking_ = false;
  bool writing_ = false;
  bool cancelled_ = false;
  bool ended_ = false;
};

}  // namespace dccast::service
