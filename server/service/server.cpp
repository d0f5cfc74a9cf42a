#include "server/service/server.hpp"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server_builder.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <cerrno>
#include <chrono>
#include <functional>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include "server/jobs/socket_path.hpp"
#include "server/service/grpc_trouble.hpp"

namespace dccast::service {

namespace {

/// Clients may ping as often as every 10 s, also between calls; without this gRPC answers them with
/// "too many pings" and hangs up.
void permit_pings(grpc::ServerBuilder& builder) {
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 20000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 5000);
}

/// Workers that may call: as many as the schema permits to run, with those that wait and leave.
constexpr std::size_t most_workers = 3 * 4096;

/// A connection that is silent from the start, or falls silent, is closed: a client that is alive
/// reconnects without noticing.
void end_idle_connections(grpc::ServerBuilder& builder) {
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, 10000);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, 600000);
}

/// Hands accepted connections to gRPC, see Door.
std::function<void(int)> hand_over(
    std::shared_ptr<grpc::experimental::ExternalConnectionAcceptor> acceptor) {
  return [acceptor = std::move(acceptor)](int connection) {
    grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
    parameters.fd = connection;
    acceptor->HandleNewConnection(&parameters);
  };
}

std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> interceptors() {
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> all;
  all.push_back(std::make_unique<UnreadableRequests>());
  return all;
}

}  // namespace

LinkAddress::LinkAddress(const std::filesystem::path& data_directory)
    : socket_(std::filesystem::absolute(data_directory) / "worker.sock") {
  std::filesystem::remove(socket_);  // of a daemon that was killed
}

LinkAddress::~LinkAddress() {
  std::error_code ignored;
  std::filesystem::remove(socket_, ignored);
}

storage::FileDescriptor LinkAddress::listen() const {
  const jobs::SocketPath short_path(grpc_address());
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  short_path.path().string().copy(address.sun_path, sizeof address.sun_path - 1);
  storage::FileDescriptor listening(
      ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!listening ||
      ::bind(listening.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::chmod(socket_.c_str(), S_IRUSR | S_IWUSR) != 0 || ::listen(listening.get(), SOMAXCONN) != 0)
    throw std::system_error(errno, std::generic_category(),
                            "cannot listen for workers on " + socket_.string());
  return listening;
}

LinkServer::LinkServer(jobs::Scheduler& scheduler, const LinkAddress& address)
    : listening_(address.listen()), link_(scheduler) {
  grpc::ServerBuilder builder;
  auto acceptor = builder.experimental().AddExternalConnectionAcceptor(
      grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD,
      grpc::InsecureServerCredentials());
  builder.RegisterService(&link_);
  server_ = builder.BuildAndStart();
  if (!server_) throw std::runtime_error("gRPC cannot serve workers");
  door_ = std::make_unique<Door>(listening_.get(), most_workers, hand_over(std::move(acceptor)));
}

LinkServer::~LinkServer() {
  door_.reset();
  server_->Shutdown(std::chrono::system_clock::now() + std::chrono::milliseconds(200));
  server_->Wait();
}

PublicServer::PublicServer(Context& context, studies::Studies& studies, const std::string& listen)
    : socket_(listen), service_(context, studies, socket_.address()) {
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  auto acceptor = builder.experimental().AddExternalConnectionAcceptor(
      grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD,
      grpc::InsecureServerCredentials());
  builder.experimental().SetInterceptorCreators(interceptors());
  builder.RegisterService(&service_);
  builder.SetMaxReceiveMessageSize(static_cast<int>(context.maximum_message_bytes));
  permit_pings(builder);
  end_idle_connections(builder);
  server_ = builder.BuildAndStart();
  if (!server_) throw std::runtime_error("gRPC cannot serve on " + socket_.address());
  door_ = std::make_unique<Door>(socket_.descriptor(), context.maximum_connections,
                                 hand_over(std::move(acceptor)));
}

PublicServer::~PublicServer() {
  shut_down();
}

void PublicServer::announce_end() {
  server_->GetHealthCheckService()->SetServingStatus(false);
}

void PublicServer::shut_down() {
  door_.reset();  // gRPC takes no connection once it ends
  server_->Shutdown(std::chrono::system_clock::now() + std::chrono::seconds(1));
  server_->Wait();
}

}  // namespace dccast::service
