#include "client/session/byte_call.hpp"

#include <google/protobuf/descriptor.h>
#include <grpcpp/client_context.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/byte_buffer.h>

#include <future>
#include <utility>

#include "dccast/v1/service.pb.h"

namespace dccast::client {
namespace {

grpc::ByteBuffer buffer_of(const std::string& bytes) {
  const grpc::Slice slice(bytes);
  return grpc::ByteBuffer(&slice, 1);
}

std::string bytes_of(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  std::string bytes;
  if (!buffer.Dump(&slices).ok()) return bytes;
  for (const grpc::Slice& slice : slices)
    bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  return bytes;
}

/// A call under way. It keeps itself until gRPC has done with it.
class Reactor : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                public std::enable_shared_from_this<Reactor> {
public:
  Reactor(const std::shared_ptr<grpc::Channel>& channel, ByteCall call)
      : call_(std::move(call)), stub_(channel) {}

  void begin() {
    self_ = shared_from_this();
    context_.set_deadline(call_.deadline);
    const std::string path = "/" + call_.method.service()->full_name() + "/" + call_.method.name();
    stub_.PrepareBidiStreamingCall(&context_, path, grpc::StubOptions(), this);

    AddHold();  // reads begin outside of reactions, too
    write_next();
    StartRead(&response_);
    StartCall();
  }

  void cancel() { context_.TryCancel(); }

  void OnWriteDone(bool ok) override {
    if (ok) write_next();
  }

  void OnReadDone(bool ok) override {
    if (!ok) return RemoveHold();
    call_.received(bytes_of(response_), [self = shared_from_this()](bool goes_on) {
      if (goes_on) return self->StartRead(&self->response_);
      self->context_.TryCancel();
      self->RemoveHold();
    });
  }

  void OnDone(const grpc::Status& status) override {
    const auto self = std::move(self_);
    call_.ended(status);
  }

private:
  void write_next() {
    if (written_ == call_.requests.size()) return;
    request_ = buffer_of(call_.requests[written_++]);
    if (written_ == call_.requests.size())
      StartWriteLast(&request_, grpc::WriteOptions());
    else
      StartWrite(&request_);
  }

  ByteCall call_;
  grpc::GenericStub stub_;
  grpc::ClientContext context_;
  grpc::ByteBuffer request_, response_;
  std::size_t written_ = 0;
  std::shared_ptr<Reactor> self_;
};

}  // namespace

const google::protobuf::MethodDescriptor* find_method(const std::string& name) {
  static const auto& service =
      *v1::GetJobRequest::descriptor()->file()->FindServiceByName("SimulationService");
  return service.FindMethodByName(name);
}

std::function<void()> begin_call(const std::shared_ptr<grpc::Channel>& channel, ByteCall call) {
  // gRPC 1.51 aborts when the last channel with such calls ends in a thread of its own: the first
  // one stays for as long as the process.
  [[maybe_unused]] static const auto* const kept = new std::shared_ptr<grpc::Channel>(channel);
  const auto reactor = std::make_shared<Reactor>(channel, std::move(call));
  reactor->begin();
  return [reactor] { reactor->cancel(); };
}

grpc::Status call_bytes(const std::shared_ptr<grpc::Channel>& channel,
                        const google::protobuf::MethodDescriptor& method, std::string request,
                        std::chrono::system_clock::time_point deadline, std::string& response) {
  std::promise<grpc::Status> status;
  begin_call(channel, {.method = method,
                       .requests = {std::move(request)},
                       .deadline = deadline,
                       .received =
                           [&](std::string bytes, const auto& next) {
                             response = std::move(bytes);
                             next(true);
                           },
                       .ended = [&](const grpc::Status& end) { status.set_value(end); }});
  return status.get_future().get();
}

}  // namespace dccast::client
