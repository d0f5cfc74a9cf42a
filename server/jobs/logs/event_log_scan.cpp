// server/jobs/logs/EVENT_LOG.md describes the format of the file.
#include "server/jobs/logs/event_log_scan.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <google/protobuf/io/coded_stream.h>

#include <algorithm>

#include "core/storage/file.hpp"
#include "core/storage/record_log.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/format.hpp"
#include "server/jobs/folder/job_folder.hpp"

namespace dccast::jobs {

using storage::short_records;

namespace {

constexpr std::int64_t anchor_spacing = 64;   // [records]
constexpr std::int64_t smallest_record = 10;  // head, tag and sequence number [bytes]
constexpr std::int64_t head_size = short_records.head_size;
constexpr std::int64_t event_start_size = 16;  // these hold the sequence number [bytes]

/// The first fields of a serialised JobEvent, which C++ writes in the order of their numbers.
struct EventStart {
  std::int64_t sequence = 0;
  int payload_field = 0;  ///< number of the field that the event holds; 0: not read
};

std::optional<EventStart> parse_start(std::string_view payload) {
  google::protobuf::io::CodedInputStream input(
      reinterpret_cast<const std::uint8_t*>(payload.data()), static_cast<int>(payload.size()));
  constexpr std::uint32_t sequence_tag = v1::JobEvent::kSequenceFieldNumber << 3;
  constexpr std::uint32_t time_tag = v1::JobEvent::kTimeFieldNumber << 3 | 2;

  std::uint64_t sequence = 0;
  if (input.ReadTag() != sequence_tag || !input.ReadVarint64(&sequence)) return std::nullopt;

  std::uint32_t tag = input.ReadTag();
  std::uint32_t length = 0;
  if (tag == time_tag && input.ReadVarint32(&length) && input.Skip(static_cast<int>(length)))
    tag = input.ReadTag();
  return EventStart{static_cast<std::int64_t>(sequence), static_cast<int>(tag >> 3)};
}

}  // namespace

std::string event_log_header() {
  return file_header("DCCASTEV");
}

std::string EventGap::description() const {
  std::string text;
  if (first == last) text = fmt::format("event {} is lost: ", first);
  if (first < last) text = fmt::format("events {} to {} are lost: ", first, last);

  if (begin == end)
    return fmt::format("{}they are missing at byte {} of the event log", text, begin);
  return fmt::format("{}bytes {} to {} of the event log are damaged", text, begin, end);
}

v1::JobEvent EventGap::replacement(std::int64_t sequence) const {
  v1::JobEvent event = message_event(description(), v1::JobEvent::Message::WARNING);
  event.set_sequence(sequence);
  *event.mutable_time() = time;
  return event;
}

void EventLogContent::add_position(std::int64_t sequence, std::int64_t offset,
                                   std::int64_t end_of_record) {
  const bool behind_gap = !gaps.empty() && gaps.back().end == offset;
  if (sequence % anchor_spacing == 1 || behind_gap) anchors.push_back({sequence, offset});

  last_sequence = sequence;
  end = end_of_record;
}

void EventLogContent::add(const v1::JobEvent& event, std::int64_t offset,
                          std::int64_t end_of_record) {
  add_position(event.sequence(), offset, end_of_record);

  if (event.has_state_change()) {
    last_state = event.state_change();
    state_sequence = event.sequence();
    if (last_state->terminal()) terminal = event;
    if (last_state->state() == v1::RUNNING) {
      run_end.reset();
      if (!started) started = event.time();
      attempts = std::max(attempts + 1, last_state->attempt());
    }
  }

  if (event.has_run_ended()) run_end = event.run_ended();
  if (event.has_finding()) keep_finding(findings, event.finding());
  if (event.has_validity_lost() && !validity_loss) validity_loss = event.validity_lost();
  if (event.has_step()) {
    last_step = event.step();
    reached_step = event.step().step();
  }

  // A resumed run starts at its checkpoint: the steps after it are computed again.
  if (!event.has_resumed()) return;
  reached_step = event.resumed().step();
  if (last_step && last_step->step() > reached_step) last_step.reset();
}

void EventLogContent::complete(v1::Job& job) const {
  if (last_step) *job.mutable_last_step() = *last_step;
  *job.mutable_findings() = findings;
  if (validity_loss) *job.mutable_validity_loss() = *validity_loss;
}

const EventGap* EventLogContent::gap_with(std::int64_t sequence) const {
  const auto gap = std::ranges::find_if(
      gaps, [&](const EventGap& each) { return each.first <= sequence && sequence <= each.last; });
  return gap == gaps.end() ? nullptr : &*gap;
}

const EventLogContent::Anchor& EventLogContent::anchor_before(std::int64_t sequence) const {
  const auto behind = std::ranges::upper_bound(anchors, sequence, {}, &Anchor::sequence);
  return *std::prev(behind);
}

/// A pass over those records of a file that the summary does not include yet. Most records are
/// steps, of which only the last one matters: the others are checked, but not parsed.
class EventLogScan {
public:
  EventLogScan(const storage::File& file, EventLogContent& content)
      : file_(file), content_(content) {}

