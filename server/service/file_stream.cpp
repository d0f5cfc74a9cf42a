#include "server/service/file_stream.hpp"

#include <algorithm>
#include <atomic>
#include <utility>

#include "server/service/status.hpp"

namespace dccast::service {

namespace {

constexpr std::int64_t chunk_size = 256 * 1024;

/// One chunk is under way at a time.
class FileStream final : public grpc::ServerWriteReactor<v1::FetchResultResponse> {
public:
  FileStream(std::int64_t offset, OpenFile open) : next_(offset), open_(std::move(open)) {}

  /// The stream lives until Finish(), which nothing else calls before the first chunk is sent.
  void begin(WorkPool& lane, const StreamCall& stream) {
    const bool taken = lane.post([this, stream] {
      const grpc::Status status =
          guarded([&] { return open(stream.call([this] { return cancelled_.load(); })); });
      if (status.ok())
        send_next();
      else
        Finish(status);
    });
    if (!taken) Finish(too_many_waiting());
  }

  void OnWriteDone(bool ok) override {
    if (!ok)
      Finish(grpc::Status::CANCELLED);
    else if (next_ == file_.size)
      Finish(grpc::Status::OK);
    else
      send_next();
  }

  void OnCancel() override { cancelled_ = true; }

  void OnDone() override { delete this; }

private:
  grpc::Status open(const Call& call) {
    if (const auto unwanted = no_longer_wanted(call)) return *unwanted;
    if (const auto status = open_(call, file_); !status.ok()) return status;
    if (next_ < 0 || next_ > file_.size)
      return {grpc::StatusCode::OUT_OF_RANGE,
              file_.name + " has " + std::to_string(file_.size) + " bytes; begin again from 0"};
    chunk_.set_total_size_bytes(file_.size);
    chunk_.set_sha256(file_.sha256);
    return grpc::Status::OK;
  }

  void send_next() {
    const auto size = static_cast<std::size_t>(std::min(chunk_size, file_.size - next_));
    const grpc::Status status = guarded([&] {
      chunk_.set_offset(next_);
      chunk_.mutable_data()->resize(size);
      if (file_.file.read_at(next_, *chunk_.mutable_data()) == size)
        return grpc::Status::OK;
      return grpc::Status(grpc::StatusCode::DATA_LOSS, "the file became shorter while it was read");
    });
    if (!status.ok()) return Finish(status);
    next_ += static_cast<std::int64_t>(size);
    StartWrite(&chunk_);
  }

  std::int64_t next_;  ///< byte to be sent next
  const OpenFile open_;
  std::atomic<bool> cancelled_{false};
  SentFile file_;
  v1::FetchResultResponse chunk_;
};

}  // namespace

grpc::ServerWriteReactor<v1::FetchResultResponse>* send_file(WorkPool& lane, const StreamCall& call,
                                                             std::int64_t offset, OpenFile open) {
  auto* stream = new FileStream(offset, std::move(open));  // deleted in OnDone
  stream->begin(lane, call);
  return stream;
}

}  // namespace dccast::service
