#include <algorithm>
#include <string>

#include "server/jobs/log.hpp"
#include "server/service/news_stream.hpp"
#include "server/service/streams.hpp"

namespace dccast::service {

namespace {

/// A cursor into the job's event log.
class WatchStream final : public NewsStream<v1::JobEvent>, public jobs::Watcher {
public:
  WatchStream(Context& context, WorkPool& lane, StreamCall call, v1::WatchJobRequest request)
      : NewsStream(lane, std::move(call)), context_(context), request_(std::move(request)) {}

  void on_appended() override { on_news(); }

private:
  grpc::Status open(const Call&) override {
    if (const auto status = check_id(request_.id()); !status.ok()) return status;
    if (!context_.scheduler.find(request_.id())) return job_not_found(request_.id());
    log_ = context_.scheduler.log(request_.id());
    cursor_.sequence = std::max<std::int64_t>(request_.from_sequence(), 1);
    if (cursor_.sequence > log_->last_sequence() + 1)
      return {grpc::StatusCode::OUT_OF_RANGE,
              "job " + request_.id() + " has " + std::to_string(log_->last_sequence()) +
                  " events so far; watch from one of them, or the next"};
    context_.logs.watch(request_.id(), std::static_pointer_cast<WatchStream>(shared_from_this()));
    return grpc::Status::OK;
  }

  bool looks_in_lane() const override { return false; }

  NextMessage<v1::JobEvent> next() override {
    try {
      if (auto event = log_->read(cursor_)) return {.message = std::move(*event), .more = true};
    } catch (const std::exception& error) {
      spdlog::error("{}", error.what());
      return {.end = grpc::Status(
                  grpc::StatusCode::DATA_LOSS,
                  std::string(error.what()) + "; `dccastd check` says what is left of it")};
    }
    if (log_->terminal_event()) return {.end = grpc::Status::OK};
    if (!context_.leaving) return {};
    return {.end = grpc::Status(
                grpc::StatusCode::UNAVAILABLE,
                "dccastd is shutting down; the job goes on when it is back: watch again from " +
                    std::to_string(cursor_.sequence))};
  }

  Context& context_;
  const v1::WatchJobRequest request_;
  std::shared_ptr<jobs::EventLog> log_;
  jobs::EventLog::Cursor cursor_;
};

}  // namespace

grpc::ServerWriteReactor<v1::JobEvent>* watch_job(Context& context, WorkPool& lane, StreamCall call,
                                                  const v1::WatchJobRequest& request) {
  const auto stream = std::make_shared<WatchStream>(context, lane, std::move(call), request);
  stream->begin();
  return stream.get();
}

}  // namespace dccast::service
