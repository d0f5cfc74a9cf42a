#include "server/studies/lines.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "core/storage/file.hpp"
#include "core/storage/record_log.hpp"
#include "core/storage/storage_error.hpp"
#include "proto/case_file/fingerprint.hpp"
#include "proto/refusal/refusal.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/format.hpp"

namespace dccast::studies {

/// A line as its file tells.
class StoredLine {
public:
  /// A call that has added castings.
  struct Request {
    std::string request;
    std::vector<std::string> castings;
  };

  static std::string header() { return jobs::file_header(line_file_kind); }

  /// @param bytes  of the file @throws DamagedLine  without a name of the file
  explicit StoredLine(std::string_view bytes) {
    if (!bytes.starts_with(header())) throw DamagedLine("");
    end_ = static_cast<std::int64_t>(header().size());
    while (const auto record = storage::short_records.first_of(
               bytes.substr(static_cast<std::size_t>(end_)), largest_change)) {
      LineChange change;
      if (!change.ParseFromString(std::string(record->payload))) break;
      apply(change);
      end_ += record->size;
    }
    if (line_.name().empty() || !is_torn(bytes.substr(static_cast<std::size_t>(end_))))
      throw DamagedLine("");
  }

  std::int64_t end() const { return end_; }  ///< byte behind the last change
  std::int64_t last_number() const { return last_number_; }
  const v1::Line& beginning() const { return line_; }  ///< the line without its castings
  /// Null if there is none, or it is forgotten.
  const v1::LineCasting* find(const std::string& id) const {
    const auto found = castings_.find(id);
    return found != castings_.end() && found->second ? &*found->second : nullptr;
  }
  /// Whether there was a record since the line was begun afresh.
  bool had(const std::string& id) const { return castings_.contains(id); }
  const Request* find_request(const std::string& id) const {
    const auto found = requests_.find(id);
    return found == requests_.end() ? nullptr : &found->second;
  }

  /// With its castings, the newest that it keeps.
  v1::Line line() const {
    v1::Line line = line_;
    std::size_t bytes = 0;
    auto oldest = order_.rbegin();
    for (; oldest != order_.rend() && line.castings_size() < most_castings; ++oldest) {
      const v1::LineCasting* const casting = find(*oldest);
      if (!casting) continue;
      bytes += casting->ByteSizeLong();
      if (bytes > most_casting_bytes && !line.castings().empty()) break;
      *line.add_castings() = *casting;
    }
    std::reverse(line.mutable_castings()->pointer_begin(), line.mutable_castings()->pointer_end());
    for (const v1::LineCasting& casting : line.castings())
      line.set_number(line.number() + std::max<std::int64_t>(1, casting.count()));
    return line;
  }

  /// The whole line as one change, for a file that is written anew.
  LineChange as_change() const {
    LineChange whole;
    v1::Line line = this->line();
    *whole.mutable_castings() = line.castings();
    *whole.mutable_beginning() = line_;
    whole.set_last_number(last_number_);
    return whole;
  }

private:
  static constexpr std::uint64_t largest_change = 1 << 26;  // [bytes]

  void apply(const LineChange& change) {
    if (change.has_beginning()) line_ = change.beginning();
    if (change.has_restart_time()) {
      castings_.clear();
      order_.clear();
      *line_.mutable_restart_time() = change.restart_time();
    }
    for (const v1::LineCasting& casting : change.castings())
      if (castings_.insert_or_assign(casting.id(), casting).second) order_.push_back(casting.id());
    for (const std::string& id : change.forgotten()) castings_[id].reset();

    last_number_ = std::max(last_number_, change.last_number());
    if (change.request_id().empty()) return;
    Request& request = requests_[change.request_id()];
    request.request = change.request();
    for (const v1::LineCasting& casting : change.castings())
      request.castings.push_back(casting.id());
  }

