#include "proto/refusal/refusal.hpp"

#include <google/protobuf/message.h>

#include <utility>

namespace dccast::refusal {

namespace {

constexpr const char* domain = "dccast";
constexpr const char* error_info_url = "type.googleapis.com/google.rpc.ErrorInfo";

Facts as_limit(Facts facts) {
  facts.reason = v1::ErrorInfo::LIMIT_REACHED;
  return facts;
}

v1::ErrorInfo to_error_info(const Facts& facts) {
  v1::ErrorInfo info;
  info.set_reason(v1::ErrorInfo::Reason_Name(facts.reason));
  info.set_domain(domain);

  auto& metadata = *info.mutable_metadata();
  if (!facts.limit.empty()) metadata["limit"] = facts.limit;
  if (!facts.permitted.empty()) metadata["permitted"] = facts.permitted;
  if (!facts.remedy.empty()) metadata["remedy"] = facts.remedy;
  // The trailers of a call are short, so the message is not repeated.
  if (!metadata.empty()) metadata["cause"] = facts.cause;
  return info;
}

Facts to_facts(const v1::ErrorInfo& info, const std::string& message) {
  const auto value = [&](const char* key) {
    const auto found = info.metadata().find(key);
    return found == info.metadata().end() ? std::string() : found->second;
  };

  Facts facts{.limit = value("limit"), .permitted = value("permitted"), .remedy = value("remedy")};
  // A later version may know further reasons: they stay unspecified.
  v1::ErrorInfo::Reason_Parse(info.reason(), &facts.reason);
  facts.cause = info.metadata().contains("cause") ? value("cause") : message;
  return facts;
}

}  // namespace

std::string Facts::message() const {
  std::string text = cause;
  if (!limit.empty() && !permitted.empty()) text += "; " + limit + " = " + permitted;
  if (!remedy.empty()) text += "; " + remedy;
  return text;
}

LimitReached::LimitReached(Facts facts)
    : std::runtime_error(facts.message()), facts_(as_limit(std::move(facts))) {}

std::string write_details(int code, const Facts& facts, const google::protobuf::Message* detail) {
  v1::StatusDetails status;
  status.set_code(code);
  status.set_message(facts.message());

  google::protobuf::Any& info = *status.add_details();
  info.set_type_url(error_info_url);
  info.set_value(to_error_info(facts).SerializeAsString());

  if (detail != nullptr) status.add_details()->PackFrom(*detail);
  return status.SerializeAsString();
}

std::optional<Facts> read_details(const std::string& details) {
  v1::StatusDetails status;
  if (!status.ParseFromString(details)) return std::nullopt;

  for (const google::protobuf::Any& detail : status.details()) {
    v1::ErrorInfo info;
    if (detail.type_url() != error_info_url || !info.ParseFromString(detail.value())) continue;
    if (info.domain() == domain) return to_facts(info, status.message());
  }
  return std::nullopt;
}

bool read_detail(const std::string& details, google::protobuf::Message& to) {
  v1::StatusDetails status;
  if (!status.ParseFromString(details)) return false;
  for (const google::protobuf::Any& detail : status.details())
    if (detail.UnpackTo(&to)) return true;
  to.Clear();
  return false;
}

}  // namespace dccast::refusal
