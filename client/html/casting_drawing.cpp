#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "client/html/html_parts.hpp"
#include "client/html/judgement_parts.hpp"
#include "client/html/pages.hpp"
#include "proto/case_file/plant_words.hpp"
#include "proto/case_file/schedule.hpp"

namespace dccast::client {
namespace {

using case_file::CastingSchedule, case_file::Face, case_file::Instant;

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

Json casting_drawing(const v1::Case& complete) {
  constexpr int most_points = 400;  // of a line
  const CastingSchedule schedule(complete);
  return {{"case", to_json(complete)},
          {"charts", std::vector<Json>{chart_json(speed_chart(schedule), most_points),
                                       chart_json(water_chart(schedule), most_points)}}};
}

std::string casting_page(const v1::Case& complete) {
  const std::string title = html_escaped(complete.title());
  return whole_page(
      title, element("h1", title),
      element("p class='answer'", html_escaped(case_file::casting_summary(complete))) +
          card("Start of the casting", drawn("casting", casting_drawing(complete))));
}

}  // namespace dccast::client
