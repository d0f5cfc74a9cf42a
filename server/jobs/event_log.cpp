// The format of the file stands in server/jobs/EVENT_LOG.md.
#include "server/jobs/event_log.hpp"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

#include "core/base/crc32c.hpp"
#include "server/jobs/events.hpp"

namespace dccast::jobs {

namespace {

constexpr std::int64_t header_size = 16;
constexpr std::int64_t record_head_size = 8;
// gRPC takes no more than 4 MiB from a worker, so no event is larger; a longer one is damage.
constexpr std::uint32_t largest_payload = 1u << 24;
constexpr std::int64_t index_spacing = 64;

std::string little_endian(std::uint32_t number) {
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(number >> shift & 0xff);
  return bytes;
}

std::uint32_t from_little_endian(const char* bytes) {
  std::uint32_t number = 0;
  for (int i = 3; i >= 0; --i) number = number << 8 | static_cast<unsigned char>(bytes[i]);
  return number;
}

std::string header() {
  return "DCCASTEV" + little_endian(1) + little_endian(0);
}

std::int64_t file_size(int descriptor) {
  struct stat status;
  if (::fstat(descriptor, &status) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot look at an event log");
  return status.st_size;
}

}  // namespace

EventLog::EventLog(const std::filesystem::path& path) : file_(open_file(path, O_RDWR | O_CREAT)) {
  if (file_size(file_.get()) < header_size) write_header();
  std::string start(header_size, '\0');
  read_at(file_.get(), 0, start);
  if (start != header())
    throw std::runtime_error(path.string() + " is not an event log of version 1");
  scan();
  const std::int64_t torn = file_size(file_.get()) - end_;
  if (torn == 0) return;
  spdlog::warn("{}: cut off a torn tail of {} bytes after event {}", path.string(), torn,
               last_sequence_);
  if (::ftruncate(file_.get(), end_) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot cut " + path.string());
}

EventLog::~EventLog() {
  try {
    sync();
  } catch (const std::system_error& error) {
    spdlog::error("{}", error.what());
  }
}

void EventLog::write_header() {
  if (::ftruncate(file_.get(), 0) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot begin an event log");
  write_at(file_.get(), 0, header());
}

void EventLog::scan() {
  const std::int64_t size = file_size(file_.get());
  end_ = header_size;
  while (const auto payload = payload_at(end_, size)) {
    v1::JobEvent event;
    if (!event.ParseFromString(*payload) || event.sequence() != last_sequence_ + 1) break;
    take(event, end_, end_ + record_head_size + static_cast<std::int64_t>(payload->size()));
  }
  synced_ = end_;
}

std::optional<std::string> EventLog::payload_at(std::int64_t offset, std::int64_t end) const {
  std::array<char, record_head_size> head;
  if (offset + record_head_size > end ||
      read_at(file_.get(), offset, head) != static_cast<std::size_t>(record_head_size))
    return std::nullopt;
  const std::uint32_t length = from_little_endian(head.data());
  if (length == 0 || length > largest_payload || offset + record_head_size + length > end)
    return std::nullopt;
  std::string payload(length, '\0');
  if (read_at(file_.get(), offset + record_head_size, payload) != length) return std::nullopt;
  if (crc32c(payload.data(), payload.size()) != from_little_endian(head.data() + 4))
    return std::nullopt;
  return payload;
}

void EventLog::take(const v1::JobEvent& event, std::int64_t offset, std::int64_t end) {
  if (last_sequence_ % index_spacing == 0) every_64th_.push_back(offset);
  ++last_sequence_;
  end_ = end;
  if (event.state_change().terminal()) terminal_ = event;
  if (event.has_step()) last_step_ = event.step();
  if (event.has_resumed() && last_step_ && last_step_->step() > event.resumed().step())
    last_step_.reset();
}

void EventLog::append(v1::JobEvent& event) {
  {
    const std::lock_guard lock(mutex_);
    if (terminal_) throw std::logic_error("an event log that has ended takes no more events");
    if (sync_error_ != 0)
      throw std::system_error(sync_error_, std::generic_category(),
                              "cannot bring the event log to the disk");
    event.set_sequence(last_sequence_ + 1);
    if (!event.has_time()) *event.mutable_time() = now();
    const std::string payload = event.SerializeAsString();
    const std::string record = little_endian(static_cast<std::uint32_t>(payload.size())) +
                               little_endian(crc32c(payload.data(), payload.size())) + payload;
    try {
      write_at(file_.get(), end_, record);
    } catch (const std::system_error&) {
      // A part that stays would be overwritten by the next append: cutting it is for readers of
      // the file, not for us.
      if (::ftruncate(file_.get(), end_) != 0) spdlog::error("cannot cut a half-written event");
      throw;
    }
    take(event, end_, end_ + static_cast<std::int64_t>(record.size()));
  }
  if (on_append_) on_append_();
}

void EventLog::sync() {
  const std::lock_guard one_at_a_time(sync_mutex_);
  std::int64_t reached;
  {
    const std::lock_guard lock(mutex_);
    if (synced_ == end_) return;
    reached = end_;
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
  const auto block = static_cast<std::size_t>((cursor.sequence - 1) / index_spacing);
  std::int64_t offset = every_64th_.at(block);
  for (auto at = static_cast<std::int64_t>(block) * index_spacing + 1; at < cursor.sequence; ++at) {
    std::array<char, 4> length;
    read_at(file_.get(), offset, length);
    offset += record_head_size + from_little_endian(length.data());
  }
  cursor.offset = offset;
}

std::optional<v1::JobEvent> EventLog::read(Cursor& cursor) const {
  std::int64_t end;
  {
    const std::lock_guard lock(mutex_);
    if (cursor.sequence > last_sequence_) return std::nullopt;
    if (cursor.offset == 0) locate(cursor);
    end = end_;
  }
  const auto payload = payload_at(cursor.offset, end);
  v1::JobEvent event;
  if (!payload || !event.ParseFromString(*payload))
    throw std::runtime_error("the event log is damaged at event " +
                             std::to_string(cursor.sequence));
  cursor.offset += record_head_size + static_cast<std::int64_t>(payload->size());
  ++cursor.sequence;
  return event;
}

std::int64_t EventLog::last_sequence() const {
  const std::lock_guard lock(mutex_);
  return last_sequence_;
}

std::optional<v1::JobEvent> EventLog::terminal_event() const {
  const std::lock_guard lock(mutex_);
  return terminal_;
}

std::optional<v1::StepReport> EventLog::last_step() const {
  const std::lock_guard lock(mutex_);
  return last_step_;
}

}  // namespace dccast::jobs
