#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/storage/file.hpp"
#include "dccast/v1/job.pb.h"

namespace dccast::jobs {

inline constexpr std::int64_t event_log_header_size = 16;  // [bytes]
/// Every event fits into a gRPC message of 4 MiB; a longer record is damage.
inline constexpr std::uint32_t largest_event = 1u << 24;  // [bytes]

/// Bytes at the beginning of every log.
std::string event_log_header();

/// An unreadable part of an event log, followed by sound records.
struct EventGap {
  std::int64_t first = 0;            ///< sequence number of the first lost event
  std::int64_t last = 0;             ///< of the last one; less than `first` if no event is missing
  std::int64_t begin = 0;            ///< first byte in the file
  std::int64_t end = 0;              ///< byte after the last one
  google::protobuf::Timestamp time;  ///< of the next sound event

  /// The event that readers receive in place of a lost one: a warning with its sequence number.
  v1::JobEvent replacement(std::int64_t sequence) const;
  /// For logs and reports, e.g. "events 7 to 8 are lost: bytes 520 to 700 are damaged".
  std::string description() const;
};

/// Summary of an event log, without its events: built by one pass over the file, updated by every
/// append.
struct EventLogContent {
  /// A record whose position is known, so that readers need not start at the beginning.
  struct Anchor {
    /// Number of the last sound event, and the offset behind it.
    std::int64_t sequence = 0;
    std::int64_t offset = 0;
  };

  bool sound_header = true;
  std::int64_t size = 0;                     ///< of the file at the scan [bytes]
  std::int64_t end = event_log_header_size;  ///< byte after the last sound record
  bool torn = true;  ///< what follows `end` is an unfinished record, as a crash leaves it
  std::int64_t last_sequence = 0;
  std::vector<EventGap> gaps;
  std::vector<Anchor> anchors;  ///< every 64th record, and the first one after each gap
  std::optional<v1::JobEvent> terminal;
  std::optional<v1::JobEvent::StateChange> last_state;
  std::int64_t state_sequence = 0;                           ///< of last_state
  std::optional<v1::StepReport> last_step;                   ///< not taken back by a resumption
  google::protobuf::RepeatedPtrField<v1::Finding> findings;  ///< the last one of each code
  std::int64_t reached_step = 0;                             ///< last step of the history
  std::optional<v1::Finding> validity_loss;                  ///< the first one
  std::optional<v1::RunEnd> run_end;                   ///< of the last attempt, once it has ended
  std::optional<google::protobuf::Timestamp> started;  ///< first start of a worker
  int attempts = 0;                                    ///< number of starts of a worker

  /// Adds the next event, whose record begins at `offset` and ends before `end_of_record`.
  void add(const v1::JobEvent& event, std::int64_t offset, std::int64_t end_of_record);
  /// Adds only the position of the next record: a step that is followed by others is not parsed.
  void add_position(std::int64_t sequence, std::int64_t offset, std::int64_t end_of_record);
  /// Fills in what the log knows of a job beside its state: last step, findings, loss of validity.
  void complete(v1::Job& job) const;
  /// The gap in which an event was lost, or null.
  const EventGap* gap_with(std::int64_t sequence) const;
  /// The last anchor not after an event that is in the log.
  const Anchor& anchor_before(std::int64_t sequence) const;
};

/// Reads an event log once from its beginning, piece by piece. A damaged record is skipped: the
/// scan continues at the next whole record with a correct checksum and a later sequence number.
/// @throws std::system_error  the file cannot be read
EventLogContent scan_event_log(const storage::File& file);

/// The same for a file that no process writes. @throws std::system_error
EventLogContent scan_event_log(const std::filesystem::path& path);

/// Whether a folder belongs to a job that was acknowledged: it has the mark, or its event log holds
/// more than the submission. @throws std::system_error
bool was_accepted(const std::filesystem::path& folder);

/// Reads the records after the last one, up to the first that is not whole: such a record is being
/// written, or was left by a crash. @return whether any was read  @throws std::system_error
bool take_whole_records(const storage::File& file, EventLogContent& content);

}  // namespace dccast::jobs
