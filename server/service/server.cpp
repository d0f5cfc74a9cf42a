#include "server/service/server.hpp"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server_builder.h>
#include <stdlib.h>
#include <sys/un.h>

#include <chrono>
#include <stdexcept>

namespace dccast::service {

namespace {

std::string host_of(const std::string& address) {
  return address.substr(0, address.rfind(':'));
}

/// Clients may ping as often as every 10 s, also between calls; without this gRPC answers them with
/// "too many pings" and hangs up.
void permit_pings(grpc::ServerBuilder& builder) {
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 20000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 5000);
}

}  // namespace

bool is_loopback(const std::string& address) {
  const std::string host = host_of(address);
  return host == "localhost" || host == "[::1]" ||
         (host.starts_with("127.") && host.find_first_not_of("0123456789.") == std::string::npos);
}

LinkAddress::LinkAddress(const std::filesystem::path& data_directory)
    : socket_(std::filesystem::absolute(data_directory) / "worker.sock") {
  if (socket_.string().size() >= sizeof(sockaddr_un::sun_path)) {
    std::string name = (std::filesystem::temp_directory_path() / "dccastd-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
      throw std::runtime_error("cannot make a folder for the worker link: " + name);
    private_folder_ = name;
    socket_ = private_folder_ / "worker.sock";
  }
  std::filesystem::remove(socket_);  // of a daemon that was killed
}

LinkAddress::~LinkAddress() {
  std::error_code ignored;
  std::filesystem::remove(socket_, ignored);
  if (!private_folder_.empty()) std::filesystem::remove(private_folder_, ignored);
}

LinkServer::LinkServer(jobs::Scheduler& scheduler, const LinkAddress& address) : link_(scheduler) {
  grpc::ServerBuilder builder;
  builder.AddListeningPort(address.grpc_address(), grpc::InsecureServerCredentials());
  builder.RegisterService(&link_);
  server_ = builder.BuildAndStart();
  if (!server_) throw std::runtime_error("cannot listen for workers on " + address.grpc_address());
}

LinkServer::~LinkServer() {
  server_->Shutdown(std::chrono::system_clock::now() + std::chrono::milliseconds(200));
  server_->Wait();
}

PublicServer::PublicServer(Context& context, const std::string& listen) : service_(context) {
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort(listen, grpc::InsecureServerCredentials(), &port);
  builder.RegisterService(&service_);
  builder.SetMaxReceiveMessageSize(static_cast<int>(context.maximum_message_bytes));
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);  // else two daemons share a port
  permit_pings(builder);
  server_ = builder.BuildAndStart();
  if (!server_ || port == 0)
    throw std::runtime_error("cannot listen on " + listen +
                             "; is another dccastd there? Port 0 takes a free one");
  address_ = host_of(listen) + ":" + std::to_string(port);
}

PublicServer::~PublicServer() {
  shut_down();
}

void PublicServer::announce_end() {
  server_->GetHealthCheckService()->SetServingStatus(false);
}

void PublicServer::shut_down() {
  server_->Shutdown(std::chrono::system_clock::now() + std::chrono::seconds(1));
  server_->Wait();
}

}  // namespace dccast::service
