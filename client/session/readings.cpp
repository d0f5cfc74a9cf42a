#include "client/session/readings.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "client/session/jobs.hpp"
#include "client/session/readings_table.hpp"

namespace dccast::client {

namespace {

constexpr std::chrono::milliseconds between_looks{200};

}  // namespace

LineSource::LineSource(const std::string& path, bool growing)
    : descriptor_(path == "-" ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC)),
      growing_(growing) {
  if (descriptor_ < 0)
    throw invalid(fmt::format("{} cannot be read: {}", path, std::strerror(errno)));
}

LineSource::~LineSource() {
  if (descriptor_ != STDIN_FILENO) ::close(descriptor_);
}

bool LineSource::read_some(const std::stop_token& stop) {
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
  if (!growing_) return false;
  std::this_thread::sleep_for(between_looks);
  return true;
}

std::vector<std::string> LineSource::next(const std::stop_token& stop) {
  std::vector<std::string> lines;
  bool more = true;
  while (lines.empty() && more && !stop.stop_requested()) {
    more = read_some(stop);
    for (std::size_t end; (end = rest_.find('\n')) != std::string::npos; rest_.erase(0, end + 1))
      lines.push_back(rest_.substr(0, end));
    // A line without an end must not fill the memory: what is left of it is still too long to read.
    rest_.resize(std::min(rest_.size(), ReadingsTable::longest_line + 1));
  }
  // The last line of a file may have no end.
  if (!more && !rest_.empty() && !stop.stop_requested()) lines.push_back(std::exchange(rest_, {}));
  return lines;
}

RecordSender::RecordSender(Connection& connection, std::string id,
                           std::function<void(const std::string&)> remark)
    : connection_(connection), id_(std::move(id)), remark_(std::move(remark)) {
  v1::AppendReadingsRequest request;
  request.set_id(id_);
  kept_ = connection_.call(&Stub::AppendReadings, request);
}

grpc::Status RecordSender::append(const v1::AppendReadingsRequest& request) {
  constexpr std::chrono::milliseconds longest_pause{2000};
  std::chrono::milliseconds pause = between_looks;
  for (bool said = false;; said = true) {
    v1::AppendReadingsResponse kept;
    const grpc::Status status = connection_.try_once(&Stub::AppendReadings, request, kept);
    if (status.ok()) {
      if (said) remark_("the server takes readings again");
      kept_ = kept;
      return status;
    }
    // What the server has refused itself it will refuse again.
    if (refusal_of(status) || !is_passing(status.error_code())) return status;

    if (!said) remark_(fmt::format("{}; the readings wait here", reason_of(status)));
    connection_.interruption().sleep(pause);
    pause = std::min(2 * pause, longest_pause);
  }
}

bool RecordSender::send_numbered(const std::vector<v1::Reading>& readings) {
  v1::AppendReadingsRequest request;
  request.set_id(id_);
  for (const v1::Reading& reading : readings) {
    v1::Reading& added = *request.add_readings() = reading;
    added.set_number(kept_.number() + request.readings_size());
  }

  const grpc::Status status = append(request);
  if (status.ok()) return true;
  if (status.error_code() == grpc::FAILED_PRECONDITION) return false;
  if (status.error_code() != grpc::INVALID_ARGUMENT)
    throw failure_of(status, connection_.server());

  // One reading among them is refused: only that one is lost.
  if (readings.size() == 1) {
    remark_(reason_of(status));
    return true;
  }
  return std::ranges::all_of(readings,
                             [this](const v1::Reading& each) { return send_numbered({each}); });
}

bool RecordSender::send(std::vector<v1::Reading> readings) {
  constexpr std::size_t most = 1000;  // of a call
  const std::size_t known = std::erase_if(readings, [this](const v1::Reading& each) {
    return kept_.has_time_s() && each.time_s() <= kept_.time_s();
  });
  if (known > 0) remark_(fmt::format("{} readings are on the server already", known));

  for (std::size_t i = 0; i < readings.size(); i += most) {
    const auto begin = readings.begin() + static_cast<std::ptrdiff_t>(i);
    const auto count = static_cast<std::ptrdiff_t>(std::min(most, readings.size() - i));
    if (!send_numbered({begin, begin + count})) return false;
  }
  return true;
}

void RecordSender::close() {
  v1::Reading end;
  end.set_closes(true);
  send_numbered({end});
}

}  // namespace dccast::client
