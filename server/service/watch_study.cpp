#include <google/protobuf/util/message_differencer.h>

#include <optional>
#include <string>

#include "server/service/news_stream.hpp"
#include "server/service/study_handlers.hpp"
#include "server/service/study_status.hpp"

namespace dccast::service {

namespace {

/// The study each time it differs from what was sent last.
class StudyStream final : public NewsStream<v1::Study>, public studies::StudyWatcher {
public:
  StudyStream(StudyContext& context, WorkPool& lane, StreamCall call, std::string id)
      : NewsStream(lane, std::move(call)), context_(context), id_(std::move(id)) {}

  void on_changed() override { on_news(); }

private:
  grpc::Status open(const Call&) override {
    if (const auto status = check_study_id(id_); !status.ok()) return status;
    if (!context_.studies.find(id_)) return study_not_found(id_);
    context_.studies.notifier().watch(id_,
                                      std::static_pointer_cast<StudyStream>(shared_from_this()));
    return grpc::Status::OK;
  }

  /// Looking a study up reads the store. The notifier comes again within a second.
  bool looks_in_lane() const override { return true; }

  NextMessage<v1::Study> next() override {
    auto study = context_.studies.find(id_);
    if (!study) return {.end = study_not_found(id_)};
    const bool over = study->state() != v1::STUDY_RUNNING;
    const bool leaving = context_.service.leaving;
    if (!sent_ || !google::protobuf::util::MessageDifferencer::Equals(*sent_, *study)) {
      sent_ = *study;
      return {.message = std::move(*study), .more = over || leaving};
    }
    if (over) return {.end = grpc::Status::OK};
    if (!leaving) return {};
    return {.end = grpc::Status(
                grpc::StatusCode::UNAVAILABLE,
                "dccastd is shutting down; the study goes on when it is back: watch again")};
  }

  StudyContext& context_;
  const std::string id_;
  std::optional<v1::Study> sent_;
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
