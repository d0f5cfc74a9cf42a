#include "client/session/unsent_readings.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <google/protobuf/io/zero_copy_stream_impl.h>
#include <google/protobuf/util/delimited_message_util.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <system_error>
#include <utility>

namespace dccast::client {

namespace fs = std::filesystem;

fs::path unsent_readings_file(const std::string& job) {
  const auto variable = [](const char* name) {
    const char* const value = std::getenv(name);
    return value == nullptr || *value != '/' ? fs::path() : fs::path(value);
  };
  fs::path state = variable("XDG_STATE_HOME");
  if (state.empty() && !variable("HOME").empty()) state = variable("HOME") / ".local" / "state";
  return state.empty() ? fs::path() : state / "dccast" / "readings" / job;
}

UnsentReadings::UnsentReadings(fs::path file, Remark remark)
    : file_(std::move(file)), remark_(std::move(remark)) {
  std::string fault = open_file();
  if (!fault.empty())
    remark_(fault + "; readings that wait for the server are kept in memory alone");
  else
    read_left();
}

std::string UnsentReadings::open_file() {
  if (file_.empty()) return "neither XDG_STATE_HOME nor HOME is set";
  std::error_code error;
  fs::create_directories(file_.parent_path(), error);
  descriptor_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0600);
  if (descriptor_ < 0) return fmt::format("{}: {}", file_.string(), std::strerror(errno));

  // Two programs that send to one job must not empty each other's file.
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return {};
  ::close(std::exchange(descriptor_, -1));
  return file_.string() + " belongs to another program that sends to this job";
}

UnsentReadings::~UnsentReadings() {
  if (descriptor_ < 0) return;
  if (unsent_.empty()) ::unlink(file_.c_str());
  ::close(descriptor_);
}

void UnsentReadings::read_left() {
  google::protobuf::io::FileInputStream stream(descriptor_);
  v1::Reading reading;
  bool is_end = false;
  // What a power cut has torn ends the file.
  while (google::protobuf::util::ParseDelimitedFromZeroCopyStream(&reading, &stream, &is_end)) {
    bytes_ += reading.ByteSizeLong();
    unsent_.push_back({std::move(reading), 0});
    reading.Clear();
  }
  if (!unsent_.empty())
    remark_(fmt::format("{} readings were kept in {} and are sent now", unsent_.size(),
                        file_.string()));
}

void UnsentReadings::write(const std::string& text) {
  if (descriptor_ < 0) return;
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t count = ::write(descriptor_, text.data() + done, text.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      remark_(fmt::format("{}: {}; readings that wait for the server are kept in memory alone",
                          file_.string(), std::strerror(errno)));
      ::close(std::exchange(descriptor_, -1));
      return;
    }
    done += static_cast<std::size_t>(count);
  }
}

bool UnsentReadings::add(std::vector<ReadingOfLine> readings, std::stop_token stop) {
  std::ostringstream text;
  for (const ReadingOfLine& each : readings)
    google::protobuf::util::SerializeDelimitedToOstream(each.reading, &text);

  std::unique_lock lock(mutex_);
  const auto has_room = [&] { return bytes_ + text.view().size() <= most_bytes; };
  if (!has_room() && !std::exchange(is_full_, true))
    remark_(
        fmt::format("{} MB of readings wait for the server, and no more are read until it is "
                    "back",
                    most_bytes >> 20));
  if (!changed_.wait(lock, stop, has_room)) return false;

  is_full_ = false;
  write(text.str());
  bytes_ += text.view().size();
  std::ranges::move(readings, std::back_inserter(unsent_));
  changed_.notify_all();
  return true;
}

void UnsentReadings::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  changed_.notify_all();
}

std::vector<ReadingOfLine> UnsentReadings::next(std::stop_token stop) {
  constexpr std::size_t most = 1000;  // of a call
  std::unique_lock lock(mutex_);
  changed_.wait(lock, stop, [this] { return closed_ || !unsent_.empty(); });
  if (stop.stop_requested()) return {};
  const auto count = static_cast<std::ptrdiff_t>(std::min(most, unsent_.size()));
  return {unsent_.begin(), unsent_.begin() + count};
}

void UnsentReadings::acknowledge(std::size_t count) {
  const std::lock_guard lock(mutex_);
  unsent_.erase(unsent_.begin(), unsent_.begin() + static_cast<std::ptrdiff_t>(count));
  if (!unsent_.empty()) return;
  // A reading that is sent again does no harm: the server leaves out what it has.
  if (descriptor_ >= 0 && ::ftruncate(descriptor_, 0) != 0) return;
  bytes_ = 0;
  changed_.notify_all();
}

std::size_t UnsentReadings::size() const {
  const std::lock_guard lock(mutex_);
  return unsent_.size();
}

}  // namespace dccast::client
