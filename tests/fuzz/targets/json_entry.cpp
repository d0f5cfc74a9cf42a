// The entry for programs, without a server: two bytes choose form and method. Requests are
// read as JSON and as messages of a stream, errors are written from details of any kind, and
// targets are taken apart.
#include <google/protobuf/descriptor.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <google/protobuf/util/message_differencer.h>

#include <memory>

#include "client/web/connect_messages.hpp"
#include "dccast/v1/service.pb.h"
#include "proto/http/target.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dccast;

namespace {

namespace pb = google::protobuf;

const pb::MethodDescriptor& method_of(unsigned choice) {
  static const auto* calls = v1::SubmitJobRequest::descriptor()->file()->service(0);
  return *calls->method(static_cast<int>(choice % calls->method_count()));
}

std::unique_ptr<pb::Message> message_of(const pb::Descriptor& type, const std::string& bytes) {
  std::unique_ptr<pb::Message> message(
      pb::MessageFactory::generated_factory()->GetPrototype(&type)->New());
  fuzz::require(message->ParseFromString(bytes), "what was read is a message");
  return message;
}

/// A request that is read is the same when it is written and read again.
void read_json(const pb::MethodDescriptor& method, const std::string& text) {
  std::string bytes, again;
  if (!client::read_request(method, true, text, bytes).ok()) return;
  const std::string json = client::json_of_message(method.input_type()->full_name(), bytes);
  fuzz::require(client::read_request(method, true, json, again).ok(), "its JSON is read");

  const auto first = message_of(*method.input_type(), bytes);
  const auto second = message_of(*method.input_type(), again);
  pb::util::MessageDifferencer differencer;
  differencer.set_message_field_comparison(pb::util::MessageDifferencer::EQUIVALENT);
  pb::util::DefaultFieldComparator comparator;
  comparator.set_treat_nan_as_equal(true);
  differencer.set_field_comparator(&comparator);
  fuzz::require(differencer.Compare(*first, *second), "its JSON is the same request");
}

void read_stream(const pb::MethodDescriptor& method, std::string_view text) {
  const auto messages = client::messages_of(text);
  if (!messages) return;
  std::string body;
  for (const std::string& message : *messages) {
    body += client::enveloped(message);
    read_json(method, message);
  }
  const bool has_flags = body != text;  // other than those of compression, which are not read
  fuzz::require(has_flags || client::messages_of(body) == messages, "messages are read again");
}

void write_error(unsigned choice, const std::string& text) {
  const auto code = static_cast<grpc::StatusCode>(choice % 17);
  const std::string error = client::error_text({code, text, text}, "");
  pb::Struct read;
  fuzz::require(pb::util::JsonStringToMessage(error, &read).ok(), "an error is JSON");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  std::string_view text = fuzz::text_of(bytes, size);
  const unsigned form = fuzz::take_choice(text) % 4, choice = fuzz::take_choice(text);
  if (form == 0) read_json(method_of(choice), std::string(text));
  if (form == 1) read_stream(method_of(choice), text);
  if (form == 2) write_error(choice, std::string(text));
  if (form == 3) http::parse_target(text);
  return 0;
}
