#include "server/jobs/logs/readings_log.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/format.hpp"
#include "server/jobs/log.hpp"

namespace dccast::jobs {

using storage::short_records;

namespace {

constexpr std::int64_t header_size = 16;  // [bytes]

std::string header() {
  return file_header("DCCASTRD");
}

std::filesystem::path path_in(const std::filesystem::path& job_folder) {
  return job_folder / readings_file;
}

/// Cuts off what follows the last whole reading. A crash leaves the readings of one call there,
/// which were not acknowledged; anything else is damage, so the bytes are kept in a file.
void cut_tail(storage::RecordLog& log, std::int64_t end) {
  const storage::File& file = log.file();
  std::string tail(static_cast<std::size_t>(file.size() - end), '\0');
  tail.resize(file.read_at(end, tail));
  if (tail.empty()) return;

  const std::string aside = fmt::format("{}.cut-{}", file.path().string(), end);
  storage::replace_file(aside, tail);
  log::warn("{}: {} bytes after byte {} are no readings; they were moved to {}",
            file.path().string(), tail.size(), end, aside);
  log.cut(end);
}

}  // namespace

void create_readings_log(const std::filesystem::path& job_folder, const v1::Following& following) {
  v1::RecordEntry entry;
  *entry.mutable_following() = following;
  storage::create_durably(path_in(job_folder),
                          header() + short_records.framed(entry.SerializeAsString()));
}

bool follows_readings(const std::filesystem::path& job_folder) {
  return storage::kind_of_entry(path_in(job_folder)) == storage::regular_file;
}

ReadingsReader::ReadingsReader(const std::filesystem::path& job_folder)
    : file_(path_in(job_folder), O_RDONLY), end_(header_size) {
  std::string start(header_size, '\0');
  start.resize(file_.read_at(0, start));
  if (start != header())
    throw DamagedReadings(fmt::format("{}: the header is damaged", readings_file));

  storage::FileWindow window(file_);
  auto first = next(window);
  if (!first || !first->has_following())
    throw DamagedReadings(fmt::format("{}: the first entry is damaged", readings_file));
  following_ = std::move(*first->mutable_following());
}

std::optional<v1::RecordEntry> ReadingsReader::next(storage::FileWindow& window) {
  const auto record = short_records.at(window, end_, longest_entry);
  if (!record) return std::nullopt;

  v1::RecordEntry entry;
  if (!entry.ParseFromArray(record->payload.data(), static_cast<int>(record->payload.size())))
    throw DamagedReadings(fmt::format("{} is damaged after reading {}", readings_file, number_));
  end_ += record->size;
  return entry;
}

void ReadingsReader::require_no_gap(storage::FileWindow& window) {
  if (window.size() == end_ || window.size() == size_searched_) return;
  size_searched_ = window.size();

  // The next entry begins where the damaged one ends: not farther away than the longest.
  const std::int64_t last =
      end_ + static_cast<std::int64_t>(longest_entry + short_records.head_size);
  for (std::int64_t offset = end_ + 1; offset <= std::min(last, window.size()); ++offset)
    if (short_records.at(window, offset, longest_entry))
      throw DamagedReadings(fmt::format("{} is damaged after reading {}, and readings follow",
                                        readings_file, number_));
}

std::vector<v1::Reading> ReadingsReader::read_new() {
  std::vector<v1::Reading> readings;
  storage::FileWindow window(file_);
  if (window.size() > longest_record)
    throw DamagedReadings(fmt::format("{} has {} bytes; a record has {} at most", readings_file,
                                      window.size(), longest_record));
  while (auto entry = next(window)) {
    if (entry->reading().number() != number_ + 1)
      throw DamagedReadings(fmt::format("{} is damaged after reading {}", readings_file, number_));
    ++number_;
    last_arrival_ = entry->has_arrive_time() ? std::optional(entry->arrive_time()) : std::nullopt;
    readings.push_back(std::move(*entry->mutable_reading()));
  }
  require_no_gap(window);
  return readings;
}

ReadingsLog::ReadingsLog(const std::filesystem::path& job_folder)
    : log_(storage::File(path_in(job_folder), O_RDWR)) {
  ReadingsReader reader(job_folder);
  following_ = reader.following();
  try {
    for (const v1::Reading& reading : reader.read_new()) advance(state_, reading);
  } catch (const UnfitReading& error) {
    throw DamagedReadings(fmt::format("{} is damaged: {}", readings_file, error.what()));
  }
  cut_tail(log_, reader.end());
}

v1::AppendReadingsResponse ReadingsLog::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

void ReadingsLog::advance(v1::AppendReadingsResponse& state, const v1::Reading& reading) {
  if (reading.number() != state.number() + 1)
    throw MissingReading(
        fmt::format("reading {} follows reading {}", reading.number(), state.number()));
  if (state.closed())
    throw UnfitReading(
        fmt::format("reading {} comes after the end of the record", reading.number()));

  state.set_number(reading.number());
  if (reading.closes()) return state.set_closed(true);
  if (reading.number() > most_readings)
    throw RecordFull(fmt::format("the record has {} readings", most_readings));
  if (state.has_time_s() && !(reading.time_s() >= state.time_s() + least_spacing_s))
    throw UnfitReading(fmt::format(
        "reading {} is of {:.8g} s, the one before of {:.8g} s; permitted: at least {:g} s later",
        reading.number(), reading.time_s(), state.time_s(), least_spacing_s));
  state.set_time_s(reading.time_s());
}

void ReadingsLog::append(const google::protobuf::RepeatedPtrField<v1::Reading>& readings) {
  const std::lock_guard lock(mutex_);
  v1::AppendReadingsResponse state = state_;
  std::string records;
  for (const v1::Reading& reading : readings) {
    if (reading.number() <= state_.number()) continue;
    advance(state, reading);
    v1::RecordEntry entry;
    *entry.mutable_reading() = reading;
    *entry.mutable_arrive_time() = now();
    if (const std::size_t size = entry.ByteSizeLong(); size > longest_entry)
      throw UnfitReading(fmt::format("reading {} takes {} bytes; permitted are {}",
                                     reading.number(), size, longest_entry));
    records += short_records.framed(entry.SerializeAsString());
  }
  if (records.empty()) return;

  // The entry that closes the record has room behind its end.
  const auto size = log_.file().size() + static_cast<std::int64_t>(records.size());
  if (size > longest_record - (state.closed() ? 0 : 1000))
    throw RecordFull(fmt::format("the record has {} bytes", log_.file().size()));
  if (!allowance_.take(std::chrono::steady_clock::now(),
                       static_cast<double>(state.number() - state_.number())))
    throw TooManyAtOnce(fmt::format("readings come faster than {:g} a second", readings_per_s));

  const std::int64_t before = log_.append(records);
  try {
    log_.sync();
  } catch (...) {
    log_.cut(before);  // not acknowledged: the sender repeats it
    throw;
  }
  state_ = state;
}

std::shared_ptr<ReadingsLog> ReadingsLogs::open(const std::string& job_id) {
  const std::lock_guard lock(mutex_);
  std::shared_ptr<ReadingsLog>& log = logs_[job_id];
  if (!log) {
    try {
      log = std::make_shared<ReadingsLog>(jobs_directory_ / job_id);
    } catch (...) {
      logs_.erase(job_id);
      throw;
    }
  }
  return log;
}

void ReadingsLogs::close(const std::string& job_id) {
  const std::lock_guard lock(mutex_);
  logs_.erase(job_id);
}

}  // namespace dccast::jobs
