#pragma once

#include <grpcpp/support/server_callback.h>

#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "server/service/call.hpp"
#include "server/service/refusals.hpp"
#include "server/service/work_pool.hpp"

namespace dccast::service {

/// Next action of a stream: send `message`, or finish with `end`, or, if both are empty, wait for
/// wake().
template <class Message>
struct NextMessage {
  std::optional<Message> message{};
  std::optional<grpc::Status> end{};
};

/// A stream of messages to a client, of which one at a time is being sent. The stream is opened in
/// a pool. It asks next() for a message after every wake() and every completed write, from one
/// thread at a time. It lives until gRPC has finished with it and no one else holds it. Only
/// begin(), wake() and gRPC call it.
template <class Message>
class MessageStream : public grpc::ServerWriteReactor<Message>,
                      public LastingCall,
                      public std::enable_shared_from_this<MessageStream<Message>> {
public:
  /// @param pool  where the stream is opened, and looked at if looks_in_pool()
  /// @param origin  caller and gate of the call
  MessageStream(WorkPool& pool, CallOrigin origin) : pool_(pool), origin_(std::move(origin)) {}

  /// Posts the opening. A stream that is refused, or for which too much waits, ends at once.
  void begin() {
    self_ = this->shared_from_this();
    if (!origin_.refusal().ok()) return end(origin_.refusal());
    const bool taken = pool_.post([self = self_] { self->open_in_pool(); }, kept_bytes());
    if (taken) return;
    origin_.count(too_many_waiting());
    end(too_many_waiting());
  }

  /// A next message may be available.
  void wake() {
    go_on_with([this] { woken_ = true; });
  }

  /// gRPC has sent a message, or found that it cannot.
  void OnWriteDone(bool ok) final {
    go_on_with([&] {
      writing_ = false;
      woken_ = true;
      cancelled_ = cancelled_ || !ok;
    });
  }

  /// The client has cancelled the call, or its deadline has passed.
  void OnCancel() final {
    go_on_with([this] { cancelled_ = true; });
  }

  /// Last call of gRPC: the stream may be destroyed once no one else holds it.
  void OnDone() final {
    if (entered_) origin_.gate().leave(call_.caller);
    self_.reset();
  }

  /// Ends the stream after the message that is being sent, because its caller lost access.
  void lapse(const grpc::Status& status) final {
    go_on_with([&] {
      if (!lapsed_) lapsed_ = status;
      woken_ = true;
    });
  }

protected:
  /// Prepares the stream. An exception of open() or next() ends the stream, see guarded().
  virtual void open(const Call& call) = 0;
  /// The next action, after every wake() and every completed write. May throw a Refusal.
  virtual NextMessage<Message> next() = 0;
  /// Whether next() may block on the store and so must run in the pool.
  virtual bool looks_in_pool() const { return false; }

  /// Whether open() continues in other pools, the last of which calls finish_opening().
  virtual bool opens_in_stages() const { return false; }

  /// @param status  how opening ended, for the audit log; next() reports it
  void finish_opening(const grpc::Status& status) {
    origin_.record(call_, status);
    set_open();
    wake();
  }

  /// Memory that the request occupies while it waits to be opened [bytes].
  virtual std::size_t kept_bytes() const { return 0; }

  /// Permits calls of next(), at the latest after open().
  void set_open() {
    const std::lock_guard lock(mutex_);
    open_ = true;
  }

private:
  /// Admits the call, counts the stream and opens it.
  void open_in_pool() {
    // Before admit(), which would throw: a peer may cancel ten thousand calls a second.
    if (cancelled()) return end(grpc::Status::CANCELLED);

    bool admitted = false;
    const grpc::Status status = guarded([&] {
      call_ = origin_.admit([this] { return cancelled(); });
      admitted = true;
      origin_.gate().enter(call_.caller, this->weak_from_this());
      entered_ = true;
      origin_.check_id();
      open(call_);
    });

    if (!status.ok()) {
      if (admitted) origin_.record(call_, status);
      return end(status);
    }
    if (!opens_in_stages()) finish_opening(status);
  }

  /// Changes the flags under the mutex, then looks whether there is something to send.
  template <class Change>
  void go_on_with(Change change) {
    {
      const std::lock_guard lock(mutex_);
      change();
    }
    look();
  }

  /// Whether the stream is to end without further messages.
  bool cancelled() {
    const std::lock_guard lock(mutex_);
    return cancelled_ || lapsed_;
  }

  /// Finishes the call once; later calls have no effect.
  void end(const grpc::Status& status) {
    {
      const std::lock_guard lock(mutex_);
      if (std::exchange(ended_, true)) return;
    }
    this->Finish(status);
  }

  /// Sends the next message unless a write or another look is in progress.
  void look() {
    {
      const std::lock_guard lock(mutex_);
      if (!open_ || writing_ || looking_ || ended_ || !(woken_ || cancelled_)) return;
      looking_ = true;
      woken_ = false;
    }

    if (!looks_in_pool()) return send_next();
    if (!pool_.post([self = this->shared_from_this()] { self->send_next(); }))
      end(too_many_waiting());
  }

  /// next(), with an exception or a lost access turned into the end of the stream.
  NextMessage<Message> guarded_next() {
    {
      const std::lock_guard lock(mutex_);
      if (lapsed_) return {.end = lapsed_};
      if (cancelled_) return {.end = grpc::Status::CANCELLED};
    }
    NextMessage<Message> found;
    const grpc::Status status = guarded([&] { found = next(); });
    return status.ok() ? std::move(found) : NextMessage<Message>{.end = status};
  }

  /// Starts the write that next() asks for. One message at a time is with gRPC.
  void send_next() {
    NextMessage<Message> found = guarded_next();
    {
      const std::lock_guard lock(mutex_);
      looking_ = false;
      writing_ = found.message.has_value();
      if (found.message) message_ = std::move(*found.message);
    }

    if (found.message) return this->StartWrite(&message_);
    if (found.end) return end(*found.end);
    look();  // a wake() during next() only set the flag
  }

  WorkPool& pool_;
  CallOrigin origin_;
  Call call_;             ///< valid once admitted
  bool entered_ = false;  ///< counted by the gate
  /// Keeps the stream alive until OnDone().
  std::shared_ptr<MessageStream> self_;
  std::mutex mutex_;  ///< guards all members below
  Message message_;
  bool open_ = false;
  bool woken_ = false;
  bool looking_ = false;
  bool writing_ = false;
  bool cancelled_ = false;
  bool ended_ = false;
  std::optional<grpc::Status> lapsed_;
};

/// Begins a stream that deletes itself when its call is done.
template <class Stream, class... Arguments>
Stream* begin_stream(Arguments&&... arguments) {
  const auto stream = std::make_shared<Stream>(std::forward<Arguments>(arguments)...);
  stream->begin();
  return stream.get();
}

}  // namespace dccast::service
