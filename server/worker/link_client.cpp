#include "server/worker/link_client.hpp"

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <iostream>
#include <utility>

namespace dccast::worker {

namespace {

constexpr std::size_t most_outgoing = 4096;
constexpr int exit_daemon_gone = 70;
constexpr std::chrono::seconds acknowledgement_time{30};

// Set by a signal handler, read by the thread of the run: only a lock-free atomic serves both.
std::atomic<bool> told_to_leave = false;
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void note_leave(int) {
  told_to_leave = true;
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
  context_.TryCancel();  // first: the sender may be waiting for a daemon that does not read
  if (sender_.joinable()) sender_.join();
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
  const std::chrono::duration<double> heartbeat(order.start().heartbeat_interval_s());
  sender_ = std::thread([this, interval = std::chrono::duration_cast<Clock::duration>(heartbeat)] {
    run_sender(interval);
  });
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

std::optional<std::deque<v1::WorkerMessage>> LinkClient::take_outgoing(Clock::time_point beat) {
  std::deque<v1::WorkerMessage> messages;
  std::unique_lock lock(mutex_);
  const auto woken = [this] { return !outgoing_.empty() || closed_; };
  if (beat == Clock::time_point::max())
    changed_.wait(lock, woken);  // waiting until the end of time overflows in the library
  else
    changed_.wait_until(lock, beat, woken);
  messages.swap(outgoing_);
  if (messages.empty() && closed_) return std::nullopt;
  lock.unlock();
  changed_.notify_all();
  return messages;
}

bool LinkClient::write(const std::deque<v1::WorkerMessage>& messages) {
  for (std::size_t i = 0; i < messages.size(); ++i) {
    grpc::WriteOptions options;
    if (i + 1 < messages.size()) options.set_buffer_hint();  // a batch in one write
    if (!stream_->Write(messages[i], options)) return false;
  }
  return true;
}

void LinkClient::run_sender(Clock::duration heartbeat) {
  const bool beats = heartbeat > Clock::duration::zero();
  auto beat = beats ? Clock::now() + heartbeat : Clock::time_point::max();
  while (auto messages = take_outgoing(beat)) {
    if (Clock::now() >= beat) {
      messages->emplace_front().mutable_heartbeat();  // before a last word
      beat = Clock::now() + heartbeat;
    }
    if (!write(*messages)) return;  // the receiver sees the end, too
    const bool last_word = !messages->empty() && messages->back().has_finished();
    if (last_word) beat = Clock::time_point::max();
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
