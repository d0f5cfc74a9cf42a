#include "core/storage/record_log.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "core/storage/storage_error.hpp"

namespace dccast::storage {

namespace {

/// Truncates the remains of a failed write. The next write would overwrite them, but readers come
/// before that; if this fails too, they find a record with a wrong checksum.
void discard_partial_write(const File& file, std::int64_t end) {
  try {
    file.cut(end);
  } catch (const StorageError&) {
    // The error of the write, which is the cause, is already being thrown.
  }
}

}  // namespace

RecordLog::RecordLog(File file) : file_(std::move(file)), end_(file_.size()), synced_(end_) {}

std::int64_t RecordLog::end() const {
  const std::lock_guard lock(mutex_);
  return end_;
}

std::int64_t RecordLog::append(std::string_view records) {
  const std::lock_guard lock(mutex_);
  if (sync_error_ != 0)
    throw StorageError(sync_error_, file_.path().string(), "could not be synchronised");

  try {
    file_.write_at(end_, records);
  } catch (const StorageError&) {
    discard_partial_write(file_, end_);
    throw;
  }
  return std::exchange(end_, end_ + static_cast<std::int64_t>(records.size()));
}

void RecordLog::cut(std::int64_t end) {
  const std::lock_guard lock(mutex_);
  file_.cut(end);
  end_ = end;

  if (sync_error_ != 0) write_again(synced_, end);
  synced_ = 0;
  sync_error_ = 0;
}

/// After a failed write the kernel marks the pages as clean: only a new write makes the next sync
/// write them.
void RecordLog::write_again(std::int64_t begin, std::int64_t end) const {
  constexpr std::int64_t most_at_once = 1 << 20;  // [bytes]
  while (begin < end) {
    std::string bytes(static_cast<std::size_t>(std::min(end - begin, most_at_once)), '\0');
    bytes.resize(file_.read_at(begin, bytes));
    if (bytes.empty()) return;
    file_.write_at(begin, bytes);
    begin += static_cast<std::int64_t>(bytes.size());
  }
}

bool RecordLog::in_doubt() const {
  const std::lock_guard lock(mutex_);
  return sync_error_ != 0;
}

void RecordLog::sync() {
  const std::lock_guard single_sync(sync_mutex_);

  std::int64_t reached;
  {
    const std::lock_guard lock(mutex_);
    if (synced_ == end_) return;
    reached = end_;
  }

  try {
    file_.sync();
  } catch (const StorageError& error) {
    // The kernel may have dropped the pages that it could not write: a later sync that succeeds
    // proves nothing.
    const std::lock_guard lock(mutex_);
    sync_error_ = error.code().value();
    throw;
  }

  const std::lock_guard lock(mutex_);
  synced_ = reached;
}

}  // namespace dccast::storage
