// The format of the file stands in server/jobs/EVENT_LOG.md.
#include "server/jobs/event_log.hpp"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

#include "server/jobs/events.hpp"
#include "server/jobs/record_frame.hpp"

namespace dccast::jobs {

EventLog::EventLog(const std::filesystem::path& path) : file_(open_file(path, O_RDWR | O_CREAT)) {
  if (size_of_file(file_.get()) < event_log_header_size) begin(path);
  content_ = scan_event_log(file_.get());
  if (!content_.sound_header) {
    if (content_.last_sequence == 0)
      throw std::runtime_error(path.string() + " is not an event log of version 1");
    spdlog::warn("{}: the header was damaged and is written again", path.string());
    write_at(file_.get(), 0, event_log_header());
  }
  for (const EventGap& gap : content_.gaps)
    spdlog::warn("{}: {}", path.string(), gap.description());
  if (content_.size > content_.end) cut_tail(path);
  synced_ = content_.end;
}

void EventLog::begin(const std::filesystem::path& path) {
  if (::ftruncate(file_.get(), 0) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot begin " + path.string());
  write_at(file_.get(), 0, event_log_header());
}

/// What a crash leaves of the last write is worth nothing. A whole record that is damaged is kept
/// aside: it was said once.
void EventLog::cut_tail(const std::filesystem::path& path) {
  if (!content_.torn) {
    std::string tail(static_cast<std::size_t>(content_.size - content_.end), '\0');
    tail.resize(read_at(file_.get(), content_.end, tail));
    const std::string aside = path.string() + ".damaged-" + std::to_string(content_.end);
    replace_file(aside, tail);
    spdlog::warn("{}: the end is damaged after event {}: moved to {}", path.string(),
                 content_.last_sequence, aside);
  }
  spdlog::info("{}: cut off {} bytes after event {}", path.string(), content_.size - content_.end,
               content_.last_sequence);
  if (::ftruncate(file_.get(), content_.end) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot cut " + path.string());
}

EventLog::~EventLog() {
  try {
    sync();
  } catch (const std::system_error& error) {
    spdlog::error("{}", error.what());
  }
}

std::optional<std::string> EventLog::payload_at(std::int64_t offset, std::int64_t end) const {
  std::array<char, frame_head_size> head;
  if (offset + frame_head_size > end ||
      read_at(file_.get(), offset, head) != static_cast<std::size_t>(frame_head_size))
    return std::nullopt;
  const std::int64_t length = from_little_endian(head.data());
  if (offset + frame_head_size + length > end) return std::nullopt;
  std::string record(static_cast<std::size_t>(frame_head_size + length), '\0');
  record.resize(read_at(file_.get(), offset, record));
  const auto payload = payload_of(record, largest_event);
  return payload ? std::optional<std::string>(*payload) : std::nullopt;
}

void EventLog::append(v1::JobEvent& event) {
  {
    const std::lock_guard lock(mutex_);
    if (content_.terminal)
      throw std::logic_error("an event log that has ended takes no more events");
    if (sync_error_ != 0)
      throw std::system_error(sync_error_, std::generic_category(),
                              "cannot sync the event log to disk");
    event.set_sequence(content_.last_sequence + 1);
    if (!event.has_time()) *event.mutable_time() = now();
    const std::string record = framed(event.SerializeAsString());
    try {
      write_at(file_.get(), content_.end, record);
    } catch (const std::system_error&) {
      // A part that stays would be overwritten by the next append: cutting it is for readers of
      // the file, not for us.
      if (::ftruncate(file_.get(), content_.end) != 0)
        spdlog::error("cannot cut a half-written event");
      throw;
    }
    content_.take(event, content_.end, content_.end + static_cast<std::int64_t>(record.size()));
  }
  if (on_append_) on_append_();
}

void EventLog::sync() {
  const std::lock_guard one_at_a_time(sync_mutex_);
  std::int64_t reached;
  {
    const std::lock_guard lock(mutex_);
    if (synced_ == content_.end) return;
    reached = content_.end;
  }
  try {
    sync_file(file_.get());
  } catch (const std::system_error& error) {
    // What the kernel could not write it may have dropped: a later sync that succeeds proves
    // nothing.
    const std::lock_guard lock(mutex_);
    sync_error_ = error.code().value();
    throw;
  }
  const std::lock_guard lock(mutex_);
  synced_ = reached;
}

void EventLog::locate(Cursor& cursor) const {
  const EventLogContent::Anchor& anchor = content_.anchor_before(cursor.sequence);
  std::int64_t offset = anchor.offset;
  for (std::int64_t at = anchor.sequence; at < cursor.sequence; ++at) {
    std::array<char, 4> length;
    read_at(file_.get(), offset, length);
    offset += frame_head_size + from_little_endian(length.data());
  }
  cursor.offset = offset;
}

v1::JobEvent EventLog::lost_event(Cursor& cursor, const EventGap& gap) const {
  v1::JobEvent event = gap.stand_in(cursor.sequence);
  ++cursor.sequence;
  cursor.offset = 0;
  return event;
}

std::optional<v1::JobEvent> EventLog::read(Cursor& cursor) const {
  std::int64_t end;
  {
    const std::lock_guard lock(mutex_);
    if (cursor.sequence > content_.last_sequence) return std::nullopt;
    if (const EventGap* gap = content_.gap_with(cursor.sequence)) return lost_event(cursor, *gap);
    if (cursor.offset == 0) locate(cursor);
    end = content_.end;
  }
  const auto payload = payload_at(cursor.offset, end);
  v1::JobEvent event;
  if (!payload || !event.ParseFromString(*payload) || event.sequence() != cursor.sequence)
    throw std::runtime_error("the event log is damaged at event " +
                             std::to_string(cursor.sequence));
  cursor.offset += frame_head_size + static_cast<std::int64_t>(payload->size());
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

std::int64_t EventLog::reached_step() const {
  const std::lock_guard lock(mutex_);
  return content_.reached_step;
}

std::optional<v1::JobState> EventLog::last_state() const {
  const std::lock_guard lock(mutex_);
  if (!content_.last_state) return std::nullopt;
  return content_.last_state->state();
}

std::optional<v1::StepReport> EventLog::last_step() const {
  const std::lock_guard lock(mutex_);
  return content_.last_step;
}

bool EventLog::has_finding(const std::string& code) const {
  const std::lock_guard lock(mutex_);
  return std::ranges::any_of(content_.findings,
                             [&](const v1::Finding& finding) { return finding.code() == code; });
}

void EventLog::tell(v1::Job& job) const {
  const std::lock_guard lock(mutex_);
  if (content_.last_step) *job.mutable_last_step() = *content_.last_step;
  *job.mutable_findings() = {content_.findings.begin(), content_.findings.end()};
}

std::vector<EventGap> EventLog::gaps() const {
  const std::lock_guard lock(mutex_);
  return content_.gaps;
}

}  // namespace dccast::jobs
