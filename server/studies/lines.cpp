#include "server/studies/lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "core/storage/file.hpp"
#include "core/storage/record_log.hpp"
#include "core/storage/storage_error.hpp"
#include "proto/refusal/refusal.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/format.hpp"

namespace dccast::studies {

namespace {

constexpr std::uint32_t largest_line = 1 << 24;  // [bytes]

std::string header() {
  return jobs::file_header(line_file_kind);
}

std::filesystem::path file_of(const std::filesystem::path& directory, const std::string& name) {
  return directory / (name + ".bin");
}

/// What forecasts use of a line is its newest castings: the oldest go.
void drop_oldest(v1::Line& line) {
  auto& castings = *line.mutable_castings();
  while (castings.size() > 1 &&
         (castings.size() > most_castings || line.ByteSizeLong() > most_casting_bytes))
    castings.DeleteSubrange(0, 1);
}

v1::LineCasting* find_casting(v1::Line& line, const std::string& job) {
  const auto found = std::ranges::find(*line.mutable_castings(), job, &v1::LineCasting::job);
  return found == line.mutable_castings()->end() ? nullptr : &*found;
}

/// Empty if there is no such line. @throws DamagedLine, std::system_error
std::optional<v1::Line> read_line(const std::filesystem::path& directory, const std::string& name) {
  const auto path = file_of(directory, name);
  if (!is_line_name(name) || storage::kind_of_entry(path).empty()) return std::nullopt;

  const std::string bytes = storage::read_file(path);
  const std::string_view all = bytes;
  v1::Line line;
  if (all.starts_with(header()))
    if (const auto record =
            storage::short_records.first_of(all.substr(header().size()), largest_line);
        record && line.ParseFromString(std::string(record->payload)) && line.name() == name)
      return line;
  throw DamagedLine(fmt::format("the file of line {}, {}, is damaged", name, path.string()));
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

v1::LineCasting make_line_casting(const v1::Job& job, const v1::Following& following) {
  v1::LineCasting casting;
  casting.set_job(job.id());
  casting.set_title(job.title());
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
      auto line = read_line(directory, name);
      if (!line) continue;
      for (v1::LineCasting& casting : *line->mutable_castings()) {
        casting.clear_following();
        casting.clear_curls();
      }
      *listing.add_lines() = std::move(*line);
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

void Lines::write(v1::Line line) {
  drop_oldest(line);
  std::filesystem::create_directories(directory_);
  storage::replace_file(file_of(directory_, line.name()),
                        header() + storage::short_records.framed(line.SerializeAsString()));
  owners_[line.name()] = line.owner();
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
  return read_line(directory_, name);
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
                                           "forget), or cast on one of them"});

  Reserved& reserved = reserved_[name];
  if (reserved.castings++ == 0) reserved.owner = owner;
  return Reservation(*this, name);
}

void Lines::release(const std::string& name) {
  const std::lock_guard lock(mutex_);
  const auto reserved = reserved_.find(name);
  if (--reserved->second.castings == 0) reserved_.erase(reserved);
}

void Lines::write_with(std::optional<v1::Line> line, const std::string& name,
                       const std::string& owner, const v1::LineCasting& casting) {
  if (!line) {
    line.emplace();
    line->set_name(name);
    line->set_owner(owner);
    *line->mutable_create_time() = jobs::now();
  }
  if (find_casting(*line, casting.job())) return;
  *line->add_castings() = casting;
  write(std::move(*line));
}

void Lines::add(const std::string& name, const v1::LineCasting& casting) {
  const std::lock_guard lock(mutex_);
  write_with(read_line(directory_, name), name, reserved_.at(name).owner, casting);
}

void Lines::add_lost(const std::string& name, const std::string& owner,
                     const v1::LineCasting& casting) {
  const std::lock_guard lock(mutex_);
  auto line = read_line(directory_, name);
  if (line && line->has_restart_time() &&
      jobs::milliseconds(line->restart_time()) >= jobs::milliseconds(casting.begin_time()))
    return;
  write_with(std::move(line), name, owner, casting);
}

void Lines::end_casting(const std::string& name, const std::string& job,
                        const std::vector<v1::ObservedCurl>& curls) {
  const std::lock_guard lock(mutex_);
  auto line = read_line(directory_, name);
  v1::LineCasting* const casting = line ? find_casting(*line, job) : nullptr;
  if (!casting || casting->ended()) return;
  casting->set_ended(true);
  *casting->mutable_curls() = {curls.begin(), curls.end()};
  write(*line);
}

std::optional<v1::Line> Lines::restart(const std::string& name) {
  const std::lock_guard lock(mutex_);
  auto line = read_line(directory_, name);
  if (!line) return std::nullopt;
  line->clear_castings();
  *line->mutable_restart_time() = jobs::now();
  write(*line);
  return line;
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