  void read_all() {
    content_.size = file_.size();
    const std::string_view header = file_.at(0, event_log_header_size);
    content_.sound_header = header == event_log_header();
    while (const auto record = next_record()) add(*record);
    settle_last_step();
    content_.torn = ends_in_partial_record();
  }

  /// Reads up to the first record that is not whole.
  void read_whole() {
    while (const auto record = record_at(content_.end, expected(), expected())) add(*record);
    settle_last_step();
  }

private:
  struct Record {
    std::int64_t offset = 0;
    std::int64_t end = 0;
    std::int64_t sequence = 0;
    std::optional<v1::JobEvent> event{};  ///< nothing for a step, which is not parsed
    std::string_view payload;             ///< valid until the file is read again
  };

  /// The record at `offset` if it is sound, holds an event, and has a sequence number within these
  /// bounds.
  std::optional<Record> record_at(std::int64_t offset, std::int64_t lowest, std::int64_t highest) {
    const auto is_expected = [&](const std::optional<EventStart>& start) {
      return start && lowest <= start->sequence && start->sequence <= highest;
    };

    // The search for the next sound record tries every byte: rule out most of them by their start,
    // before a checksum is computed.
    const std::string_view head = file_.at(offset, head_size + event_start_size);
    if (head.size() <= short_records.head_size) return std::nullopt;
    if (!is_expected(parse_start(head.substr(short_records.head_size)))) return std::nullopt;

    const auto found = short_records.at(file_, offset, largest_event);
    if (!found) return std::nullopt;
    const auto start = parse_start(found->payload);  // without the bytes of the next record
    if (!is_expected(start)) return std::nullopt;

    Record record{.offset = offset,
                  .end = offset + found->size,
                  .sequence = start->sequence,
                  .payload = found->payload};
    if (start->payload_field == v1::JobEvent::kStepFieldNumber) return record;

    record.event.emplace();
    const auto size = static_cast<int>(found->payload.size());
    const bool sound = record.event->ParseFromArray(found->payload.data(), size) &&
                       record.event->sequence() == record.sequence;
    return sound ? std::optional(std::move(record)) : std::nullopt;
  }

  std::int64_t expected() const { return content_.last_sequence + 1; }

  std::optional<Record> next_record() {
    if (auto record = record_at(content_.end, expected(), expected())) return record;

    // The log is damaged here: search for the next sound record, byte by byte.
    const std::int64_t highest = expected() + file_.size() / smallest_record;
    for (std::int64_t offset = content_.end; offset < file_.size(); ++offset)
      if (auto record = record_at(offset, expected(), highest)) return record;
    return std::nullopt;
  }

  void add(const Record& record) {
    const bool gap = record.offset > content_.end || record.sequence > content_.last_sequence + 1;
    if (gap) note_gap(record);

    if (!record.event) {
      last_step_ = record.payload;
      return content_.add_position(record.sequence, record.offset, record.end);
    }

    settle_last_step();
    content_.add(*record.event, record.offset, record.end);
  }

  void note_gap(const Record& record) {
    v1::JobEvent next;
    next.ParseFromArray(record.payload.data(), static_cast<int>(record.payload.size()));
    content_.gaps.push_back({.first = content_.last_sequence + 1,
                             .last = record.sequence - 1,
                             .begin = content_.end,
                             .end = record.offset,
                             .time = next.time()});
  }

  void settle_last_step() {
    if (last_step_.empty()) return;
    v1::JobEvent event;
    if (event.ParseFromString(last_step_) && event.has_step()) {
      content_.last_step = std::move(*event.mutable_step());
      content_.reached_step = content_.last_step->step();
    }
    last_step_.clear();
  }

  bool ends_in_partial_record() {
    const std::string_view head = file_.at(content_.end, head_size);
    if (head.size() < short_records.head_size) return true;

    const auto length = static_cast<std::int64_t>(short_records.length_of(head));
    return length == 0 || content_.end + head_size + length > file_.size();
  }

  storage::FileWindow file_;
  EventLogContent& content_;
  std::string last_step_;  ///< serialised event, not parsed yet
};

EventLogContent scan_event_log(const storage::File& file) {
  EventLogContent content;
  EventLogScan(file, content).read_all();
  return content;
}

bool was_accepted(const std::filesystem::path& folder) {
  if (std::filesystem::exists(folder / accepted_file)) return true;
  const auto log = folder / "events.log";
  return storage::kind_of_entry(log) == storage::regular_file &&
         scan_event_log(log).last_sequence > 1;
}

bool take_whole_records(const storage::File& file, EventLogContent& content) {
  const std::int64_t begin = content.end;
  EventLogScan(file, content).read_whole();
  return content.end > begin;
}

EventLogContent scan_event_log(const std::filesystem::path& path) {
  return scan_event_log(storage::File(path, O_RDONLY));
}

}  // namespace dccast::jobs
