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
/// gRPC takes no more than 4 MiB from a worker, so no event is larger; a longer one is damage.
inline constexpr std::uint32_t largest_event = 1u << 24;  // [bytes]

std::string event_log_header();

/// A stretch of an event log that cannot be read, with sound records behind it.
struct EventGap {
  std::int64_t first = 0;  ///< sequence of the first event that is lost
  std::int64_t last = 0;   ///< of the last one; less than `first` when no event is missing
  std::int64_t begin = 0;  ///< byte in the file
  std::int64_t end = 0;    ///< byte behind it
  google::protobuf::Timestamp time;  ///< of the next sound event

  /// What stands in the place of a lost event towards readers: a warning with its number.
  v1::JobEvent stand_in(std::int64_t sequence) const;
  /// For logs and reports, e.g. "events 7 to 8 are lost: bytes 520 to 700 are damaged".
  std::string description() const;
};

/// What an event log holds, without its events: what one pass over the file gives, kept up to date
/// by every append.
struct EventLogContent {
  /// A record that can be found without reading those before it.
  struct Anchor {
    std::int64_t sequence = 0;
    std::int64_t offset = 0;
  };

  bool sound_header = true;
  std::int64_t size = 0;                     ///< of the file at the scan [bytes]
  std::int64_t end = event_log_header_size;  ///< byte behind the last sound record
  bool torn = true;  ///< what lies behind `end` is the part of a record that a crash leaves
  std::int64_t last_sequence = 0;
  std::vector<EventGap> gaps;
  std::vector<Anchor> anchors;  ///< every 64th record, and the first one behind each gap
  std::optional<v1::JobEvent> terminal;
  std::optional<v1::JobEvent::StateChange> last_state;
  std::optional<v1::StepReport> last_step;                   ///< not taken back by a resumption
  google::protobuf::RepeatedPtrField<v1::Finding> findings;  ///< the last one of each code
  std::int64_t reached_step = 0;                             ///< up to which the history goes
  std::optional<v1::ValidityLoss> validity_loss;             ///< the first one
  std::optional<v1::RunEnd> run_end;                   ///< of the last attempt, once it has ended
  std::optional<google::protobuf::Timestamp> started;  ///< first start of a worker
  int attempts = 0;                                    ///< starts of a worker

  /// Takes note of the next event, whose record stands at `offset` and ends before `end_of_record`.
  void take(const v1::JobEvent& event, std::int64_t offset, std::int64_t end_of_record);
  /// Takes note of where the next record is, not of its content: of a step that others follow.
  void place(std::int64_t sequence, std::int64_t offset, std::int64_t end_of_record);
  /// The gap an event was lost in, or null.
  const EventGap* gap_with(std::int64_t sequence) const;
  /// The last anchor not behind an event that is in the log.
  const Anchor& anchor_before(std::int64_t sequence) const;
};

/// Reads an event log once from its beginning, piece by piece. A damaged record is skipped: the
/// scan goes on at the next whole record with a right checksum and a later sequence number.
/// @throws std::system_error  the file cannot be read
EventLogContent scan_event_log(const storage::File& file);

/// The same of a file that nothing is written to. @throws std::system_error
EventLogContent scan_event_log(const std::filesystem::path& path);

/// Whether a folder belongs to a job that was acknowledged: it has the mark, or its event log has
/// more than the submission. @throws std::system_error
bool was_accepted(const std::filesystem::path& folder);

/// Takes the records behind the last one. A record that is not whole is being written, or what a
/// crash left of it. @return whether there was one  @throws std::system_error
bool take_whole_records(const storage::File& file, EventLogContent& content);

}  // namespace dccast::jobs
