// Values at points of the metal, over time or along a line, from the stored frames of a job.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <span>

#include "client/commands/commands.hpp"
#include "client/session/jobs.hpp"
#include "client/text/table.hpp"
#include "proto/case_file/quantity.hpp"

namespace dccast::client {
namespace {

struct ProbeOptions {
  std::string id, at, to, time;
  std::vector<std::string> fields;
  int points = 21;
  bool csv = false;
  bool json = false;
};

constexpr const char* axis_names = "xyz";

/// Reads "660 mm, 285 mm, 50 mm" or "660,285,50 mm": a unit holds for the numbers before it.
/// Throws CommandFailed, naming the option.
/// @return (coordinate) [m], two or three
std::vector<double> read_point(const std::string& text, const char* option) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }

  std::vector<double> point(parts.size());
  std::string unit;  // of the numbers that follow in the text
  for (std::size_t i = parts.size(); i-- > 0;) {
    const std::size_t letter = parts[i].find_first_of("abcdefghijklmnopqrstuvwxyz");
    if (letter != std::string::npos) unit = parts[i].substr(letter);
    const auto quantity = case_file::parse_quantity(
        letter == std::string::npos ? parts[i] + " " + unit : parts[i], "m");
    if (!quantity.value || unit.empty())
      throw invalid(fmt::format("{} \"{}\": a point with its unit is expected, e.g. 660,285,50 mm",
                                option, text));
    point[i] = *quantity.value;
  }
  if (point.size() < 2 || point.size() > 3)
    throw invalid(
        fmt::format("{} \"{}\": two coordinates of a section, or three of a slab", option, text));
  return point;
}

using Point = std::vector<double>;  ///< (coordinate) [m]

/// Points from one to another, both included.
/// @param count  at least 2
std::vector<Point> points_on_line(const Point& from, const Point& to, int count) {
  if (from.size() != to.size())
    throw invalid("--at and --to: both ends of the line need the same number of coordinates");

  std::vector<Point> points;
  for (int i = 0; i < count; ++i) {
    const double share = double(i) / (count - 1);
    Point& point = points.emplace_back(from.size());
    for (std::size_t axis = 0; axis < from.size(); ++axis)
      point[axis] = (1.0 - share) * from[axis] + share * to[axis];
  }
  return points;
}

double distance(const Point& from, const Point& to) {
  double squared = 0.0;
  for (std::size_t axis = 0; axis < from.size(); ++axis)
    squared += (to[axis] - from[axis]) * (to[axis] - from[axis]);
  return std::sqrt(squared);
}

/// What the server found, with the points that were asked for.
struct Probe {
  std::vector<Point> points;
  bool line = false;  ///< at one instant; else one point over time
  v1::ProbeResultResponse found;
};

Probe ask(Connection& connection, const std::string& id, const ProbeOptions& options) {
  Probe probe;
  const Point from = read_point(options.at, "--at");
  probe.line = !options.to.empty();
  if (probe.line)
    probe.points = points_on_line(from, read_point(options.to, "--to"), options.points);
  else
    probe.points.push_back(from);

  v1::ProbeResultRequest request;
  request.set_id(id);
  for (const Point& point : probe.points)
    request.add_points()->mutable_coordinate_m()->Add(point.begin(), point.end());
  for (const std::string& field : options.fields) request.add_fields(field);

  if (!options.time.empty()) {
    const auto time = case_file::parse_quantity(options.time, "s").value;
    if (!time)
      throw invalid(
          fmt::format("--time \"{}\": a time with its unit is expected, e.g. 60 s", options.time));
    request.set_time_s(*time);
    // A single point is read over all frames, a line at one of them.
  } else if (probe.line) {
    request.set_last(true);
  }

  probe.found = connection.call(&Stub::ProbeResult, request);
  return probe;
}

/// Calls use(instant, number of the point, its values by field) for each point of each instant.
template <class Use>
void for_each_sample(const Probe& probe, const Use& use) {
  const int fields = probe.found.fields_size();
  for (const auto& instant : probe.found.instants())
    for (std::size_t p = 0; p < probe.points.size(); ++p)
      use(instant, p, std::span(instant.values().data() + int(p) * fields, std::size_t(fields)));
}

std::string place_text(const std::vector<double>& point) {
  std::string text;
  for (std::size_t i = 0; i < point.size(); ++i)
    text += fmt::format("{}{} {} mm", i == 0 ? "" : ", ", axis_names[i], mm(point[i]));
  return text;
}

/// A value as people read it; "-" where there is no metal.
std::string value_text(const v1::FrameField& field, double value) {
  if (std::isnan(value)) return "-";
  if (field.unit() == "degC") return fixed(value, 1);
  if (field.unit() == "m") return mm(value, 2);
  return fmt::format("{:.4g}", value);
}

std::string heading(const v1::FrameField& field, int number) {
  if (number == 0) return ">temperature °C";
  if (field.unit() != "m") return fmt::format(">{}", field.name());
  if (field.name().starts_with("displacement_"))
    return fmt::format(">moved {} mm", axis_names[number - 1]);
  return fmt::format(">{} mm", field.name().substr(0, field.name().size() - 2));  // without "_m"
}

