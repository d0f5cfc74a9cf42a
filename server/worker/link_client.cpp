#include "server/worker/link_client.hpp"

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <iostream>
#include <utility>

namespace dccast::worker {

namespace {

constexpr std::size_t most_outgoing = 4096;
constexpr int exit_daemon_gone = 70;
constexpr std::chrono::seconds acknowledgement_time{30};

volatile std::sig_atomic_t told_to_leave = 0;

extern "C" void note_leave(int) {
  told_to_leave = 1;
}

std::shared_ptr<grpc::Channel> channel_to(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);  // the daemon has limited the case already
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

}  // namespace

LinkClient::LinkClient(const std::string& address)
    : stub_(v1::WorkerLink::NewStub(channel_to(address))) {
  ::signal(SIGTERM, note_leave);
}

LinkClient::~LinkClient() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  changed_.notify_all();
  if (sender_.joinable()) sender_.join();
  context_.TryCancel();
  if (receiver_.joinable()) receiver_.join();
}

std::optional<v1::WorkerOrder::Start> LinkClient::begin(const v1::WorkerMessage::Hello& hello) {
  stream_ = stub_->Run(&context_);
  v1::WorkerMessage message;
  *message.mutable_hello() = hello;
  v1::WorkerOrder order;
  if (!stream_->Write(message) || !stream_->Read(&order) || !order.has_start()) {
    std::cerr << "dccast-worker: " << stream_->Finish().error_message() << '\n';
    return std::nullopt;
  }
  sender_ = std::thread([this] { run_sender(); });
  receiver_ = std::thread([this] { run_receiver(); });
  return std::move(*order.mutable_start());
}

void LinkClient::send(v1::WorkerMessage message) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return outgoing_.size() < most_outgoing || closed_; });
  outgoing_.push_back(std::move(message));
  lock.unlock();
  changed_.notify_all();
}

casting::Order LinkClient::order() const {
  const casting::Order order = order_;
  if (order == casting::Order::go_on && told_to_leave) return casting::Order::stop_at_checkpoint;
  return order;
}

bool LinkClient::finish(v1::WorkerMessage::Finished finished) {
  v1::WorkerMessage message;
  *message.mutable_finished() = std::move(finished);
  send(std::move(message));
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, acknowledgement_time, [this] { return acknowledged_ || closed_; });
  return acknowledged_;
}

void LinkClient::run_sender() {
  for (;;) {
    std::deque<v1::WorkerMessage> messages;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return !outgoing_.empty() || closed_; });
      if (outgoing_.empty()) break;
      messages.swap(outgoing_);
    }
    changed_.notify_all();
    for (std::size_t i = 0; i < messages.size(); ++i) {
      grpc::WriteOptions options;
      if (i + 1 < messages.size()) options.set_buffer_hint();  // a batch in one write
      if (!stream_->Write(messages[i], options)) return;       // the receiver sees the end, too
    }
  }
  stream_->WritesDone();
}

void LinkClient::run_receiver() {
  v1::WorkerOrder order;
  while (stream_->Read(&order)) {
    if (order.has_stop())
      order_ =
          order.stop().checkpoint() ? casting::Order::stop_at_checkpoint : casting::Order::cancel;
    if (!order.has_acknowledged()) continue;
    const std::lock_guard lock(mutex_);
    acknowledged_ = true;
    changed_.notify_all();
  }
  const std::lock_guard lock(mutex_);
  if (acknowledged_ || closed_) return;
  // The daemon is gone, or wants nothing of us any more; the next one goes on from the checkpoint.
  std::cerr << "dccast-worker: the link to dccastd has ended\n";
  ::_exit(exit_daemon_gone);
}

}  // namespace dccast::worker