  /// Whether bytes that are no frame are those of an append that was cut short: the frame is longer
  /// than they are, or nothing but zeros had reached the disk.
  static bool is_torn(std::string_view rest) {
    const auto head = storage::short_records.head_size;
    return rest.size() < head || rest.find_first_not_of('\0') == std::string_view::npos ||
           storage::short_records.length_of(rest) > rest.size() - head;
  }

  v1::Line line_;  ///< without castings
  std::int64_t end_ = 0, last_number_ = 0;
  std::map<std::string, std::optional<v1::LineCasting>> castings_;  ///< by id; empty: forgotten
  std::vector<std::string> order_;  ///< ids, the oldest first, with those that are forgotten
  std::map<std::string, Request> requests_;
};

namespace {

constexpr std::int64_t largest_file = 1 << 25;  // [bytes] a longer one is written anew

std::string framed(const LineChange& change) {
  return storage::short_records.framed(change.SerializeAsString());
}

std::filesystem::path file_of(const std::filesystem::path& directory, const std::string& name) {
  return directory / (name + ".bin");
}

LineChange with_casting(const v1::LineCasting& casting) {
  LineChange change;
  *change.add_castings() = casting;
  return change;
}

/// Empty if there is no such line. @throws DamagedLine, std::system_error
std::optional<StoredLine> read_line(const std::filesystem::path& directory,
                                    const std::string& name) {
  const auto path = file_of(directory, name);
  if (!is_line_name(name) || storage::kind_of_entry(path).empty()) return std::nullopt;
  try {
    StoredLine stored(storage::read_file(path));
    if (stored.beginning().name() == name) return stored;
  } catch (const DamagedLine&) {
    // Named below.
  }
  throw DamagedLine(fmt::format("the file of line {}, {}, is damaged", name, path.string()));
}

/// Cuts off what follows the last record, and keeps it beside the file: a length that was damaged
/// looks like an append that was cut short.
void cut_tail(storage::RecordLog& log, std::int64_t end) {
  const storage::File& file = log.file();
  std::string tail(static_cast<std::size_t>(log.end() - end), '\0');
  tail.resize(file.read_at(end, tail));
  storage::replace_file(fmt::format("{}.cut-{}", file.path().string(), end), tail);
  log.cut(end);
}

}  // namespace

bool is_line_name(const std::string& text) {
  constexpr std::size_t longest = 64;
  const auto is_alphanumeric = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
  };
  return !text.empty() && text.size() <= longest && is_alphanumeric(text.front()) &&
         std::ranges::all_of(
             text, [&](char c) { return is_alphanumeric(c) || c == '-' || c == '_' || c == '.'; });
}

std::string recipe_name(const v1::Case& complete) {
  constexpr std::size_t length = 16;  // enough to tell recipes of one line apart
  return case_file::fingerprint(complete, case_file::Same::recipe).substr(0, length);
}

void set_recipe(const v1::Case& complete, v1::LineCasting& casting) {
  casting.set_title(complete.title());
  casting.set_recipe(recipe_name(complete));
  casting.set_recipe_end_s(complete.time().end_s());
}

void set_typed(const v1::LineCasting& typed, const std::string& user, v1::LineCasting& casting) {
  casting.set_outcome(typed.outcome());
  casting.set_count(typed.count());
  casting.clear_at_m();
  if (typed.has_at_m()) casting.set_at_m(typed.at_m());
  *casting.mutable_cold_curl_m() = typed.cold_curl_m();
  casting.clear_sawn_off_m();
  if (typed.has_sawn_off_m()) casting.set_sawn_off_m(typed.sawn_off_m());
  if (typed.has_begin_time() && !casting.has_following())
    *casting.mutable_begin_time() = typed.begin_time();
  casting.set_typed_by(user);
}

v1::LineCasting make_line_casting(const v1::Job& job, const v1::Following& following,
                                  const v1::Case& complete) {
  v1::LineCasting casting;
  set_recipe(complete, casting);
  casting.set_id(job.id());
  casting.set_job(job.id());
  casting.set_title(job.title());
  casting.set_count(1);
  *casting.mutable_begin_time() = job.create_time();
  *casting.mutable_following() = following;
  return casting;
}