/// Refuses places where no frame has metal: they are a slip of the user rather than an answer.
void require_metal(const Probe& probe) {
  bool has_metal = false;
  for_each_sample(probe, [&](const auto&, std::size_t, std::span<const double> values) {
    has_metal = has_metal || std::ranges::any_of(values, [](double v) { return !std::isnan(v); });
  });
  if (has_metal) return;

  const std::string end = probe.line ? " to " + place_text(probe.points.back()) : "";
  throw CommandFailed(ExitCode::not_found,
                      fmt::format("there is no metal at {}{} in any frame: it is outside of the "
                                  "slab, or above what was cast; coordinates are from the middle "
                                  "and from the block up, those of a quarter slab not negative",
                                  place_text(probe.points.front()), end));
}

std::string table_text(const Probe& probe) {
  std::vector<std::string> headings;
  if (probe.line) {
    headings = {">along mm"};
    for (std::size_t i = 0; i < probe.points.front().size(); ++i)
      headings.push_back(fmt::format(">{} mm", axis_names[i]));
  } else {
    headings = {">time s", ">cast mm"};
  }
  for (int i = 0; i < probe.found.fields_size(); ++i)
    headings.push_back(heading(probe.found.fields(i), i));

  Table table(headings);
  // Rows are the places on a line, or the instants of one point.
  for_each_sample(probe, [&](const auto& instant, std::size_t p, std::span<const double> values) {
    const Point& point = probe.points[p];
    std::vector<std::string> row;
    if (probe.line) {
      row.push_back(mm(distance(probe.points.front(), point)));
      for (const double coordinate : point) row.push_back(mm(coordinate));
    } else {
      row = {fixed(instant.time_s(), 2), mm(instant.cast_length_m())};
    }
    for (std::size_t i = 0; i < values.size(); ++i)
      row.push_back(value_text(probe.found.fields(int(i)), values[i]));
    table.add(std::move(row));
  });
  return table.text();
}

Json samples_json(const Probe& probe) {
  Json samples = Json::array();
  for_each_sample(probe, [&](const auto& instant, std::size_t p, std::span<const double> values) {
    Json sample{{"time_s", instant.time_s()},
                {"cast_length_m", instant.cast_length_m()},
                {"at_m", Json(probe.points[p])}};
    for (std::size_t i = 0; i < values.size(); ++i)
      sample[probe.found.fields(int(i)).name()] = std::isnan(values[i]) ? Json() : Json(values[i]);
    samples.push_back(std::move(sample));
  });
  return samples;
}

std::string csv_text(const Probe& probe) {
  std::string text = "time_s,cast_length_m";
  for (std::size_t i = 0; i < probe.points.front().size(); ++i)
    text += fmt::format(",{}_m", axis_names[i]);
  for (const v1::FrameField& field : probe.found.fields()) text += "," + field.name();
  text += "\n";

  for_each_sample(probe, [&](const auto& instant, std::size_t p, std::span<const double> values) {
    text += fmt::format("{:.9g},{:.9g}", instant.time_s(), instant.cast_length_m());
    for (const double coordinate : probe.points[p]) text += fmt::format(",{:.9g}", coordinate);
    for (const double value : values)
      // Outside of the slab there is no value: an empty cell.
      text += std::isnan(value) ? "," : fmt::format(",{:.9g}", value);
    text += "\n";
  });
  return text;
}

ExitCode run(const ProbeOptions& options, Program& program) {
  if (options.to.empty() && !options.time.empty())
    throw invalid("--time goes with a line: give --to too");

  Connection connection = program.connect();
  const std::string id = resolve_job(connection, options.id);
  const Probe probe = ask(connection, id, options);
  require_metal(probe);

  if (options.json) {
    print_line({{"job", id}, {"samples", samples_json(probe)}});
  } else if (options.csv) {
    std::cout << csv_text(probe);
  } else {
    std::cout << table_text(probe);
    const auto& first = probe.found.instants(0);
    const std::string place = probe.line
                                  ? fmt::format("at {} s, cast length {} mm",
                                                fixed(first.time_s(), 2), mm(first.cast_length_m()))
                                  : fmt::format("at {}", place_text(probe.points.front()));
    std::cerr << place << ", in the undeformed slab; - where there is no metal\n";
  }
  return ExitCode::done;
}

}  // namespace

void add_probe(CommandLine& line, Program& program) {
  const auto [command, options] = declare<ProbeOptions>(
      line, program, run, "probe",
      "Temperature, displacement and further fields at a point over time, or along a line",
      "dccast probe JOB --at 660,0,50mm\n"
      "  dccast probe JOB --at 0,0,50mm --to 660,0,50mm --time \"60 s\" --csv > line.csv");

  command.option("JOB", options.id, job_help, required);
  command.option("--at", options.at,
                 "Point of the undeformed slab: x and y from the middle, z above the block; of a "
                 "section x and y",
                 {.required = true, .placeholder = "POINT"});
  command.option("--to", options.to, "End of a line that begins there", {.placeholder = "POINT"});
  command.option("--time", options.time, "Of a line: the nearest stored frame; default: the last",
                 {.placeholder = "TIME"});
  command.repeatable("--field", options.fields, "A further field of the frames, e.g. von_mises_pa",
                     {.placeholder = "NAME"});

  command.number("--points", options.points, 2, 10000, "Of a line: number of points");
  command.json(options.json);
  command.flag("--csv", options.csv, "As CSV in SI units and degrees Celsius",
               {.excludes = {"--json"}});
}

}  // namespace dccast::client
