#include "client/session/connection.hpp"

#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>

#include <iostream>
#include <map>
#include <thread>

namespace dccast::client {

std::string address_of(const std::string& server) {
  if (server.starts_with("unix:")) return server;
  if (server.find("://") != std::string::npos)
    throw invalid("--server " + server + ": write HOST:PORT, without " +
                  server.substr(0, server.find("://") + 3));
  const auto colon = server.rfind(':');
  const bool has_port = colon != std::string::npos && server.find(']', colon) == std::string::npos;
  return has_port ? server : server + default_port;
}

namespace {

/// Headers of each call that dccast-web makes for a browser.
class ForBrowser final : public grpc::MetadataCredentialsPlugin {
public:
  explicit ForBrowser(const Endpoint& endpoint) : endpoint_(endpoint) {}

  bool IsBlocking() const override { return false; }
  grpc::Status GetMetadata(grpc::string_ref, grpc::string_ref, const grpc::AuthContext&,
                           std::multimap<grpc::string, grpc::string>* headers) override {
    headers->emplace("dccast-client-address", endpoint_.browser);
    if (!endpoint_.token.empty()) headers->emplace("authorization", "Bearer " + endpoint_.token);
    return grpc::Status::OK;
  }

private:
  const Endpoint endpoint_;
};

std::shared_ptr<grpc::ChannelCredentials> credentials_of(const Endpoint& endpoint) {
  if (!endpoint.browser.empty())
    return grpc::CompositeChannelCredentials(
        grpc::experimental::LocalCredentials(UDS),
        grpc::MetadataCredentialsFromPlugin(std::make_unique<ForBrowser>(endpoint)));
  if (endpoint.ca.empty()) return grpc::InsecureChannelCredentials();
  auto tls = grpc::SslCredentials({.pem_root_certs = endpoint.ca,
                                   .pem_private_key = endpoint.key,
                                   .pem_cert_chain = endpoint.certificate});
  if (endpoint.token.empty()) return tls;
  return grpc::CompositeChannelCredentials(tls, grpc::AccessTokenCredentials(endpoint.token));
}

std::shared_ptr<grpc::Channel> channel_to(const Endpoint& endpoint) {
  grpc::ChannelArguments arguments;
  // Histories and frames of long runs exceed gRPC's default of 4 MiB.
  arguments.SetMaxReceiveMessageSize(-1);
  // A watcher must notice a daemon that disappeared without closing the connection.
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 30000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10000);
  // A proxy would see every case, and the address may exist only on this network.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 200);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2000);
  // Channels of one process would share a connection, and the calls that may be open over it.
  if (!endpoint.browser.empty()) arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(endpoint.address, credentials_of(endpoint), arguments);
}

}  // namespace

Connection::Connection(Endpoint endpoint, std::shared_ptr<Interruption> interruption)
    : Connection(endpoint, channel_to(endpoint), std::move(interruption)) {}

Connection::Connection(Endpoint endpoint, std::shared_ptr<grpc::Channel> channel,
                       std::shared_ptr<Interruption> interruption)
    : endpoint_(std::move(endpoint)),
      channel_(std::move(channel)),
      stub_(v1::SimulationService::NewStub(channel_)),
      interruption_(std::move(interruption)) {}

grpc::Status Connection::with_retries(const std::function<grpc::Status()>& attempt) {
  auto pause = policy_.first_pause;
  for (int made = 1;; ++made, pause *= 2) {
    const grpc::Status status = attempt();
    if (!status.ok() && interruption_->came()) throw Interrupted("");
    if (status.error_code() != grpc::StatusCode::UNAVAILABLE || made >= policy_.attempts)
      return status;
    announce_retry(status, made);
    interruption_->sleep(pause);
  }
}

void Connection::announce_retry(const grpc::Status& status, int attempts_made) const {
  std::cerr << "dccast: no answer from " << server() << " (" << reason_of(status)
            << "); trying again (" << attempts_made << " of " << policy_.attempts - 1 << ")"
            << std::endl;
}

void Interruption::come() {
  const std::lock_guard lock(mutex_);
  came_ = true;
  if (call_ != nullptr) call_->TryCancel();
  changed_.notify_all();
}

bool Interruption::came() const {
  const std::lock_guard lock(mutex_);
  return came_;
}

void Interruption::sleep(std::chrono::milliseconds time) {
  std::unique_lock lock(mutex_);
  if (changed_.wait_for(lock, time, [this] { return came_; })) throw Interrupted("");
}

Interruption::Call::Call(Interruption& interruption, grpc::ClientContext& context)
    : interruption_(interruption) {
  const std::lock_guard lock(interruption_.mutex_);
  interruption_.call_ = &context;
  if (interruption_.came_) context.TryCancel();
}

Interruption::Call::~Call() {
  const std::lock_guard lock(interruption_.mutex_);
  interruption_.call_ = nullptr;
}

void interrupt_by_signals(std::shared_ptr<Interruption> interruption) {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals,
                  nullptr);  // later threads inherit the mask: only this one handles the signals

  std::thread([signals, interruption = std::move(interruption)] {
    int signal = 0;
    sigwait(&signals, &signal);
    interruption->come();
    const timespec grace{1, 0};
    sigtimedwait(&signals, nullptr, &grace);

    // The main thread is computing, or blocked on a pipe that no one reads. FILE.part remains and
    // can be continued.
    static constexpr char message[] = "\ndccast: interrupted; a job that was submitted goes on\n";
    if (const int code = interruption->exit_code(); code >= 0) ::_exit(code);
    // Standard error itself may be the blocked pipe: a write to it would never return.
    pollfd error_output{STDERR_FILENO, POLLOUT, 0};
    if (::poll(&error_output, 1, 0) > 0) [[maybe_unused]]
      const auto written = ::write(STDERR_FILENO, message, sizeof message - 1);
    ::_exit(static_cast<int>(ExitCode::interrupted));
  }).detach();
}

}  // namespace dccast::client
