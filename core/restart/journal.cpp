#include "core/restart/journal.hpp"

#include <fcntl.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "core/storage/record_format.hpp"

namespace dccast::restart {

namespace {

constexpr std::string_view magic = "DCJRNL1\n";

/// The record at `offset`; nothing at the end and where a record is damaged.
std::optional<Record> record_at(storage::FileWindow& file, std::int64_t offset) {
  const auto found = storage::long_records.at(file, offset);
  if (!found) return std::nullopt;
  auto content = decode(found->payload);
  if (!content) return std::nullopt;
  return Record{static_cast<RecordKind>(found->kind), std::move(*content), offset + found->size};
}

}  // namespace

Journal::Journal(storage::File file)
    : log_(std::make_unique<storage::RecordLog>(std::move(file))) {}

Journal Journal::create(const std::filesystem::path& path) {
  Journal journal(storage::File(path, O_WRONLY | O_CREAT | O_TRUNC, storage::readable_by_all));
  journal.pending_ = magic;
  return journal;
}

Journal Journal::reopen(const std::filesystem::path& path, std::int64_t size) {
  Journal journal(storage::File(path, O_WRONLY));
  journal.log_->cut(size);
  return journal;
}

void Journal::append(RecordKind kind, const Sections& content) {
  pending_ += storage::long_records.framed(encode(content), static_cast<std::uint8_t>(kind));
}

void Journal::write() {
  if (pending_.empty()) return;
  log_->append(pending_);
  pending_.clear();
}

bool visit_journal(const std::filesystem::path& path,
                   const std::function<bool(const Record&)>& visit, std::int64_t after) {
  const storage::File file(path, O_RDONLY);
  storage::FileWindow window(file);
  if (window.at(0, magic.size()) != magic) return false;
  std::int64_t end = std::max<std::int64_t>(after, magic.size());
  while (const auto record = record_at(window, end)) {
    if (!visit(*record)) break;
    end = record->end;
  }
  return true;
}

}  // namespace dccast::restart
