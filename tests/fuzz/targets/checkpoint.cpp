// A checkpoint, and the journal of a run. The first byte chooses; with right checksums or as it is.
#include "core/casting/findings/judge.hpp"
#include "core/results/checkpoint_file.hpp"
#include "core/results/journal.hpp"
#include "core/storage/record_log.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dccast;

namespace {

void convert(const results::Sections& content) {
  try {
    results::read_header(content);
  } catch (const std::out_of_range&) {
  }
  try {
    results::read_frame(content);
  } catch (const std::out_of_range&) {
  }
  try {
    casting::read_findings(content);
  } catch (const std::out_of_range&) {
  }
}

void read_sections(std::string_view text) {
  const auto content = results::decode(text);
  if (!content) return;
  const std::string again = results::encode(*content);
  fuzz::require(again.size() <= text.size(), "content has no more bytes than its file");
  fuzz::require(results::decode(again).has_value(), "what is written can be read");
  convert(*content);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  std::string_view text = fuzz::text_of(bytes, size);
  const auto visit = [](const results::Record& record) {
    convert(record.content);
    return true;
  };
  switch (fuzz::take_choice(text) % 4) {
    case 0:
      read_sections(text);
      break;
    case 1:
      results::read_checkpoint(fuzz::file_with(text)).content.has_value();
      break;
    case 2:
      results::visit_journal(fuzz::file_with(text), visit);
      break;
    default:
      results::visit_journal(fuzz::file_with("DCJRNL1\n" + storage::long_records.framed(text, 3)),
                             visit);
  }
  return 0;
}
