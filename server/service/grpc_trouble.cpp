#include "server/service/grpc_trouble.hpp"

#include <grpc/support/log.h>
#include <spdlog/spdlog.h>

#include <string>

namespace dccast::service {

namespace {

using grpc::experimental::InterceptionHookPoints;

/// Lives as long as its call.
class Answer final : public grpc::experimental::Interceptor {
public:
  explicit Answer(std::string method) : method_(std::move(method)) {}

  void Intercept(grpc::experimental::InterceptorBatchMethods* batch) override {
    if (batch->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS)) {
      const grpc::Status status = batch->GetSendStatus();
      // No handler of ours answers so: each that refuses gives its reason.
      if (status.error_code() == grpc::StatusCode::UNIMPLEMENTED && status.error_message().empty())
        batch->ModifySendStatus({grpc::StatusCode::INVALID_ARGUMENT,
                                 "the request of " + method_ +
                                     " cannot be read as the message service.proto names; use a "
                                     "client made from it"});
    }
    batch->Proceed();
  }

private:
  const std::string method_;
};

}  // namespace

void log_grpc_as_debug() {
  gpr_set_log_function([](gpr_log_func_args* line) {
    spdlog::debug("gRPC {}:{}: {}", line->file, line->line, line->message);
  });
}

grpc::experimental::Interceptor* UnreadableRequests::CreateServerInterceptor(
    grpc::experimental::ServerRpcInfo* call) {
  return new Answer(call->method());
}

}  // namespace dccast::service
