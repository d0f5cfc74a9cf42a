// The run log of a job. A text whose first byte is odd stands for whole records, so that what they
// hold is reached: 255 ends each of them.
#include <unistd.h>

#include "core/storage/record_log.hpp"
#include "server/jobs/logs/event_log.hpp"
#include "server/jobs/logs/step_index.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dccast;

namespace {

std::string with_checksums(std::string_view text) {
  std::string file = jobs::event_log_header();
  std::int64_t sequence = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\xff'), text.size());
    std::string payload(text.substr(0, end));
    v1::JobEvent event;
    // Numbered as a log numbers them, unless it is no event.
    if (event.ParseFromString(payload)) {
      event.set_sequence(++sequence);
      payload = event.SerializeAsString();
    }
    if (!payload.empty()) file += storage::short_records.framed(payload);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return file;
}

void read(const std::filesystem::path& path) {
  const auto content = jobs::scan_event_log(path);
  fuzz::require(content.end >= 0 && content.last_sequence >= 0, "a log ends somewhere");
  for (const jobs::EventGap& gap : content.gaps)
    fuzz::require(gap.begin < gap.end || (gap.begin == gap.end && gap.first <= gap.last),
                  "a gap has bytes, or events that are missing");
  try {
    const jobs::EventLog log(path);
    jobs::EventLog::Cursor cursor;
    std::int64_t last = 0;
    while (const auto event = log.read(cursor)) {
      fuzz::require(event->sequence() > last, "events have rising numbers");
      last = event->sequence();
      if (last > 1000) break;  // a gap may be as wide as a number permits
    }
    jobs::StepIndex().page(log, {}, 100, 100000);
  } catch (const std::runtime_error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  std::string_view text = fuzz::text_of(bytes, size);
  const bool whole = fuzz::take_choice(text) % 2 == 1;
  read(fuzz::file_with(whole ? with_checksums(text) : std::string(text)));
  return 0;
}
