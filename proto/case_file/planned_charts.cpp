#include <functional>
#include <string>
#include <vector>

#include "proto/case_file/plant_words.hpp"
#include "proto/case_file/schedule.hpp"

namespace dccast::case_file {
namespace {

/// What a line shows: its name, and its value at an instant.
struct Planned {
  std::string name;
  std::function<double(const Instant&)> value;
};

/// A chart of what is planned from the hold to the end of the casting, against cast length where
/// the tables are.
v1::Chart planned_chart(const CastingSchedule& schedule, const std::string& heading,
                        const std::string& unit, bool by_length,
                        const std::vector<Planned>& lines) {
  v1::Chart chart;
  chart.set_heading(heading);
  chart.mutable_x()->set_quantity(by_length ? "cast length" : "time");
  chart.mutable_x()->set_unit(by_length ? "m" : "s");
  chart.mutable_y()->set_quantity(heading);
  chart.mutable_y()->set_unit(unit);

  // The hold has no cast length.
  std::vector<Instant> instants = schedule.instants();
  std::erase_if(instants, [&](const Instant& instant) {
    return instant.time_s > schedule.end_s() || (by_length && instant.time_s <= 0.0);
  });

  for (const auto& [name, value] : lines) {
    v1::Chart::Line& line = *chart.add_lines();
    line.set_name(name);
    for (const Instant& instant : instants) {
      line.add_x(by_length ? instant.cast_length_m : instant.time_s);
      line.add_y(value(instant));
    }
  }
  return chart;
}

v1::Chart speed_chart(const CastingSchedule& schedule) {
  return planned_chart(
      schedule, "casting speed", "m/s", schedule.casting_speed().changes_by_length(),
      {{"casting speed", [&](const Instant& at) { return schedule.speed_m_per_s(at); }}});
}

v1::Chart water_chart(const CastingSchedule& schedule) {
  const auto flow = [&](Face face) {
    return [&schedule, face](const Instant& at) {
      return schedule.valve_is_open(face, at.time_s) ? schedule.flow_m2_per_s(face, at) : 0.0;
    };
  };

  std::vector<Planned> lines{
      {schedule.has_narrow_water() ? "wide face" : "water", flow(Face::wide)}};
  bool by_length = schedule.water_flow(Face::wide).changes_by_length();
  if (schedule.has_narrow_water()) {
    lines.push_back({"narrow face", flow(Face::narrow)});
    by_length = by_length && schedule.water_flow(Face::narrow).changes_by_length();
  }
  if (schedule.has_second_water()) {
    lines.push_back(
        {"second water", [&](const Instant& at) { return schedule.second_flow_m2_per_s(at); }});
    by_length = by_length && schedule.second_water_flow().changes_by_length();
  }
  return planned_chart(schedule, "water", "m2/s", by_length, lines);
}

}  // namespace

std::vector<v1::Chart> planned_charts(const v1::Case& complete) {
  const CastingSchedule schedule(complete);
  return {speed_chart(schedule), water_chart(schedule)};
}

}  // namespace dccast::case_file
