#include "server/service/worker_link.hpp"

#include <deque>
#include <memory>
#include <mutex>
#include <utility>

#include "server/jobs/log.hpp"

namespace dccast::service {

namespace {

/// One worker's call. Orders may come from any thread; one is under way at a time.
class WorkerStream final : public grpc::ServerBidiReactor<v1::WorkerMessage, v1::WorkerOrder>,
                           public jobs::WorkerChannel,
                           public std::enable_shared_from_this<WorkerStream> {
public:
  WorkerStream(jobs::Scheduler& scheduler, WorkPool& in_order)
      : scheduler_(scheduler), in_order_(in_order) {}

  void begin() {
    self_ = shared_from_this();
    StartRead(&message_);
  }

  void send(const v1::WorkerOrder& order) override {
    {
      const std::lock_guard lock(mutex_);
      orders_.push_back(order);
    }
    go_on();
  }

  void OnReadDone(bool ok) override {
    if (!ok) return end(grpc::Status::OK);
    if (!attempt_) return greet();
    if (message_.has_finished())
      in_order_.post([this, self = shared_from_this(), last = message_] { report(last); });
    else
      report(message_);
    StartRead(&message_);
  }

  void OnWriteDone(bool ok) override {
    {
      const std::lock_guard lock(mutex_);
      writing_ = false;
      if (!ok) orders_.clear();
    }
    go_on();
  }

  void OnDone() override {
    if (attempt_)
      in_order_.post([self = shared_from_this()] { self->scheduler_.detach(self->attempt_); });
    self_.reset();
  }

private:
  /// gRPC would swallow what a reaction throws: the worker is sent away, its job settled.
  void report(const v1::WorkerMessage& message) {
    try {
      scheduler_.report(attempt_, message);
      if (const auto stored = scheduler_.acknowledgement(*attempt_, message.has_heartbeat()))
        send(*stored);
    } catch (const std::exception& error) {
      spdlog::error("job {}: {}", attempt_->job_id, error.what());
      end({grpc::StatusCode::INTERNAL, error.what()});
    }
  }

  void greet() {
    try {
      if (message_.has_hello()) attempt_ = scheduler_.attach(message_.hello(), shared_from_this());
    } catch (const std::exception& error) {
      spdlog::error("worker link: {}", error.what());
      return end({grpc::StatusCode::ABORTED, error.what()});
    }
    if (!attempt_)
      return end({grpc::StatusCode::PERMISSION_DENIED, "the token is not the one of this worker"});
    StartRead(&message_);
  }

  void end(const grpc::Status& status) {
    {
      const std::lock_guard lock(mutex_);
      if (ending_) return;
      ending_ = status;
    }
    go_on();
  }

  /// Sends the next order, or ends the call once none is under way.
  void go_on() {
    bool finish = false;
    {
      const std::lock_guard lock(mutex_);
      if (writing_ || ended_) return;
      if (!orders_.empty() && !ending_) {
        order_ = std::move(orders_.front());
        orders_.pop_front();
        writing_ = true;
      } else if (ending_) {
        finish = ended_ = true;
      } else {
        return;
      }
    }
    if (finish)
      Finish(*ending_);
    else
      StartWrite(&order_);
  }

  jobs::Scheduler& scheduler_;
  WorkPool& in_order_;
  std::shared_ptr<WorkerStream> self_;
  std::shared_ptr<jobs::Attempt> attempt_;
  v1::WorkerMessage message_;
  std::mutex mutex_;  ///< of all below
  std::deque<v1::WorkerOrder> orders_;
  v1::WorkerOrder order_;
  std::optional<grpc::Status> ending_;
  bool writing_ = false;
  bool ended_ = false;
};

}  // namespace

grpc::ServerBidiReactor<v1::WorkerMessage, v1::WorkerOrder>* WorkerLink::Run(
    grpc::CallbackServerContext*) {
  const auto stream = std::make_shared<WorkerStream>(scheduler_, in_order_);
  stream->begin();
  return stream.get();
}

}  // namespace dccast::service
