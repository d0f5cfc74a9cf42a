#include <google/protobuf/util/message_differencer.h>

#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "server/service/status.hpp"
#include "server/service/study_handlers.hpp"
#include "server/service/study_status.hpp"

namespace dccast::service {

namespace {

/// One watcher of a study: the state it sent last, and one message under way. Looking a study up
/// reads the store, so it is done in a lane and one at a time.
class StudyStream final : public grpc::ServerWriteReactor<v1::Study>,
                          public studies::StudyWatcher,
                          public std::enable_shared_from_this<StudyStream> {
public:
  StudyStream(StudyContext& context, WorkPool& lane, StreamCall call, std::string id)
      : context_(context), lane_(lane), call_(std::move(call)), id_(std::move(id)) {}

  void begin() {
    self_ = shared_from_this();
    const bool taken = lane_.post([self = self_] {
      const grpc::Status status = guarded([&] { return self->open(); });
      if (!status.ok()) self->end(status);
    });
    if (!taken) end(too_many_waiting());
  }

  void on_changed() override {
    {
      const std::lock_guard lock(mutex_);
      news_ = true;
    }
    look();
  }

  void OnWriteDone(bool ok) override {
    {
      const std::lock_guard lock(mutex_);
      writing_ = false;
      cancelled_ = cancelled_ || !ok;
    }
    look();
  }

  void OnCancel() override {
    {
      const std::lock_guard lock(mutex_);
      cancelled_ = true;
    }
    look();
  }

  void OnDone() override { self_.reset(); }

private:
  grpc::Status open() {
    const Call call = call_.call([this] { return cancelled(); });
    if (const auto unwanted = no_longer_wanted(call)) return *unwanted;
    if (const auto status = check_study_id(id_); !status.ok()) return status;
    if (!context_.studies.find(id_)) return study_not_found(id_);
    {
      const std::lock_guard lock(mutex_);
      open_ = true;
    }
    context_.studies.notifier().watch(id_, weak_from_this());  // calls on_changed() soon
    look();
    return grpc::Status::OK;
  }

  bool cancelled() {
    const std::lock_guard lock(mutex_);
    return cancelled_;
  }

  void end(const grpc::Status& status) {
    {
      const std::lock_guard lock(mutex_);
      if (writing_ || std::exchange(ended_, true)) return;
    }
    Finish(status);
  }

  /// Has the study looked up when there is news and nothing else is under way.
  void look() {
    {
      const std::lock_guard lock(mutex_);
      if (!open_ || writing_ || looking_ || ended_ || !(news_ || cancelled_)) return;
      looking_ = true;
      news_ = false;
    }
    auto self = shared_from_this();
    if (!lane_.post([self] { self->send_news(); })) send_nothing();
  }

  /// The lane is full: the notifier comes again within a second.
  void send_nothing() {
    const std::lock_guard lock(mutex_);
    looking_ = false;
  }

  void send_news() {
    std::optional<v1::Study> study;
    grpc::Status status = guarded([&] {
      study = context_.studies.find(id_);
      return study ? grpc::Status::OK : study_not_found(id_);
    });
    if (cancelled()) status = grpc::Status::CANCELLED;
    const bool over = study && study->state() != v1::STUDY_RUNNING;
    const bool leaving = context_.service.leaving;
    bool write = false;
    {
      const std::lock_guard lock(mutex_);
      looking_ = false;
      write = status.ok() && !ended_ &&
              !(sent_ && google::protobuf::util::MessageDifferencer::Equals(*sent_, *study));
      if (write) {
        sent_ = *study;
        message_ = std::move(*study);
        writing_ = true;
        news_ = over || leaving;  // to end once it is written
      }
    }
    if (write) return StartWrite(&message_);
    if (!status.ok()) return end(status);
    if (over) return end(grpc::Status::OK);
    if (leaving)
      return end({grpc::StatusCode::UNAVAILABLE,
                  "dccastd is shutting down; the study goes on when it is back: watch again"});
    look();  // what came meanwhile
  }

  StudyContext& context_;
  WorkPool& lane_;
  const StreamCall call_;
  const std::string id_;
  std::shared_ptr<StudyStream> self_;
  std::mutex mutex_;  ///< of all below
  std::optional<v1::Study> sent_;
  v1::Study message_;
  bool open_ = false;
  bool news_ = false;
  bool looking_ = false;
  bool writing_ = false;
  bool cancelled_ = false;
  bool ended_ = false;
};

}  // namespace

grpc::ServerWriteReactor<v1::Study>* watch_study(StudyContext& context, WorkPool& lane,
                                                 StreamCall call,
                                                 const v1::WatchStudyRequest& request) {
  const auto stream = std::make_shared<StudyStream>(context, lane, std::move(call), request.id());
  stream->begin();
  return stream.get();
}

}  // namespace dccast::service
