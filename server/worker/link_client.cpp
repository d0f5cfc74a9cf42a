#include "server/worker/link_client.hpp"

#include <grpc/support/time.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <iostream>
#include <utility>

namespace dccast::worker {

namespace {

constexpr int exit_daemon_gone = 70;
constexpr std::chrono::seconds acknowledgement_time{30};

/// Between two calls of a daemon that is not there.
constexpr std::chrono::milliseconds between_calls{100};

/// From the order to stop, because no daemon came, to the end of the process: for a run that is in
/// the middle of a long step.
constexpr std::chrono::seconds last_step_time{60};

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
  // A new daemon waits for its workers no longer than for one that it has started.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 500);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

/// The worker's files are whole at any moment: the next attempt goes on from the checkpoint.
[[noreturn]] void leave(const std::string& why) {
  std::cerr << "dccast-worker: " << why << std::endl;
  ::_exit(exit_daemon_gone);
}

/// The code of a call that broke, whoever noticed it, or that a daemon ended while it left; one
/// that refuses a worker says why, with another code.
bool tells_that_daemon_is_gone(const grpc::Status& status) {
  return status.ok() || status.error_code() == grpc::StatusCode::UNAVAILABLE ||
         status.error_code() == grpc::StatusCode::CANCELLED ||
         status.error_code() == grpc::StatusCode::UNKNOWN;
}

}  // namespace

LinkClient::LinkClient(const std::string& address)
    : socket_(address),
      channel_(channel_to(socket_.address())),
      stub_(v1::WorkerLink::NewStub(channel_)) {
  ::signal(SIGTERM, note_leave);
}

LinkClient::~LinkClient() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    // First: the sender may be waiting for a daemon that does not read.
    for (const auto& call : {call_, calling_})
      if (call) call->context.TryCancel();
  }
  changed_.notify_all();
  if (sender_.joinable()) sender_.join();
  if (receiver_.joinable()) receiver_.join();
}

/// Calls a daemon. @return nothing when there is none or it refuses; `call` tells why then
std::optional<v1::WorkerOrder::Start> LinkClient::greet(Call& call) {
  v1::WorkerMessage message;
  *message.mutable_hello() = hello_;
  v1::WorkerOrder order;
  call.stream = stub_->Run(&call.context);
  if (!call.stream->Write(message) || !call.stream->Read(&order)) return std::nullopt;
  if (order.has_start()) return std::move(*order.mutable_start());
  call.context.TryCancel();  // else its end would be waited for
  return std::nullopt;
}

std::optional<v1::WorkerOrder::Start> LinkClient::begin(const v1::WorkerMessage::Hello& hello) {
  hello_ = hello;
  const auto call = std::make_shared<Call>();
  auto start = greet(*call);
  if (!start) {
    std::cerr << "dccast-worker: " << call->stream->Finish().error_message() << '\n';
    return std::nullopt;
  }
  hello_.set_running(true);  // in every further call
  call_ = call;
  set_heartbeat(*start);
  sender_ = std::thread([this] { run_sender(); });
  receiver_ = std::thread([this, call] { run_receiver(call); });
  return start;
}

void LinkClient::set_heartbeat(const v1::WorkerOrder::Start& start) {
  const std::chrono::duration<double> interval(start.heartbeat_interval_s());
  heartbeat_ = std::chrono::duration_cast<Clock::duration>(interval);
  beat_ = Clock::now() + heartbeat_;
}

void LinkClient::outlive_daemon(Clock::duration patience, std::function<bool()> wanted) {
  const std::lock_guard lock(mutex_);
  patience_ = patience;
  wanted_ = std::move(wanted);
  outbox_.keep(true);
}

void LinkClient::send(v1::WorkerMessage message) {
  std::unique_lock lock(mutex_);
  // At intervals: nobody wakes this when SIGTERM comes.
  while (outbox_.is_full() && !closed_ && !waits_in_vain()) changed_.wait_for(lock, between_calls);
  outbox_.add(std::move(message));
  lock.unlock();
  changed_.notify_all();
}

casting::Order LinkClient::order() const {
  const casting::Order order = order_;
  if (order == casting::Order::go_on && told_to_leave) return casting::Order::stop_at_checkpoint;
  return order;
}

/// Whether no daemon will hear anything more.
bool LinkClient::waits_in_vain() const {
  return !call_ && (gave_up_ || told_to_leave);
}

bool LinkClient::finish(v1::WorkerMessage::Finished finished) {
  v1::WorkerMessage message;
  *message.mutable_finished() = std::move(finished);
  send(std::move(message));
  std::unique_lock lock(mutex_);
  auto end = Clock::now() + acknowledgement_time;
  while (!is_over() && !waits_in_vain() && Clock::now() < end) {
    if (!call_) end = Clock::now() + acknowledgement_time;  // of the next daemon
    changed_.wait_for(lock, between_calls);
  }
  return acknowledged_;
}

// --- The thread that sends ---

LinkClient::Clock::time_point LinkClient::next_wake() const {
  constexpr std::chrono::hours longest{1};
  if (!call_) return Clock::now() + between_calls;
  const bool beats = heartbeat_ > Clock::duration::zero() && !outbox_.said_last_word();
  return beats ? beat_ : Clock::now() + longest;
}

/// Without a daemon the run stops at a checkpoint after a while, and the process ends at last.
void LinkClient::look_at_patience() {
  if (call_ || patience_ == Clock::duration::zero()) return;
  const auto waited = Clock::now() - lost_at_;
  if (waited > patience_ + last_step_time) leave("no dccastd came, and the run does not stop");
  if (waited <= patience_ || gave_up_) return;
  std::cerr << "dccast-worker: no dccastd came: the run stops at a checkpoint" << std::endl;
  gave_up_ = true;
  if (order_ == casting::Order::go_on) order_ = casting::Order::stop_at_checkpoint;
  changed_.notify_all();
}

