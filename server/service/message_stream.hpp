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

/// What a stream does next: sends a message, or ends, or waits to be woken where there is neither.
template <class Message>
struct NextMessage {
  std::optional<Message> message{};
  std::optional<grpc::Status> end{};
};

/// A stream of messages to a client, one under way at a time. It is opened in a lane, asks for the
/// next message when it is woken and when one is sent, by one thread at a time, and lives until
/// gRPC has done with it and no one else holds it. Only begin(), wake() and gRPC call it.
template <class Message>
class MessageStream : public grpc::ServerWriteReactor<Message>,
                      public LastingCall,
                      public std::enable_shared_from_this<MessageStream<Message>> {
public:
  MessageStream(WorkPool& lane, CallOrigin origin) : lane_(lane), origin_(std::move(origin)) {}

  void begin() {
    self_ = this->shared_from_this();
    if (!origin_.refusal().ok()) return end(origin_.refusal());
    const bool taken = lane_.post([self = self_] { self->open_in_lane(); }, kept_bytes());
    if (taken) return;
    origin_.count(too_many_waiting());
    end(too_many_waiting());
  }

  /// There may be a next message.
  void wake() {
    go_on_with([this] { woken_ = true; });
  }

  void OnWriteDone(bool ok) final {
    go_on_with([&] {
      writing_ = false;
      woken_ = true;
      cancelled_ = cancelled_ || !ok;
    });
  }

  void OnCancel() final {
    go_on_with([this] { cancelled_ = true; });
  }

  void OnDone() final {
    if (entered_) origin_.gate().leave(call_.caller);
    self_.reset();
  }

  /// Ends what is under way, and the stream once its last message has gone.
  void lapse(const grpc::Status& status) final {
    go_on_with([&] {
      if (!lapsed_) lapsed_ = status;
      woken_ = true;
    });
  }

protected:
  /// Finds what is to be sent. What it and next() throw ends the stream as guarded() has it.
  virtual void open(const Call& call) = 0;
  virtual NextMessage<Message> next() = 0;
  /// Whether next() waits for the store and is for a thread of the lane.
  virtual bool looks_in_lane() const { return false; }

  /// Whether open() hands its work over to other lanes: the last of them calls finish_opening().
  virtual bool opens_in_stages() const { return false; }

  /// @param status  how opening ended, for the audit log; next() reports it
  void finish_opening(const grpc::Status& status) {
    origin_.record(call_, status);
    set_open();
    wake();
  }

  /// What a stream keeps in memory of its request while it waits to be opened.
  virtual std::size_t kept_bytes() const { return 0; }

  /// next() may be called from now on: at the end of open() at the latest.
  void set_open() {
    const std::lock_guard lock(mutex_);
    open_ = true;
  }

private:
  void open_in_lane() {
    if (cancelled()) return end(grpc::Status::CANCELLED);  // without an exception: admit()
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

  template <class Change>
  void go_on_with(Change change) {
    {
      const std::lock_guard lock(mutex_);
      change();
    }
    look();
  }

  bool cancelled() {
    const std::lock_guard lock(mutex_);
    return cancelled_ || lapsed_;
  }

  void end(const grpc::Status& status) {
    {
      const std::lock_guard lock(mutex_);
      if (std::exchange(ended_, true)) return;
    }
    this->Finish(status);
  }

  /// Sends the next message unless something else is under way.
  void look() {
    {
      const std::lock_guard lock(mutex_);
      if (!open_ || writing_ || looking_ || ended_ || !(woken_ || cancelled_)) return;
      looking_ = true;
      woken_ = false;
    }
    if (!looks_in_lane()) return send_next();
    if (!lane_.post([self = this->shared_from_this()] { self->send_next(); }))
      end(too_many_waiting());
  }

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
    look();  // what came meanwhile
  }

  WorkPool& lane_;
  CallOrigin origin_;
  Call call_;             ///< once it was admitted
  bool entered_ = false;  ///< counted by the gate
  std::shared_ptr<MessageStream> self_;
  std::mutex mutex_;  ///< of all below
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
