#include "client/session/line_source.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <string_view>
#include <thread>
#include <utility>

#include "client/session/failure.hpp"
#include "client/session/readings_table.hpp"

namespace dccast::client {

namespace {

/// A line without an end must not fill the memory. What is left of it is still too long to be read.
constexpr std::size_t longest_kept = ReadingsTable::longest_line + 1;

/// Remarks that no line has come for 10 s, or for three usual pauses where these are longer.
class Silence {
public:
  explicit Silence(Remark remark) : remark_(std::move(remark)) {}

  /// No line is there.
  void go_on() {
    if (is_told_ || seconds() < std::max(shortest_s, 3.0 * longest_pause_s_)) return;
    is_told_ = true;
    if (remark_) remark_(fmt::format("no line for {:.0f} s; still waiting", seconds()));
  }
  /// Lines have come.
  void end() {
    if (is_told_ && remark_)
      remark_(fmt::format("lines come again, after {:.0f} s without", seconds()));
    // A silence is no usual pause.
    if (!is_told_) longest_pause_s_ = std::max(seconds(), 0.9 * longest_pause_s_);
    is_told_ = false;
    since_ = Clock::now();
  }

private:
  using Clock = std::chrono::steady_clock;
  static constexpr double shortest_s = 10.0;

  double seconds() const { return std::chrono::duration<double>(Clock::now() - since_).count(); }

  Remark remark_;
  Clock::time_point since_ = Clock::now();
  double longest_pause_s_ = 0.0;  ///< recently
  bool is_told_ = false;
};

class FileLines final : public LineSource {
public:
  FileLines(std::string path, FileEnd end, Remark remark)
      : path_(std::move(path)),
        descriptor_(path_ == "-" ? STDIN_FILENO : ::open(path_.c_str(), O_RDONLY | O_CLOEXEC)),
        end_(end),
        remark_(remark),
        silence_(std::move(remark)) {
    if (descriptor_ < 0)
      throw invalid(fmt::format("{} cannot be read: {}", path_, std::strerror(errno)));
  }
  FileLines(const FileLines&) = delete;
  ~FileLines() override {
    if (descriptor_ != STDIN_FILENO) ::close(descriptor_);
  }

  std::vector<std::string> next(const std::stop_token& stop) override {
    std::vector<std::string> lines;
    bool more = true;
    while (lines.empty() && more && !stop.stop_requested()) {
      more = read_some(stop);
      for (std::size_t end; (end = rest_.find('\n')) != std::string::npos; rest_.erase(0, end + 1))
        lines.push_back(rest_.substr(0, end));
      rest_.resize(std::min(rest_.size(), longest_kept));
    }
    // The last line of a file may have no end.
    if (!more && !rest_.empty() && !stop.stop_requested())
      lines.push_back(std::exchange(rest_, {}));
    if (!lines.empty()) silence_.end();
    return lines;
  }

private:
  static constexpr std::chrono::milliseconds between_looks{200};

  /// Reads what is there. @return whether there may be more
  bool read_some(const std::stop_token& stop) {
    pollfd ready{.fd = descriptor_, .events = POLLIN, .revents = 0};
    while (::poll(&ready, 1, static_cast<int>(between_looks.count())) <= 0) {
      if (stop.stop_requested()) return false;
      silence_.go_on();
    }

    if (read_bytes()) return true;
    // poll() reports the end of a file as readable: wait, since a plant's logger may still append
    // to it.
    if (end_ == FileEnd::ends_source) return false;
    silence_.go_on();
    if (!take_new_file()) std::this_thread::sleep_for(between_looks);
    return true;
  }

  /// @return false at the end of what is there
  bool read_bytes() {
    std::array<char, 4096> bytes;
    const ssize_t count = ::read(descriptor_, bytes.data(), bytes.size());
    if (count > 0) rest_.append(bytes.data(), static_cast<std::size_t>(count));
    return count > 0 || (count < 0 && errno == EINTR);
  }

  /// A logger that begins a new file gives it the name of the old one, which it has renamed,
  /// deleted or cut. @return whether there is a new one
  bool take_new_file() {
    struct stat open_file {
    }, named{};
    if (path_ == "-" || ::fstat(descriptor_, &open_file) != 0) return false;
    if (::stat(path_.c_str(), &named) != 0) {
      if (!std::exchange(is_away_, true)) say("is not there any more; waiting for a new one");
      return false;
    }

    is_away_ = false;
    const bool is_other = named.st_ino != open_file.st_ino || named.st_dev != open_file.st_dev;
    const bool is_cut = open_file.st_size < ::lseek(descriptor_, 0, SEEK_CUR);
    if (!is_other && !is_cut) return false;
    if (is_other) {
      if (read_bytes()) return true;  // what was written to the old one meanwhile
      const int renewed = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
      if (renewed < 0) return false;
      ::close(std::exchange(descriptor_, renewed));
    }
    ::lseek(descriptor_, 0, SEEK_SET);
    // A line without an end is complete now.
    if (!rest_.empty()) rest_ += '\n';
    say("was begun anew; it is followed from its begin");
    return true;
  }

  void say(const char* what) const {
    if (remark_) remark_(fmt::format("{} {}", path_, what));
  }

  std::string path_;
  int descriptor_;
  FileEnd end_;
  Remark remark_;
  Silence silence_;
  std::string rest_;      ///< begin of the next line
  bool is_away_ = false;  ///< no file has the name
};

class TopicLines final : public LineSource {
public:
  TopicLines(const Topic& topic, const BrokerLogin& login, Remark remark)
      : silence_(remark),
        connection_(topic, login,
                    {.message = [this](std::string_view text) { add(text); },
                     .remark = std::move(remark)}) {}
  TopicLines(const TopicLines&) = delete;
  ~TopicLines() override {
    const std::lock_guard lock(mutex_);
    ends_ = true;
    changed_.notify_all();
  }

  std::vector<std::string> next(const std::stop_token& stop) override {
    std::unique_lock lock(mutex_);
    while (!changed_.wait_for(lock, stop, std::chrono::seconds(1),
                              [this] { return !lines_.empty(); })) {
      if (stop.stop_requested()) return {};
      silence_.go_on();
    }
    silence_.end();
    auto lines = std::exchange(lines_, {});
    changed_.notify_all();
    return lines;
  }

private:
  /// Lines that wait here at most; further messages then wait at the broker.
  static constexpr std::size_t most_waiting = 10000;

  /// Called by the thread of the connection.
  void add(std::string_view text) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return ends_ || lines_.size() < most_waiting; });
    while (!text.empty() && !ends_) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      lines_.emplace_back(text.substr(0, std::min(end, longest_kept)));
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::vector<std::string> lines_;
  bool ends_ = false;
  Silence silence_;
  MqttConnection connection_;  ///< ends before what its thread uses
};

}  // namespace

std::unique_ptr<LineSource> lines_of_file(const std::string& path, FileEnd end, Remark remark) {
  return std::make_unique<FileLines>(path, end, std::move(remark));
}

std::unique_ptr<LineSource> lines_of_topic(const Topic& topic, const BrokerLogin& login,
                                           Remark remark) {
  return std::make_unique<TopicLines>(topic, login, std::move(remark));
}

}  // namespace dccast::client
