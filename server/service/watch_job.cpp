#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "server/service/status.hpp"
#include "server/service/streams.hpp"

namespace dccast::service {

namespace {

/// One watcher: a cursor into the job's event log and one event under way. It lives until gRPC has
/// done with it and the notifier has let go of it.
class WatchStream final : public grpc::ServerWriteReactor<v1::JobEvent>,
                          public jobs::Watcher,
                          public std::enable_shared_from_this<WatchStream> {
public:
  explicit WatchStream(Context& context) : context_(context) {}

  void begin(WorkPool& lane, const StreamCall& stream, const v1::WatchJobRequest& request) {
    self_ = shared_from_this();
    const bool taken = lane.post([self = self_, stream, request] {
      const grpc::Status status = guarded(
          [&] { return self->open(stream.call([self] { return self->cancelled(); }), request); });
      if (!status.ok()) self->end(status);
    });
    if (!taken) end(too_many_waiting());
  }

  void on_appended() override { go_on(); }

  void OnWriteDone(bool ok) override {
    {
      const std::lock_guard lock(mutex_);
      writing_ = false;
      cancelled_ = cancelled_ || !ok;
    }
    go_on();
  }

  void OnCancel() override {
    {
      const std::lock_guard lock(mutex_);
      cancelled_ = true;
    }
    go_on();
  }

  void OnDone() override { self_.reset(); }

private:
  grpc::Status open(const Call& call, const v1::WatchJobRequest& request) {
    if (const auto unwanted = no_longer_wanted(call)) return *unwanted;
    if (const auto status = check_id(request.id()); !status.ok()) return status;
    if (!context_.scheduler.find(request.id())) return job_not_found(request.id());
    const auto log = context_.scheduler.log(request.id());
    const std::int64_t first = std::max<std::int64_t>(request.from_sequence(), 1);
    if (first > log->last_sequence() + 1)
      return {grpc::StatusCode::OUT_OF_RANGE,
              "job " + request.id() + " has " + std::to_string(log->last_sequence()) +
                  " events so far; watch from one of them, or the next"};
    {
      const std::lock_guard lock(mutex_);
      log_ = log;
      cursor_.sequence = first;
    }
    context_.logs.watch(request.id(), weak_from_this());  // calls on_appended() soon
    return grpc::Status::OK;
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
    Finish(status);
  }

  /// What the stream does next, decided under the lock and done outside of it.
  void go_on() {
    std::optional<grpc::Status> finish;
    {
      const std::lock_guard lock(mutex_);
      if (writing_ || ended_) return;
      if (!log_ && !cancelled_) return;  // open() has not come to it yet
      finish = guarded_next();
      if (!finish && !writing_) return;  // nothing new
      ended_ = finish.has_value();
    }
    if (finish)
      Finish(*finish);
    else
      StartWrite(&event_);
  }

  /// next(), from whose callers nobody would catch an exception.
  std::optional<grpc::Status> guarded_next() {
    std::optional<grpc::Status> finish;
    const grpc::Status fault = guarded([&] {
      finish = next();
      return grpc::Status::OK;
    });
    return fault.ok() ? finish : fault;
  }

  /// Sets writing_ when there is an event to send. @return the status when the stream is over
  std::optional<grpc::Status> next() {
    if (cancelled_) return grpc::Status::CANCELLED;
    try {
      if (auto event = log_->read(cursor_)) {
        event_ = std::move(*event);
        writing_ = true;
        return std::nullopt;
      }
    } catch (const std::exception& error) {
      spdlog::error("{}", error.what());
      return grpc::Status(grpc::StatusCode::DATA_LOSS,
                          std::string(error.what()) + "; `dccastd check` says what is left of it");
    }
    if (log_->terminal_event()) return grpc::Status::OK;
    if (!context_.leaving) return std::nullopt;
    return grpc::Status(
        grpc::StatusCode::UNAVAILABLE,
        "dccastd is shutting down; the job goes on when it is back: watch again from " +
            std::to_string(cursor_.sequence));
  }

  Context& context_;
  std::shared_ptr<WatchStream> self_;
  std::mutex mutex_;  ///< of all below
  std::shared_ptr<jobs::EventLog> log_;
  jobs::EventLog::Cursor cursor_;
  v1::JobEvent event_;
  bool writing_ = false;
  bool cancelled_ = false;
  bool ended_ = false;
};

}  // namespace

grpc::ServerWriteReactor<v1::JobEvent>* watch_job(Context& context, WorkPool& lane, StreamCall call,
                                                  const v1::WatchJobRequest& request) {
  const auto stream = std::make_shared<WatchStream>(context);
  stream->begin(lane, call, request);
  return stream.get();
}

}  // namespace dccast::service
