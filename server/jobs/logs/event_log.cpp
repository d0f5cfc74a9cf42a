// server/jobs/logs/EVENT_LOG.md describes the format of the file.
#include "server/jobs/logs/event_log.hpp"

#include <fcntl.h>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <system_error>
#include <utility>

#include "core/storage/file.hpp"
#include "core/storage/record_log.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/log.hpp"

namespace dccast::jobs {

using storage::short_records;

EventLog::EventLog(const std::filesystem::path& path)
    : log_(storage::File(path, O_RDWR | O_CREAT)) {
  content_ = scan_event_log(log_.file());
  if (!content_.sound_header && content_.last_sequence == 0 &&
      content_.size >= event_log_header_size)
    throw NoEventLog(path.string() + " is not an event log");
  for (const EventGap& gap : content_.gaps) log::warn("{}: {}", path.string(), gap.description());
}

void EventLog::take_over() {
  bool read_more = false;
  {
    const std::lock_guard lock(mutex_);
    if (appends_ && (prepared_ || !log_.in_doubt())) return;

    // What remains behind the last whole record is a torn tail or damage: only a full scan can
    // distinguish the two.
    read_more = take_whole_records(log_.file(), content_);
    if (log_.file().size() > content_.end) content_ = scan_event_log(log_.file());
    repair();
    appends_ = true;
  }
  if (read_more && on_append_) on_append_();
}

bool EventLog::appends() const {
  const std::lock_guard lock(mutex_);
  return appends_;
}

void EventLog::hand_over() {
  const std::lock_guard lock(mutex_);
  if (std::exchange(prepared_, false)) log_.cut(content_.end);
  appends_ = false;
}

bool EventLog::refresh() {
  {
    const std::lock_guard lock(mutex_);
    if (appends_ || !take_whole_records(log_.file(), content_)) return false;
  }
  if (on_append_) on_append_();
  return true;
}

void EventLog::repair() {
  if (log_.file().size() < event_log_header_size) {
    log_.cut(0);
    log_.append(event_log_header());
  } else if (!content_.sound_header) {
    log::warn("{}: the header is damaged; writing it again", path().string());
    log_.file().write_at(0, event_log_header());
  }
  content_.sound_header = true;

  if (content_.size > content_.end && log_.file().size() > content_.end) cut_tail();
  log_.cut(content_.end);  // this also sets where the next append begins
}

/// Cuts off what follows the last sound record. The torn part of an unfinished write is dropped; a
/// whole but damaged record is kept in a file of its own, because readers may have seen it.
void EventLog::cut_tail() {
  if (!content_.torn) {
    std::string tail(static_cast<std::size_t>(content_.size - content_.end), '\0');
    tail.resize(log_.file().read_at(content_.end, tail));
    const std::string aside = fmt::format("{}.damaged-{}", path().string(), content_.end);
    storage::replace_file(aside, tail);
    log::warn("{}: damaged after event {}; the damaged end was moved to {}", path().string(),
              content_.last_sequence, aside);
  }

  log::info("{}: cut off {} bytes after event {}", path().string(), content_.size - content_.end,
            content_.last_sequence);
}

EventLog::~EventLog() {
  try {
    sync();
  } catch (const std::system_error& error) {
    log::error("{}", error.what());
  }
}

/// Size of the record at `offset`, with its head [bytes]; 0 if the file holds no whole head there.
std::int64_t EventLog::record_size(std::int64_t offset) const {
  std::array<char, short_records.head_size> head;
  if (log_.file().read_at(offset, head) != head.size()) return 0;
  return static_cast<std::int64_t>(head.size() +
                                   short_records.length_of({head.data(), head.size()}));
}

std::optional<std::string> EventLog::payload_at(std::int64_t offset, std::int64_t end) const {
  const std::int64_t size = record_size(offset);
  if (size == 0 || offset + size > end) return std::nullopt;

  std::string bytes(static_cast<std::size_t>(size), '\0');
  bytes.resize(log_.file().read_at(offset, bytes));
  const auto record = short_records.first_of(bytes, largest_event);
  return record ? std::optional<std::string>(record->payload) : std::nullopt;
}

void EventLog::append(v1::JobEvent& event) {
  prepare(event);
  announce();
}

void EventLog::prepare(v1::JobEvent& event) {
  if (!appends()) take_over();
  const std::lock_guard lock(mutex_);
  if (prepared_) return;
  if (content_.terminal)
    throw std::logic_error("an event log that has ended accepts no further events");

  // A record that was written, but not scanned for lack of memory, is in the file all the same.
  if (content_.end < log_.end()) take_whole_records(log_.file(), content_);

  event.set_sequence(content_.last_sequence + 1);
  if (!event.has_time()) *event.mutable_time() = now();
  log_.append(short_records.framed(event.SerializeAsString()));
  prepared_ = true;
}

void EventLog::announce() {
  {
    const std::lock_guard lock(mutex_);
    if (!std::exchange(prepared_, false)) return;
    take_whole_records(log_.file(), content_);
  }
  if (on_append_) on_append_();
}

void EventLog::locate(Cursor& cursor) const {
  const EventLogContent::Anchor& anchor = content_.anchor_before(cursor.sequence);
  cursor.offset = anchor.offset;
  for (std::int64_t skipped = anchor.sequence; skipped < cursor.sequence; ++skipped)
    cursor.offset += record_size(cursor.offset);
}

std::optional<v1::JobEvent> EventLog::read(Cursor& cursor) const {
  std::int64_t end;
  {
    const std::lock_guard lock(mutex_);
    if (cursor.sequence > content_.last_sequence) return std::nullopt;

    if (const EventGap* gap = content_.gap_with(cursor.sequence)) {
      cursor.offset = 0;
      return gap->replacement(cursor.sequence++);
    }

    if (cursor.offset == 0) locate(cursor);
    end = content_.end;
  }

  // Without the lock: records before `end` never change.
  const auto payload = payload_at(cursor.offset, end);
  v1::JobEvent event;
  if (!payload || !event.ParseFromString(*payload) || event.sequence() != cursor.sequence)
    throw std::runtime_error(fmt::format("the event log is damaged at event {}", cursor.sequence));

  cursor.offset += static_cast<std::int64_t>(short_records.head_size + payload->size());
  ++cursor.sequence;
  return event;
}

std::int64_t EventLog::last_sequence() const {
  const std::lock_guard lock(mutex_);
  return content_.last_sequence;
}

std::optional<v1::JobEvent> EventLog::terminal_event() const {
  const std::lock_guard lock(mutex_);
  return content_.terminal;
}

bool EventLog::knows(const v1::JobEvent& event) const {
  const std::lock_guard lock(mutex_);
  if (event.has_validity_lost()) return content_.validity_loss.has_value();

  return event.has_finding() &&
         std::ranges::any_of(content_.findings, [&](const v1::Finding& known) {
           return known.SerializeAsString() == event.finding().SerializeAsString();
         });
}

EventLogContent EventLog::content() const {
  const std::lock_guard lock(mutex_);
  return content_;
}

void EventLog::complete(v1::Job& job) const {
  const std::lock_guard lock(mutex_);
  content_.complete(job);
}

}  // namespace dccast::jobs