v1::ListLinesResponse list_lines(const std::filesystem::path& directory) {
  v1::ListLinesResponse listing;
  if (!std::filesystem::is_directory(directory)) return listing;

  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    const std::string name = entry.path().stem().string();
    if (entry.path().extension() != ".bin" || !is_line_name(name)) continue;
    try {
      const auto stored = read_line(directory, name);
      if (!stored) continue;
      v1::Line line = stored->line();
      line.clear_castings();
      *listing.add_lines() = std::move(line);
    } catch (const DamagedLine&) {
      listing.add_damaged(name);
    } catch (const std::system_error& error) {  // no regular file, or one that cannot be read
      if (storage::is_resource_fault(error.code())) throw;
      listing.add_damaged(name);
    }
  }
  std::ranges::sort(*listing.mutable_lines(), {}, &v1::Line::name);
  std::ranges::sort(*listing.mutable_damaged());
  return listing;
}

void Lines::append(const std::optional<StoredLine>& stored, const std::string& name,
                   const std::string& owner, LineChange change) {
  const auto path = file_of(directory_, name);
  if (!stored) {
    change.mutable_beginning()->set_name(name);
    change.mutable_beginning()->set_owner(owner);
    *change.mutable_beginning()->mutable_create_time() = jobs::now();
    std::filesystem::create_directories(directory_);
    storage::replace_file(path, StoredLine::header() + framed(change));
    owners_[name] = owner;
    return;
  }

  if (stored->end() > largest_file)
    storage::replace_file(path, StoredLine::header() + framed(stored->as_change()));
  storage::RecordLog log(storage::File(path, O_RDWR));
  if (stored->end() <= largest_file && log.end() > stored->end()) cut_tail(log, stored->end());
  const std::int64_t before = log.append(framed(change));
  try {
    log.sync();
  } catch (...) {
    log.cut(before);  // not acknowledged: the caller repeats it
    throw;
  }
}

Lines::Lines(std::filesystem::path directory) : directory_(std::move(directory)) {
  const v1::ListLinesResponse there = list_lines(directory_);
  for (const v1::Line& line : there.lines()) owners_[line.name()] = line.owner();
  for (const std::string& damaged : there.damaged()) owners_[damaged] = "";
}

v1::ListLinesResponse Lines::list() const {
  const std::lock_guard lock(mutex_);
  return list_lines(directory_);
}

std::optional<v1::Line> Lines::find(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto stored = read_line(directory_, name);
  return stored ? std::optional(stored->line()) : std::nullopt;
}

std::optional<std::string> Lines::owner(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  if (const auto there = owners_.find(name); there != owners_.end()) return there->second;
  if (const auto kept = reserved_.find(name); kept != reserved_.end()) return kept->second.owner;
  return std::nullopt;
}

Lines::Reservation Lines::reserve(const std::string& name, const std::string& owner) {
  const std::lock_guard lock(mutex_);
  if (owners_.contains(name))
    read_line(directory_, name);  // a damaged one is refused before a job is made
  const bool is_new = !owners_.contains(name) && !reserved_.contains(name);
  const auto is_own = [&](const auto& line) { return line.second == owner; };
  const auto is_kept = [&](const auto& kept) { return kept.second.owner == owner; };
  if (is_new &&
      std::ranges::count_if(owners_, is_own) + std::ranges::count_if(reserved_, is_kept) >=
          most_lines_of_user)
    throw refusal::LimitReached({.cause = fmt::format("{} has {} lines", owner, most_lines_of_user),
                                 .limit = "lines of one user",
                                 .permitted = std::to_string(most_lines_of_user),
                                 .remedy = "forget one that is not cast on any more (dccast line "
                                           "forget NAME --all), or cast on one of them"});

  Reserved& reserved = reserved_[name];
  if (reserved.castings++ == 0) reserved.owner = owner;
  return Reservation(*this, name);
}

void Lines::release(const std::string& name) {
  const std::lock_guard lock(mutex_);
  const auto reserved = reserved_.find(name);
  if (--reserved->second.castings == 0) reserved_.erase(reserved);
}

