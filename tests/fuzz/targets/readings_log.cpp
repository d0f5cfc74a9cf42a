// The record of a job that follows a casting. A text whose first byte is odd stands for whole
// entries, so that what they hold is reached: 255 ends each of them.
#include "server/jobs/logs/readings_log.hpp"
#include "core/storage/file.hpp"
#include "core/storage/record_log.hpp"
#include "server/jobs/folder/format.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dccast;

namespace {

std::string framed(std::string_view text) {
  v1::RecordEntry following;
  following.mutable_following()->add_gauges()->set_monitor("corner");
  std::string file =
      jobs::file_header("DCCASTRD") + storage::short_records.framed(following.SerializeAsString());
  std::int64_t number = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\xff'), text.size());
    std::string payload(text.substr(0, end));
    v1::RecordEntry entry;
    // Numbered as a record numbers them, unless it is no entry.
    if (entry.ParseFromString(payload) && entry.has_reading()) {
      entry.mutable_reading()->set_number(++number);
      payload = entry.SerializeAsString();
    }
    if (!payload.empty()) file += storage::short_records.framed(payload);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return file;
}

void read() {
  jobs::ReadingsReader reader(fuzz::folder());
  const auto readings = reader.read_new();
  fuzz::require(reader.read_new().empty(), "a record is read once");

  // What the daemon takes over is what a worker has read, and it can go on.
  jobs::ReadingsLog log(fuzz::folder());
  const v1::AppendReadingsResponse state = log.state();
  fuzz::require(state.number() == std::int64_t(readings.size()), "reader and log agree");
  if (state.closed()) return;
  google::protobuf::RepeatedPtrField<v1::Reading> next;
  next.Add()->set_number(state.number() + 1);
  next[0].set_closes(true);
  log.append(next);
  fuzz::require(reader.read_new().size() == 1, "what was added is read");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  std::string_view text = fuzz::text_of(bytes, size);
  const bool whole = fuzz::take_choice(text) % 2 == 1;
  storage::write_file(fuzz::folder() / jobs::readings_file,
                      whole ? framed(text) : std::string(text));
  try {
    read();
  } catch (const jobs::DamagedReadings&) {
  }
  return 0;
}
