#include "core/results/journal.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "core/base/crc32c.hpp"
#include "core/results/storage_error.hpp"

namespace dccast::results {

namespace {

constexpr std::string_view magic = "DCJRNL1\n";
/// Checksum, length and kind in front of the sections of a record.
constexpr std::size_t preamble_size = 4 + 8 + 1;

std::uint32_t checksum_of(const char* length_and_kind, const std::string& body) {
  return crc32c(body.data(), body.size(), crc32c(length_and_kind, preamble_size - 4));
}

/// The next record of the stream; false at the end and at a damaged record.
bool read_record(std::istream& stream, std::uint64_t bytes_left, Record& record) {
  char preamble[preamble_size];
  if (!stream.read(preamble, preamble_size)) return false;
  std::uint32_t checksum = 0;
  std::uint64_t length = 0;
  std::memcpy(&checksum, preamble, 4);
  std::memcpy(&length, preamble + 4, 8);
  if (length > bytes_left - preamble_size) return false;  // before memory is taken for it
  std::string body(length, '\0');
  if (!stream.read(body.data(), static_cast<std::streamsize>(length))) return false;
  if (checksum_of(preamble + 4, body) != checksum) return false;
  auto content = decode(body);
  if (!content) return false;
  record.kind = static_cast<RecordKind>(preamble[12]);
  record.content = std::move(*content);
  record.end += preamble_size + length;
  return true;
}

}  // namespace

Journal Journal::create(const std::filesystem::path& path) {
  Journal journal(FileDescriptor(path, O_WRONLY | O_CREAT | O_TRUNC));
  journal.pending_ = magic;
  return journal;
}

Journal Journal::reopen(const std::filesystem::path& path, std::uint64_t size) {
  FileDescriptor file(path, O_WRONLY | O_APPEND);
  if (::ftruncate(file.get(), static_cast<off_t>(size)) != 0)
    throw StorageError(errno, path.string(), "cannot be cut");
  return Journal(std::move(file));
}

void Journal::append(RecordKind kind, const Sections& content) {
  const std::string body = encode(content);
  const std::uint64_t length = body.size();
  char length_and_kind[preamble_size - 4];
  std::memcpy(length_and_kind, &length, 8);
  length_and_kind[8] = static_cast<char>(kind);
  const std::uint32_t checksum = checksum_of(length_and_kind, body);
  pending_.append(reinterpret_cast<const char*>(&checksum), 4);
  pending_.append(length_and_kind, sizeof length_and_kind);
  pending_ += body;
}

void Journal::write() {
  if (pending_.empty()) return;
  file_.write(pending_);
  pending_.clear();
}

bool visit_journal(const std::filesystem::path& path,
                   const std::function<bool(const Record&)>& visit, std::uint64_t after) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw StorageError(errno, path.string(), "cannot be opened");
  const std::uint64_t size = std::filesystem::file_size(path);
  std::string start(magic.size(), '\0');
  if (!stream.read(start.data(), static_cast<std::streamsize>(start.size())) || start != magic)
    return false;
  Record record;
  record.end = std::max<std::uint64_t>(after, magic.size());
  stream.seekg(static_cast<std::streamoff>(record.end));
  while (size - record.end >= preamble_size && read_record(stream, size - record.end, record))
    if (!visit(record)) break;
  return true;
}

}  // namespace dccast::results
