// The call that brings the files of cases. What is kept of them is in server/intake/uploads.hpp.
#include "server/intake/uploads.hpp"

#include <grpcpp/alarm.h>
#include <grpcpp/support/server_callback.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "proto/values/digests.hpp"
#include "proto/values/printable.hpp"
#include "server/service/refusals.hpp"
#include "server/service/simulation_service.hpp"

namespace dccast::service {

namespace {

using Request = v1::UploadAttachmentRequest;

constexpr std::size_t largest_chunk = 256'000;  // [bytes], service.proto

/// One upload: a chunk is read while none is being written, so that it keeps one in memory.
class UploadStream final : public grpc::ServerReadReactor<Request>,
                           public LastingCall,
                           public std::enable_shared_from_this<UploadStream> {
public:
  /// @param silence  after so long without a part of the file the stream ends
  UploadStream(WorkPool& pool, CallOrigin origin, intake::Uploads& uploads,
               std::chrono::milliseconds silence, v1::UploadAttachmentResponse& response)
      : pool_(pool),
        origin_(std::move(origin)),
        uploads_(uploads),
        silence_(silence),
        response_(response) {}

  void begin() {
    self_ = shared_from_this();
    if (!origin_.refusal().ok()) return end(origin_.refusal());
    do_in_pool([this] { open(); });
  }

  void OnReadDone(bool ok) override {
    last_read_ = Clock::now();
    do_in_pool([this, ok] {
      if (ok)
        take();
      else
        conclude();
    });
  }

  void OnCancel() override { cancelled_ = true; }

  void OnDone() override {
    if (entered_) origin_.gate().leave(call_.caller);
    self_.reset();
  }

  void lapse(const grpc::Status& status) override { end(status); }

private:
  using Clock = std::chrono::steady_clock;

  /// One who holds an upload open keeps a place that others wait for.
  void watch_for_silence() {
    // The alarm keeps its function until it ends itself, which is with this object.
    alarm_.Set(std::chrono::system_clock::now() + silence_,
               [weak = weak_from_this()](bool expired) {
                 if (const auto self = weak.lock(); self && expired) self->end_if_silent();
               });
  }

  void end_if_silent() {
    if (Clock::now() - last_read_.load() >= silence_)
      return end(make_status({.reason = ErrorInfo::TOO_LATE,
                              .cause = "the rest of the file did not come",
                              .remedy = "upload it again"}));
    if_open([this] { watch_for_silence(); });
  }

  template <class Work>
  void do_in_pool(Work work) {
    const bool taken = pool_.post([self = shared_from_this(), work = std::move(work)] { work(); });
    if (taken) return;
    origin_.count(too_many_waiting());
    end(too_many_waiting());
  }

  /// The role is checked before anything of the file is read.
  void open() {
    if (cancelled_) return end(grpc::Status::CANCELLED);  // without an exception: admit()
    const grpc::Status status = guarded([&] {
      call_ = origin_.admit([this] { return cancelled_.load(); });
      admitted_ = true;
      origin_.gate().enter(call_.caller, weak_from_this());
      entered_ = true;
      if_open([this] { watch_for_silence(); });
    });
    go_on(status);
  }

  void take() {
    bool has_it = false;
    const grpc::Status status = guarded([&] {
      check_wanted(call_);
      if (upload_)
        append();
      else
        has_it = !start();
    });
    if (!has_it) return go_on(status);
    response_.set_was_there(true);
    conclude_with(grpc::Status::OK);
  }

  /// @return false: the server has the file already
  bool start() {
    if (!request_.has_attachment()) refuse("the first message must name the file");
    const v1::Attachment& announced = request_.attachment();
    check_attachment(announced);
    if (uploads_.renew(call_.caller.name, announced)) return false;

    upload_ = uploads_.begin(call_.caller.name, announced);
    call_.note->set_reason(fmt::format("{} of {} bytes, SHA-256 {}",
                                       values::shown(announced.name()), announced.size_bytes(),
                                       announced.sha256()));
    if_open([this] { StartSendInitialMetadata(); });  // the client may send the content
    return true;
  }

  void append() {
    if (request_.part_case() != Request::kChunk)
      refuse("a file is named once, by the first message");
    if (request_.chunk().size() > largest_chunk)
      refuse("a chunk has {} bytes; at most {} are taken", request_.chunk().size(), largest_chunk);
    upload_->append(request_.chunk());
  }

  void go_on(const grpc::Status& status) {
    if (!status.ok()) return conclude_with(status);
    if_open([this] { StartRead(&request_); });
  }

  /// The client has sent all it has to send.
  void conclude() {
    if (cancelled_) return conclude_with(grpc::Status::CANCELLED);
    conclude_with(guarded([&] {
      check_wanted(call_);
      if (!upload_) refuse("no file came: the first message names it");
      upload_->finish();
    }));
  }

  void conclude_with(const grpc::Status& status) {
    upload_.reset();
    if (admitted_) origin_.record(call_, status);
    end(status);
  }

  void end(const grpc::Status& status) {
    if_open([&] {
      ended_ = true;
      Finish(status);
    });
  }

  /// gRPC takes nothing of a call after its end, which another thread may bring: lapse().
  template <class Operation>
  void if_open(Operation operation) {
    const std::lock_guard lock(mutex_);
    if (!ended_) operation();
  }

  WorkPool& pool_;
  CallOrigin origin_;
  intake::Uploads& uploads_;
  const std::chrono::milliseconds silence_;
  v1::UploadAttachmentResponse& response_;
  std::shared_ptr<UploadStream> self_;
  std::atomic<bool> cancelled_{false};
  std::atomic<Clock::time_point> last_read_{Clock::now()};
  grpc::Alarm alarm_;
  // Of the pool, which does one piece of work of this stream at a time.
  Call call_;  ///< once it was admitted
  bool admitted_ = false;
  bool entered_ = false;  ///< counted by the gate
  std::unique_ptr<intake::Uploads::Upload> upload_;
  Request request_;
  std::mutex mutex_;  ///< of the flag
  bool ended_ = false;
};

}  // namespace

grpc::ServerReadReactor<Request>* SimulationService::UploadAttachment(
    Wire* wire, v1::UploadAttachmentResponse* response) {
  constexpr double longest_silence_s = 60.0;
  const double silence_s =
      std::min(longest_silence_s, context_.settings.retention().upload_lifetime_s());
  const auto stream = std::make_shared<UploadStream>(
      pools_.uploads, origin_of(wire, Request::default_instance()), context_.uploads,
      std::chrono::milliseconds(std::llround(1000.0 * silence_s)), *response);
  stream->begin();
  return stream.get();
}

}  // namespace dccast::service
