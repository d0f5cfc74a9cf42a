#include "client/session/line_source.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
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

class FileLines final : public LineSource {
public:
  FileLines(const std::string& path, FileEnd end)
      : descriptor_(path == "-" ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC)),
        end_(end) {
    if (descriptor_ < 0)
      throw invalid(fmt::format("{} cannot be read: {}", path, std::strerror(errno)));
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
    return lines;
  }

private:
  static constexpr std::chrono::milliseconds between_looks{200};

  /// Reads what is there. @return whether there may be more
  bool read_some(const std::stop_token& stop) {
    pollfd ready{.fd = descriptor_, .events = POLLIN, .revents = 0};
    while (::poll(&ready, 1, static_cast<int>(between_looks.count())) <= 0)
      if (stop.stop_requested()) return false;

    std::array<char, 4096> bytes;
    const ssize_t count = ::read(descriptor_, bytes.data(), bytes.size());
    if (count > 0) {
      rest_.append(bytes.data(), static_cast<std::size_t>(count));
      return true;
    }
    if (count < 0 && errno == EINTR) return true;
    // poll() reports the end of a file as readable: wait, since a plant's logger may still append
    // to it.
    if (end_ == FileEnd::ends_source) return false;
    std::this_thread::sleep_for(between_looks);
    return true;
  }

  int descriptor_;
  FileEnd end_;
  std::string rest_;  ///< begin of the next line
};

class TopicLines final : public LineSource {
public:
  TopicLines(const Topic& topic, const BrokerLogin& login, Remark remark)
      : connection_(topic, login,
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
    changed_.wait(lock, stop, [this] { return !lines_.empty(); });
    if (stop.stop_requested()) return {};
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
  MqttConnection connection_;  ///< ends before what its thread uses
};

}  // namespace

std::unique_ptr<LineSource> lines_of_file(const std::string& path, FileEnd end) {
  return std::make_unique<FileLines>(path, end);
}

std::unique_ptr<LineSource> lines_of_topic(const Topic& topic, const BrokerLogin& login,
                                           Remark remark) {
  return std::make_unique<TopicLines>(topic, login, std::move(remark));
}

}  // namespace dccast::client
