#include "server/worker/followed_levers.hpp"

#include <chrono>
#include <thread>

namespace dccast::worker {

namespace {

/// How often the record is looked at: short beside the second between two readings.
constexpr std::chrono::milliseconds between_looks{20};

casting::LeverReading to_core(const v1::Reading& reading) {
  casting::LeverReading levers{.time = reading.time_s(), .value = {}};
  const auto set = [&](casting::Lever lever, bool given, double value) {
    if (given) levers.of(lever) = value;
  };
  set(casting::Lever::casting_speed, reading.has_casting_speed_m_per_s(),
      reading.casting_speed_m_per_s());
  set(casting::Lever::casting_temperature, reading.has_casting_temperature_c(),
      reading.casting_temperature_c());
  set(casting::Lever::water_flow, reading.has_water_flow_m2_per_s(), reading.water_flow_m2_per_s());
  set(casting::Lever::narrow_water_flow, reading.has_narrow_water_flow_m2_per_s(),
      reading.narrow_water_flow_m2_per_s());
  set(casting::Lever::second_water_flow, reading.has_second_water_flow_m2_per_s(),
      reading.second_water_flow_m2_per_s());
  set(casting::Lever::water_temperature, reading.has_water_temperature_c(),
      reading.water_temperature_c());
  set(casting::Lever::metal_level, reading.has_metal_level_m(), reading.metal_level_m());
  return levers;
}

}  // namespace

casting::LeverFeed::Arrived FollowedLevers::wait_until(double time) {
  Arrived arrived;
  for (;;) {
    for (const v1::Reading& reading : record_.read_new()) {
      watch_.follow(reading);
      if (reading.closes())
        closed_ = true;
      else
        arrived.readings.push_back(to_core(reading));
    }

    arrived.closed = closed_;
    arrived.order = order_();
    const bool known = !arrived.readings.empty() && arrived.readings.back().time >= time;
    if (known || arrived.closed || arrived.order != casting::Order::go_on) return arrived;
    std::this_thread::sleep_for(between_looks);
  }
}

}  // namespace dccast::worker