/// Waits for something to be said. @return nothing once the link is closed
std::optional<LinkClient::Turn> LinkClient::next_turn() {
  std::unique_lock lock(mutex_);
  for (;;) {
    if (closed_) return std::nullopt;
    look_at_patience();
    const auto wake = next_wake();
    const bool beat_is_due = call_ && Clock::now() >= wake;
    if (call_ && (beat_is_due || outbox_.has_unsent())) {
      Turn turn{call_, {}};
      if (beat_is_due) {
        turn.messages.emplace_back().mutable_heartbeat();  // before a last word
        beat_ = Clock::now() + heartbeat_;
      }
      for (auto& message : outbox_.take()) turn.messages.push_back(std::move(message));
      call_->writing = true;
      changed_.notify_all();  // there is room again
      return turn;
    }
    changed_.wait_until(lock, wake);
  }
}

/// @return whether the daemon can still be reached
bool LinkClient::write(const Turn& turn) {
  for (std::size_t i = 0; i < turn.messages.size(); ++i) {
    grpc::WriteOptions options;
    if (i + 1 < turn.messages.size()) options.set_buffer_hint();  // a batch in one write
    if (!turn.call->stream->Write(turn.messages[i], options)) return false;
  }
  return true;
}

void LinkClient::run_sender() {
  while (auto turn = next_turn()) {
    const bool reached = write(*turn);
    const std::lock_guard lock(mutex_);
    turn->call->writing = false;
    // The receiver sees the end of the call, too, and calls again.
    if (!reached) lose(turn->call);
    changed_.notify_all();
  }
}

// --- The thread that receives ---

void LinkClient::obey(const v1::WorkerOrder& order) {
  if (order.has_stop())
    order_ =
        order.stop().checkpoint() ? casting::Order::stop_at_checkpoint : casting::Order::cancel;
  const std::lock_guard lock(mutex_);
  if (order.has_stored()) outbox_.forget_stored(order.stored().reports());
  if (order.has_acknowledged()) acknowledged_ = true;
  if (order.has_stored() || order.has_acknowledged()) changed_.notify_all();
}

void LinkClient::lose(const std::shared_ptr<Call>& call) {
  if (call_ != call) return;
  call_.reset();
  lost_at_ = Clock::now();
}

/// Obeys until the call has ended. @return how it has
grpc::Status LinkClient::read_orders(const std::shared_ptr<Call>& call) {
  v1::WorkerOrder order;
  while (call->stream->Read(&order)) obey(order);
  std::unique_lock lock(mutex_);
  lose(call);
  changed_.notify_all();
  // A call is finished when nobody writes; a write should have failed by now.
  const auto unwritten = [&call] { return !call->writing; };
  if (!changed_.wait_for(lock, between_calls, unwritten)) call->context.TryCancel();
  changed_.wait(lock, unwritten);
  lock.unlock();
  return call->stream->Finish();
}

/// A call that the daemon has ended, or refused, with a reason of its own is not made again.
void LinkClient::require_another_call(const grpc::Status& status) {
  const std::lock_guard lock(mutex_);
  if (is_over()) return;
  if (patience_ == Clock::duration::zero() || !tells_that_daemon_is_gone(status))
    leave("the link to dccastd has ended: " + status.error_message());
}

/// @return false when the next daemon cannot get what it lacks
bool LinkClient::take_up(const std::shared_ptr<Call>& call, const v1::WorkerOrder::Start& start) {
  const std::lock_guard lock(mutex_);
  if (!outbox_.rewind(start.reports_stored())) return false;
  const std::chrono::duration<double> patience(start.daemon_patience_s());
  patience_ = std::chrono::duration_cast<Clock::duration>(patience);
  outbox_.keep(patience_ > Clock::duration::zero());  // else it would not hear what is stored
  set_heartbeat(start);
  call_ = call;
  calling_.reset();
  changed_.notify_all();
  return true;
}

/// Waits a little. @return the next call, not made yet; null when the link is over
std::shared_ptr<LinkClient::Call> LinkClient::next_call() {
  std::unique_lock lock(mutex_);
  if (changed_.wait_for(lock, between_calls, [this] { return is_over(); })) return nullptr;
  return calling_ = std::make_shared<Call>();
}

/// Waits a little for a daemon to be there. A call alone would not do: it fails at once as long as
/// there is none, and without a thread that waits gRPC gets on with a connection every five
/// seconds.
bool LinkClient::reach_daemon() const {
  return channel_->WaitForConnected(gpr_time_add(
      gpr_now(GPR_CLOCK_MONOTONIC), gpr_time_from_millis(between_calls.count(), GPR_TIMESPAN)));
}

/// @return the call of a daemon that has taken the run up; null when the link is over
std::shared_ptr<LinkClient::Call> LinkClient::call_next_daemon() {
  while (const auto call = next_call()) {
    if (!wanted_()) leave("the folder of the job is gone");
    if (!reach_daemon()) continue;
    if (const auto start = greet(*call)) {
      if (!take_up(call, *start)) leave("dccastd lacks reports that are no longer here");
      std::cerr << "dccast-worker: goes on with the next dccastd" << std::endl;
      return call;
    }
    require_another_call(call->stream->Finish());
  }
  return nullptr;
}

void LinkClient::run_receiver(std::shared_ptr<Call> call) {
  while (call) {
    require_another_call(read_orders(call));
    call = call_next_daemon();
  }
}

}  // namespace dccast::worker
