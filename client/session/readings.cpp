#include "client/session/readings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "client/session/jobs.hpp"

namespace dccast::client {

namespace {

constexpr std::chrono::milliseconds first_pause{200};

/// Levers and curls that a reading holds.
int count_values(const v1::Reading& reading) {
  return int(reading.has_casting_speed_m_per_s()) + int(reading.has_casting_temperature_c()) +
         int(reading.has_water_flow_m2_per_s()) + int(reading.has_narrow_water_flow_m2_per_s()) +
         int(reading.has_second_water_flow_m2_per_s()) + int(reading.has_water_temperature_c()) +
         int(reading.has_metal_level_m()) + reading.curls_size();
}

/// Whether the same readings may be taken later. What the server has refused itself it refuses
/// again, unless it lacks something now.
bool may_pass(const grpc::Status& status) {
  using v1::ErrorInfo;
  const auto refusal = refusal_of(status);
  if (!refusal) return is_passing(status.error_code());
  return refusal->reason == ErrorInfo::BUSY || refusal->reason == ErrorInfo::STORAGE_FULL ||
         refusal->reason == ErrorInfo::SERVER_OVERLOADED;
}

}  // namespace

RecordSender::RecordSender(Connection& connection, std::string id, Remark remark)
    : connection_(connection), id_(std::move(id)), remark_(std::move(remark)) {
  v1::AppendReadingsRequest request;
  request.set_id(id_);
  kept_ = connection_.call(&Stub::AppendReadings, request);
  has_values_ = kept_.number() > 0;
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
    if (!may_pass(status)) return status;

    if (!said) remark_(fmt::format("{}; the readings wait here", reason_of(status)));
    connection_.interruption().sleep(pause);
    pause = std::min(2 * pause, longest_pause);
  }
}

void RecordSender::count_left_out(std::span<const ReadingOfLine> readings, std::int64_t before) {
  for (const v1::LeftOutValue& left_out : kept_.left_out()) {
    if (++left_out_[left_out.name()] > 1) continue;
    const std::int64_t place = left_out.number() - before - 1;
    if (place < 0 || place >= std::ssize(readings)) continue;  // of a server that counts otherwise

    const ReadingOfLine& held = readings[static_cast<std::size_t>(place)];
    remark_(fmt::format(
        "line {}, {:g} s: {}; this value alone is left out, and so are others that no plant has",
        held.line, held.reading.time_s(), left_out.reason()));
  }
}

void RecordSender::remark_known() {
  if (known_ > 0) remark_(fmt::format("{} readings are on the server already", known_));
  known_ = 0;
}

void RecordSender::remark_left_out() {
  remark_known();
  if (refused_ > 1) remark_(fmt::format("readings that were refused: {} in all", refused_));
  for (const auto& [name, count] : left_out_)
    if (count > 1) remark_(fmt::format("{}: {} values were left out", name, count));
}

bool RecordSender::send_numbered(std::span<const ReadingOfLine> readings) {
  const std::int64_t before = kept_.number();
  v1::AppendReadingsRequest request;
  request.set_id(id_);
  for (const ReadingOfLine& each : readings) {
    v1::Reading& added = *request.add_readings() = each.reading;
    added.set_number(before + request.readings_size());
  }

  const grpc::Status status = append(request);
  if (status.ok()) {
    int values = -kept_.left_out_size();
    for (const ReadingOfLine& each : readings) values += count_values(each.reading);
    if (values > 0) has_values_ = true;
    count_left_out(readings, before);
    return true;
  }
  if (status.error_code() == grpc::FAILED_PRECONDITION) return false;
  if (status.error_code() != grpc::INVALID_ARGUMENT) throw failure_of(status, connection_.server());

  // One reading among them is refused: only that one is lost.
  if (readings.size() == 1) {
    if (++refused_ == 1)
      remark_(fmt::format("line {}: {}", readings.front().line, reason_of(status)));
    return true;
  }
  for (std::size_t i = 0; i < readings.size(); ++i)
    if (!send_numbered(readings.subspan(i, 1))) return false;
  return true;
}

bool RecordSender::send(std::vector<ReadingOfLine> readings) {
  constexpr std::size_t most = 1000;  // of a call
  const std::size_t known = std::erase_if(readings, [this](const ReadingOfLine& each) {
    return kept_.has_time_s() && each.reading.time_s() <= kept_.time_s();
  });
  known_ += known;
  if (!readings.empty()) remark_known();

  const std::span all(readings);
  for (std::size_t i = 0; i < readings.size(); i += most)
    if (!send_numbered(all.subspan(i, std::min(most, readings.size() - i)))) return false;
  return true;
}

void RecordSender::close() {
  ReadingOfLine end;
  end.reading.set_closes(true);
  send_numbered({&end, 1});
}

}  // namespace dccast::client
