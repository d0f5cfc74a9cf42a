// Values at points of the metal, over time or along a line, from the stored frames of a job.
#include <fmt/core.h>

#include <cmath>
#include <iostream>

#include "client/commands/commands.hpp"
#include "client/model/field_probe.hpp"
#include "client/session/jobs.hpp"
#include "client/text/table.hpp"
#include "proto/case_file/quantity.hpp"

namespace dccast::client::commands {
namespace {

struct ProbeOptions {
  std::string id, at, to, time;
  int points = 21;
  bool csv = false;
  bool json = false;
};

constexpr const char* axes = "xyz";

/// A point at an instant, with the values of the metal there; empty where there is no metal.
struct Sample {
  double time_s = 0.0, cast_length_m = 0.0;
  std::vector<double> point;
  double along_m = 0.0;  ///< from the begin of the line
  std::optional<PointValues> values{};
};

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

/// @param number  of the stored frame, from 1; 0 for the last one
v1::QueryResultResponse read_frame(Connection& connection, const std::string& id, int number) {
  v1::QueryResultRequest request;
  request.set_id(id);
  request.set_frame(true);
  request.set_page_size(1);
  request.set_frame_number(number);
  v1::QueryResultResponse response = connection.call(&Stub::QueryResult, request);
  if (!response.has_frame())
    throw CommandFailed(ExitCode::wrong_state,
                        fmt::format("job {} has no stored frame yet: wait until it has ended", id));
  return response;
}

void require_dimension(const std::vector<double>& point, const v1::Frame& frame) {
  if (point.size() == std::size_t(frame.dimension())) return;
  throw invalid(frame.dimension() == 2
                    ? "the job is a section: give two coordinates, x from its middle, y above the "
                      "block"
                    : "the job is a slab: give three coordinates, x and y from its middle, z above "
                      "the block");
}

Sample sample_of(const v1::Frame& frame, const std::vector<double>& point, double along_m) {
  return {frame.time_s(), frame.cast_length_m(), point, along_m, values_at(frame, point)};
}

std::vector<Sample> over_time(Connection& connection, const std::string& id,
                              const std::vector<double>& point) {
  const v1::QueryResultResponse last = read_frame(connection, id, 0);
  require_dimension(point, last.frame());

  std::vector<Sample> samples;
  for (int number = 1; number < last.frame_time_s_size(); ++number)
    samples.push_back(sample_of(read_frame(connection, id, number).frame(), point, 0.0));
  samples.push_back(sample_of(last.frame(), point, 0.0));
  return samples;
}

/// The stored frame nearest to a time; without a time the last one.
v1::Frame frame_at(Connection& connection, const std::string& id, const std::string& time) {
  const v1::QueryResultResponse last = read_frame(connection, id, 0);
  if (time.empty()) return last.frame();
  const auto wanted = case_file::parse_quantity(time, "s").value;
  if (!wanted)
    throw invalid("--time \"" + time + "\": a time with its unit is expected, e.g. 60 s");

  int nearest = 0;
  for (int i = 1; i < last.frame_time_s_size(); ++i)
    if (std::abs(last.frame_time_s(i) - *wanted) < std::abs(last.frame_time_s(nearest) - *wanted))
      nearest = i;
  return read_frame(connection, id, nearest + 1).frame();
}

std::vector<Sample> along_line(Connection& connection, const ProbeOptions& options,
                               const std::string& id) {
  const std::vector<double> from = read_point(options.at, "--at"),
                            to = read_point(options.to, "--to");
  const v1::Frame frame = frame_at(connection, id, options.time);
  require_dimension(from, frame);
  require_dimension(to, frame);

  double length_m = 0.0;
  for (std::size_t axis = 0; axis < from.size(); ++axis)
    length_m = std::hypot(length_m, to[axis] - from[axis]);
  std::vector<Sample> samples;
  for (const auto& point : points_on_line(from, to, options.points))
    samples.push_back(
        sample_of(frame, point, length_m * double(samples.size()) / (options.points - 1)));
  return samples;
}

std::string place_text(const std::vector<double>& point) {
  std::string text;
  for (std::size_t i = 0; i < point.size(); ++i)
    text += fmt::format("{}{} {} mm", i == 0 ? "" : ", ", axes[i], render::mm(point[i]));
  return text;
}

std::string table_text(const std::vector<Sample>& samples, bool line) {
  std::vector<std::string> headings;
  if (line)
    headings = {">along mm"};
  else
    headings = {">time s", ">cast mm"};
  const std::size_t coordinates = samples.front().point.size();
  if (line)
    for (std::size_t i = 0; i < coordinates; ++i)
      headings.push_back(fmt::format(">{} mm", axes[i]));
  headings.push_back(">temperature °C");
  for (std::size_t i = 0; i < coordinates; ++i)
    headings.push_back(fmt::format(">moved {} mm", axes[i]));

  render::Table table(headings);
  for (const Sample& sample : samples) {
    std::vector<std::string> row;
    if (line) {
      row.push_back(render::mm(sample.along_m));
      for (const double coordinate : sample.point) row.push_back(render::mm(coordinate));
    } else {
      row = {render::fixed(sample.time_s, 2), render::mm(sample.cast_length_m)};
    }
    row.push_back(sample.values ? render::fixed(sample.values->temperature_c, 1) : "-");
    for (std::size_t i = 0; i < coordinates; ++i)
      row.push_back(sample.values && !sample.values->displacement_m.empty()
                        ? render::mm(sample.values->displacement_m[i], 2)
                        : "-");
    table.add(std::move(row));
  }
  return table.text();
}

Json numbers_json(const std::vector<double>& numbers) {
  Json list = Json::array();
  for (const double number : numbers) list.push_back(number);
  return list;
}

Json sample_json(const Sample& sample) {
  return {{"time_s", sample.time_s},
          {"cast_length_m", sample.cast_length_m},
          {"at_m", numbers_json(sample.point)},
          {"temperature_c", sample.values ? Json(sample.values->temperature_c) : Json()},
          {"displacement_m",
           sample.values ? numbers_json(sample.values->displacement_m) : Json::array()}};
}

std::string csv_text(const std::vector<Sample>& samples) {
  const std::size_t coordinates = samples.front().point.size();
  std::string text = "time_s,cast_length_m";
  for (std::size_t i = 0; i < coordinates; ++i) text += fmt::format(",{}_m", axes[i]);
  text += ",temperature_c";
  for (std::size_t i = 0; i < coordinates; ++i) text += fmt::format(",displacement_{}_m", axes[i]);
  text += "\n";

  for (const Sample& sample : samples) {
    text += fmt::format("{:.9g},{:.9g}", sample.time_s, sample.cast_length_m);
    for (const double coordinate : sample.point) text += fmt::format(",{:.9g}", coordinate);
    text += sample.values ? fmt::format(",{:.9g}", sample.values->temperature_c) : ",";
    for (std::size_t i = 0; i < coordinates; ++i)
      text += sample.values && !sample.values->displacement_m.empty()
                  ? fmt::format(",{:.9g}", sample.values->displacement_m[i])
                  : ",";
    text += "\n";
  }
  return text;
}

ExitCode run(const ProbeOptions& options, Program& program) {
  const bool line = !options.to.empty();
  if (!line && !options.time.empty()) throw invalid("--time goes with a line: give --to too");
  const std::vector<double> point = read_point(options.at, "--at");
  Connection connection = program.connect();
  const std::string id = resolve_job(connection, options.id);
  const std::vector<Sample> samples =
      line ? along_line(connection, options, id) : over_time(connection, id, point);

  if (options.json) {
    print_line({{"job", id}, {"samples", json_list(samples, sample_json)}});
  } else if (options.csv) {
    std::cout << csv_text(samples);
  } else {
    std::cout << table_text(samples, line);
    std::cerr << (line ? fmt::format("at {} s, cast length {} mm, ",
                                     render::fixed(samples.front().time_s, 2),
                                     render::mm(samples.front().cast_length_m))
                       : "at " + place_text(point) + ", ")
              << "in the undeformed slab; - where there is no metal\n";
  }
  return ExitCode::done;
}

}  // namespace

void add_probe(cli::CommandLine& line, Program& program) {
  const auto [command, options] = declare<ProbeOptions>(
      line, program, run, "probe",
      "Temperature and displacement at a point over time, or along a line, from the stored frames",
      "dccast probe JOB --at 660,0,50mm\n"
      "  dccast probe JOB --at 0,0,50mm --to 660,0,50mm --time \"60 s\" --csv > line.csv");
  command.option("JOB", options.id, job_help, cli::required);
  command.option("--at", options.at,
                 "Point of the undeformed slab: x and y from the middle, z above the block; of a "
                 "section x and y",
                 {.required = true, .placeholder = "POINT"});
  command.option("--to", options.to, "End of a line that begins there", {.placeholder = "POINT"});
  command.option("--time", options.time, "Of a line: the nearest stored frame; default: the last",
                 {.placeholder = "TIME"});
  command.number("--points", options.points, 2, 10000, "Of a line: number of points");
  command.json(options.json);
  command.flag("--csv", options.csv, "As CSV in SI units and degrees Celsius",
               {.excludes = {"--json"}});
}

}  // namespace dccast::client::commands
