#include "server/access/audit.hpp"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <google/protobuf/util/json_util.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <ostream>
#include <string_view>

#include "core/storage/storage_error.hpp"
#include "proto/values/printable.hpp"

namespace dccast::access {

namespace {

constexpr std::size_t longest_text = 300;  // of each field: a line stays below one block

std::filesystem::path log_path(const std::filesystem::path& directory) {
  return directory / "audit.log";
}

std::string time_now() {
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(now.tv_sec),
                     now.tv_nsec / 1'000'000);
}

google::protobuf::util::JsonPrintOptions names_as_in_the_schema() {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  return options;
}

/// Makes every text of a caller a short, printable line.
void escape_texts(v1::AuditEvent& event) {
  const auto* reflection = event.GetReflection();
  for (int i = 0; i < event.descriptor()->field_count(); ++i) {
    const auto* field = event.descriptor()->field(i);
    const std::string text = reflection->GetString(event, field);
    reflection->SetString(&event, field, values::shortened(values::escaped(text), longest_text));
  }
}

bool passes(const v1::AuditEvent& event, const AuditFilter& filter) {
  return (filter.user.empty() || event.user() == filter.user) &&
         (filter.job.empty() || event.job().starts_with(filter.job)) &&
         (filter.call.empty() || event.call() == filter.call) && event.time() >= filter.since;
}

/// @param take  called with each line of the file, of any length
template <class Take>
void read_lines(const storage::File& file, const Take& take) {
  std::array<char, 65536> piece;
  std::string line;
  std::int64_t offset = 0;
  while (const std::size_t size = file.read_at(offset, piece)) {
    offset += static_cast<std::int64_t>(size);
    for (const char c : std::string_view(piece.data(), size)) {
      if (c != '\n') {
        line += c;
        continue;
      }
      take(line);
      line.clear();
    }
  }
  if (!line.empty()) take(line);
}

}  // namespace

AuditLog::AuditLog(const std::filesystem::path& directory) : path_(log_path(directory)) {
  open();
}

/// Opened for each event, so that the log can be renamed at any time, as logrotate does.
storage::File AuditLog::open() const {
  return {path_, O_WRONLY | O_APPEND | O_CREAT, storage::owner_only};
}

void AuditLog::append(v1::AuditEvent event) {
  event.set_time(time_now());
  escape_texts(event);

  std::string line;
  const auto written =
      google::protobuf::util::MessageToJsonString(event, &line, names_as_in_the_schema());
  if (!written.ok()) line = "{\"reason\":\"an event that is no JSON\"}";
  line += '\n';

  const storage::File file = open();
  if (::write(file.descriptor(), line.data(), line.size()) != static_cast<ssize_t>(line.size()))
    throw storage::StorageError(errno, path_.string(), "cannot be written");
}

std::size_t print_audit(const std::filesystem::path& directory, const AuditFilter& filter,
                        std::ostream& out) {
  std::size_t printed = 0;
  read_lines(storage::File(log_path(directory), O_RDONLY), [&](const std::string& line) {
    v1::AuditEvent event;

    // A line that a full disk has truncated is shown, too.
    const bool whole = google::protobuf::util::JsonStringToMessage(line, &event).ok();
    if (whole && !passes(event, filter)) return;

    out << (whole ? line : values::escaped(line)) << '\n';
    ++printed;
  });
  return printed;
}

}  // namespace dccast::access
