// What a daemon reads of its data directory: descriptions of jobs, orders to workers, studies,
// users. The first byte chooses; it reads records whose checksums are right, too.
#include "core/storage/file.hpp"
#include "core/storage/record_log.hpp"
#include "server/access/users.hpp"
#include "server/jobs/executors/worker_claim.hpp"
#include "server/jobs/folder/format.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/studies/study_file.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dccast;

namespace {

using fuzz::folder;

constexpr const char* study = "00000000-0000-4000-8000-000000000000";

/// Frames of the texts between bytes 255, behind what a file begins with.
std::string framed(std::string_view kind, std::string_view text) {
  std::string file = jobs::file_header(kind);
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\xff'), text.size());
    file += storage::short_records.framed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return file;
}

void read(unsigned choice, std::string_view text) {
  const bool whole = choice & 4;
  switch (choice & 3) {
    case 0:
      storage::write_file(folder() / jobs::description_file,
                          whole ? framed(jobs::description_kind, text) : std::string(text));
      jobs::read_job_description(folder());
      break;
    case 1:
      storage::write_file(folder() / jobs::order_file, text);
      jobs::read_order(folder());
      storage::write_file(folder() / jobs::rank_file, text);
      jobs::has_begun(folder(), 1);
      break;
    case 2:
      storage::write_file(studies::study_file(folder(), study),
                          whole ? framed(studies::study_file_kind, text) : std::string(text));
      studies::read_study_file(folder(), study);
      studies::read_study_runs(folder(), study);
      break;
    default:
      storage::write_file(folder() / "users.toml", text);
      access::UserStore(folder()).prove("id.secret", 0);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  std::string_view text = fuzz::text_of(bytes, size);
  const unsigned choice = fuzz::take_choice(text);
  try {
    read(choice, text);
  } catch (const std::runtime_error&) {
  }
  return 0;
}
