#include "client/session/readings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "client/session/jobs.hpp"

namespace dccast::client {

namespace {

constexpr std::chrono::milliseconds first_pause{200};

}  // namespace

RecordSender::RecordSender(Connection& connection, std::string id, Remark remark)
    : connection_(connection), id_(std::move(id)), remark_(std::move(remark)) {
  v1::AppendReadingsRequest request;
  request.set_id(id_);
  kept_ = connection_.call(&Stub::AppendReadings, request);
}

grpc::Status RecordSender::append(const v1::AppendReadingsRequest& request) {
  constexpr std::chrono::milliseconds longest_pause{2000};
  std::chrono::milliseconds pause = first_pause;
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
  if (status.error_code() != grpc::INVALID_ARGUMENT) throw failure_of(status, connection_.server());

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
