// What a login reads: the enrolment line, an address, the file of stored servers.
#include "client/session/failure.hpp"
#include "client/session/servers.hpp"
#include "client/session/socket.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dccast;

namespace {

void read(unsigned choice, const std::string& text) {
  if (choice % 3 == 0) {
    const auto line = client::read_enrolment_line(text);
    fuzz::require(!line.address.empty() && line.fingerprint.size() == 64 && !line.secret.empty(),
                  "an enrolment line has three parts");
  } else if (choice % 3 == 1) {
    values::host_and_port(text);
    client::endpoint_of(text);
  } else {
    const client::StoredServers servers(fuzz::file_with(text));
    servers.find("casthouse");
    servers.find("");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  std::string_view text = fuzz::text_of(bytes, size);
  const unsigned choice = fuzz::take_choice(text);
  try {
    read(choice, std::string(text));
  } catch (const client::CommandFailed&) {
  }
  return 0;
}
