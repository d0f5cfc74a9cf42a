// The format of the file stands in server/jobs/logs/EVENT_LOG.md.
#include "server/jobs/logs/event_log.hpp"

#include <fcntl.h>

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
    throw NoEventLog(path.string() + " is not an event log of version 1");
  for (const EventGap& gap : content_.gaps) log::warn("{}: {}", path.string(), gap.description());
}

void EventLog::take_over() {
  bool more = false;
  {
    const std::lock_guard lock(mutex_);
    if (appends_ && (prepared_ || !log_.in_doubt())) return;
    more = take_whole_records(log_.file(), content_);
    if (log_.file().size() > content_.end) content_ = scan_event_log(log_.file());
    repair();
    appends_ = true;
  }
  if (more && on_append_) on_append_();
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
    log::warn("{}: the header was damaged and is written again", path().string());
    log_.file().write_at(0, event_log_header());
  }
  content_.sound_header = true;
  if (content_.size > content_.end && log_.file().size() > content_.end) cut_tail();
  log_.cut(content_.end);  // also where it begins to append
}

/// What a crash leaves of the last write is worth nothing. A whole record that is damaged is kept
/// aside: it was reported once.
void EventLog::cut_tail() {
  if (!content_.torn) {
    std::string tail(static_cast<std::size_t>(content_.size - content_.end), '\0');
    tail.resize(log_.file().read_at(content_.end, tail));
    const std::string aside = path().string() + ".damaged-" + std::to_string(content_.end);
    storage::replace_file(aside, tail);
    log::warn("{}: the end is damaged after event {}: moved to {}", path().string(),
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

/// Of the record at `offset`, with its head [bytes]; 0 where there is no whole head.
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
  if (content_.terminal) throw std::logic_error("an event log that has ended takes no more events");
  // A record that could not be taken for want of memory stands in the file all the same.
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
  for (std::int64_t at = anchor.sequence; at < cursor.sequence; ++at)
    cursor.offset += record_size(cursor.offset);
}

std::optional<v1::JobEvent> EventLog::read(Cursor& cursor) const {
  std::int64_t end;
  {
    const std::lock_guard lock(mutex_);
    if (cursor.sequence > content_.last_sequence) return std::nullopt;
    if (const EventGap* gap = content_.gap_with(cursor.sequence)) {
      cursor.offset = 0;
      return gap->stand_in(cursor.sequence++);
    }
    if (cursor.offset == 0) locate(cursor);
    end = content_.end;
  }
  const auto payload = payload_at(cursor.offset, end);
  v1::JobEvent event;
  if (!payload || !event.ParseFromString(*payload) || event.sequence() != cursor.sequence)
    throw std::runtime_error("the event log is damaged at event " +
                             std::to_string(cursor.sequence));
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
  if (content_.last_step) *job.mutable_last_step() = *content_.last_step;
  *job.mutable_findings() = content_.findings;
  if (content_.validity_loss) *job.mutable_validity_loss() = *content_.validity_loss;
}

}  // namespace dccast::jobs
