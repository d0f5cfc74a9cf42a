#include <atomic>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "server/service/query_run.hpp"
#include "server/service/status.hpp"
#include "server/service/streams.hpp"

namespace dccast::service {

namespace {

/// One query: what the thread of its run has passed on and gRPC has not sent yet. It lives until gRPC
/// has done with it and that thread has let go of it.
class QueryStream final : public grpc::ServerWriteReactor<v1::QueryButtCurlResponse>,
                          public std::enable_shared_from_this<QueryStream> {
public:
  explicit QueryStream(Context& context) : context_(context) {}

  void begin(WorkPool& lane, const CallMaker& call, const v1::QueryButtCurlRequest& request) {
    self_ = shared_from_this();
    const bool taken = lane.post([self = self_, call, &request] { self->answer(call(), request); },
                                 request.ByteSizeLong());
    if (!taken) end(too_many_waiting());
  }

  void OnWriteDone(bool ok) override {
    {
      const std::lock_guard lock(mutex_);
      writing_ = false;
    }
    if (!ok) unwanted_ = true;
    go_on();
  }

  void OnCancel() override { unwanted_ = true; }

  void OnDone() override { self_.reset(); }

private:
  /// The request lives as long as the call, which only end() ends.
  void answer(Call call, const v1::QueryButtCurlRequest& request) {
    call.cancelled = [this] { return unwanted_ || context_.leaving; };
    const grpc::Status status = guarded([&] {
      if (const auto unwanted = no_longer_wanted(call)) return *unwanted;
      return answer_query(context_, call, request, [this](auto response) { send(std::move(response)); });
    });
    end(status.error_code() == grpc::StatusCode::CANCELLED && context_.leaving ? leaving()
                                                                               : status);
  }

  static grpc::Status leaving() {
    return {grpc::StatusCode::UNAVAILABLE, "dccastd is shutting down; ask again later"};
  }

  void send(v1::QueryButtCurlResponse response) {
    {
      const std::lock_guard lock(mutex_);
      waiting_.push_back(std::move(response));
    }
    go_on();
  }

  void end(const grpc::Status& status) {
    {
      const std::lock_guard lock(mutex_);
      end_ = status;
    }
    go_on();
  }

  /// Sends what waits next, or ends the call once all of it is sent or no one wants it.
  void go_on() {
    bool more = false;
    {
      const std::lock_guard lock(mutex_);
      if (writing_ || ended_) return;
      more = !waiting_.empty() && !unwanted_;
      if (!more && !end_) return;
      if (more) {
        sending_ = std::move(waiting_.front());
        waiting_.pop_front();
      }
      writing_ = more;
      ended_ = !more;
    }
    if (more)
      StartWrite(&sending_);
    else
      Finish(*end_);
  }

  Context& context_;
  std::shared_ptr<QueryStream> self_;
  std::atomic<bool> unwanted_ = false;
  std::mutex mutex_;  ///< of all below
  std::deque<v1::QueryButtCurlResponse> waiting_;
  v1::QueryButtCurlResponse sending_;
  std::optional<grpc::Status> end_;
  bool writing_ = false;
  bool ended_ = false;
};

}  // namespace

grpc::ServerWriteReactor<v1::QueryButtCurlResponse>* query_butt_curl(
    Context& context, WorkPool& lane, const CallMaker& call,
    const v1::QueryButtCurlRequest& request) {
  const auto stream = std::make_shared<QueryStream>(context);
  stream->begin(lane, call, request);
  return stream.get();
}

}  // namespace dccast::service