void Lines::add(const std::string& name, const v1::LineCasting& casting) {
  const std::lock_guard lock(mutex_);
  const auto stored = read_line(directory_, name);
  if (!stored || !stored->had(casting.id()))
    append(stored, name, reserved_.at(name).owner, with_casting(casting));
}

AddedCastings Lines::add_typed(const std::string& name, std::vector<v1::LineCasting> castings,
                               const std::string& request_id, const std::string& request) {
  const std::lock_guard lock(mutex_);
  const auto stored = read_line(directory_, name);
  const auto* const before =
      stored && !request_id.empty() ? stored->find_request(request_id) : nullptr;
  if (before)
    return {.ids = before->castings, .repeated = true, .other_request = before->request != request};

  LineChange change;
  change.set_request_id(request_id);
  change.set_request(request);
  std::int64_t number = stored ? stored->last_number() : 0;
  AddedCastings added;
  for (v1::LineCasting& casting : castings) {
    casting.set_id(std::to_string(++number));
    added.ids.push_back(casting.id());
    *change.add_castings() = std::move(casting);
  }
  change.set_last_number(number);
  append(stored, name, reserved_.at(name).owner, std::move(change));
  return added;
}

void Lines::add_lost(const std::string& name, const std::string& owner,
                     const v1::LineCasting& casting) {
  const std::lock_guard lock(mutex_);
  const auto stored = read_line(directory_, name);
  if (stored && stored->had(casting.id())) return;
  if (stored && stored->beginning().has_restart_time() &&
      jobs::milliseconds(stored->beginning().restart_time()) >=
          jobs::milliseconds(casting.begin_time()))
    return;
  append(stored, name, owner, with_casting(casting));
}

void Lines::end_casting(const std::string& name, const std::string& job,
                        const std::vector<v1::ObservedCurl>& curls) {
  const std::lock_guard lock(mutex_);
  const auto stored = read_line(directory_, name);
  const v1::LineCasting* const casting = stored ? stored->find(job) : nullptr;
  if (!casting || casting->ended()) return;

  v1::LineCasting ended = *casting;
  ended.set_ended(true);
  *ended.mutable_curls() = {curls.begin(), curls.end()};
  append(stored, name, "", with_casting(ended));
}

std::optional<v1::LineCasting> Lines::edit(const std::string& name, const std::string& id,
                                           const v1::LineCasting& typed, const std::string& user) {
  const std::lock_guard lock(mutex_);
  const auto stored = read_line(directory_, name);
  const v1::LineCasting* const casting = stored ? stored->find(id) : nullptr;
  if (!casting) return std::nullopt;

  v1::LineCasting edited = *casting;
  set_typed(typed, user, edited);
  append(stored, name, "", with_casting(edited));
  return edited;
}

std::optional<std::string> Lines::forget(const std::string& name,
                                         const std::vector<std::string>& ids) {
  const std::lock_guard lock(mutex_);
  const auto stored = read_line(directory_, name);
  LineChange change;
  for (const std::string& id : ids) {
    if (!stored || !stored->find(id)) return id;
    change.add_forgotten(id);
  }
  append(stored, name, "", std::move(change));
  return std::nullopt;
}

std::optional<v1::Line> Lines::restart(const std::string& name) {
  const std::lock_guard lock(mutex_);
  const auto stored = read_line(directory_, name);
  if (!stored) return std::nullopt;
  LineChange change;
  *change.mutable_restart_time() = jobs::now();
  append(stored, name, "", std::move(change));
  return read_line(directory_, name)->line();
}

bool Lines::remove(const std::string& name) {
  const std::lock_guard lock(mutex_);
  const auto path = file_of(directory_, name);
  if (!is_line_name(name) || storage::kind_of_entry(path).empty()) return false;
  std::filesystem::remove(path);
  owners_.erase(name);
  storage::sync_directory(directory_);
  return true;
}

}  // namespace dccast::studies
