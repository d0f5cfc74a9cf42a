#include "core/results/findings_group.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <limits>
#include <optional>

#include "core/results/hdf5_file.hpp"
#include "core/storage/storage_error.hpp"

namespace dccast::results {

namespace {

using hdf5::File;

constexpr double absent = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t coordinates = 3;
constexpr std::array severities{Severity::note, Severity::warning, Severity::danger};

/// A text of a finding.
struct TextField {
  const char* dataset;
  const char* meaning;
  std::string Finding::*member;
};
constexpr std::array texts{
    TextField{"/findings/code", "as in docs/findings.md", &Finding::code},
    TextField{"/findings/message", "what it means in practice", &Finding::message},
    TextField{"/findings/unit", "of value and limit", &Finding::unit},
    TextField{"/findings/key", "key of the case that sets the limit or causes the finding",
              &Finding::key},
};

/// A number of a finding.
struct RealField {
  const char* dataset;
  const char* unit;  ///< "1": that of the finding
  const char* meaning;
  std::optional<double> Finding::*member;
};
constexpr std::array reals{
    RealField{"/findings/time_s", "s", "when first found; NaN: follows from the case alone",
              &Finding::time},
    RealField{"/findings/value", "1", "in the unit of the finding", &Finding::value},
    RealField{"/findings/limit", "1", "in the unit of the finding", &Finding::limit},
    RealField{"/findings/lower_error", "1",
              "how far mesh and steps may have put the true figure below the worst one",
              &Finding::lower_error},
    RealField{"/findings/upper_error", "1", "the same above it", &Finding::upper_error},
};

/// Collects one text of each finding. @param select  returns it
template <class Select>
std::vector<std::string> collect_texts(const std::vector<Finding>& findings, Select&& select) {
  std::vector<std::string> values;
  for (const Finding& finding : findings) values.emplace_back(select(finding));
  return values;
}

/// Writes places of the undeformed slab as rows of three coordinates, NaN where there is none.
void write_places(File& file, const char* dataset, const std::vector<std::vector<double>>& place,
                  const char* meaning) {
  std::vector<double> rows(place.size() * coordinates, absent);
  for (std::size_t i = 0; i < place.size(); ++i)
    std::copy_n(place[i].begin(), std::min(place[i].size(), coordinates),
                rows.begin() + static_cast<std::ptrdiff_t>(i * coordinates));
  file.write(dataset, {place.size(), coordinates}, rows, "m", meaning);
}

std::vector<std::vector<double>> read_places(const File& file, const char* dataset,
                                             std::size_t count) {
  const auto rows = file.read_reals(dataset, count * coordinates);
  std::vector<std::vector<double>> place(count);
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (std::isfinite(rows[i])) place[i / coordinates].push_back(rows[i]);
  return place;
}

void write_worst(File& file, const std::vector<Finding>& findings) {
  std::vector<double> time, value;
  std::vector<std::vector<double>> place;
  for (const Finding& finding : findings) {
    const Exceedance worst = finding.worst.value_or(Exceedance{absent, absent, {}});
    time.push_back(worst.time);
    value.push_back(worst.value);
    place.push_back(worst.place);
  }
  file.write("/findings/worst_time_s", time, "s",
             "of the figure farthest beyond the limit; NaN if there is none");
  file.write("/findings/worst_value", value, "1", "in the unit of the finding");
  write_places(file, "/findings/worst_place_m", place, "as place_m");
}

/// Reads the figure farthest beyond the limit.
void read_worst(const File& file, std::vector<Finding>& findings) {
  const auto time = file.read_reals("/findings/worst_time_s", findings.size());
  const auto value = file.read_reals("/findings/worst_value", findings.size());
  const auto place = read_places(file, "/findings/worst_place_m", findings.size());

  for (std::size_t i = 0; i < findings.size(); ++i)
    if (std::isfinite(value[i])) findings[i].worst = Exceedance{time[i], value[i], place[i]};
}

std::string certainty_text(const Finding& finding) {
  return finding.certainty ? name_of(*finding.certainty) : "";
}

std::optional<Certainty> parse_certainty(const std::string& name) {
  for (const Certainty each : {Certainty::open, Certainty::likely, Certainty::sure})
    if (name == name_of(each)) return each;
  return std::nullopt;
}

Severity parse_severity(const File& file, const std::string& name) {
  const auto found = std::ranges::find(severities, name, [](Severity s) { return name_of(s); });
  if (found == severities.end())
    throw storage::StorageError(EINVAL, fmt::format("{}:/findings/severity", file.path().string()),
                                fmt::format("unknown severity \"{}\"", name));
  return *found;
}

}  // namespace

void write_findings(File& file, const std::vector<Finding>& findings) {
  if (findings.empty()) return;

  file.create_group("/findings");
  for (const TextField& field : texts)
    file.write_texts(field.dataset,
                     collect_texts(findings, [&](const Finding& f) { return f.*field.member; }),
                     field.meaning);
  file.write_texts("/findings/severity",
                   collect_texts(findings, [](const Finding& f) { return name_of(f.severity); }),
                   "note, warning or danger");
  file.write_texts("/findings/certainty", collect_texts(findings, certainty_text),
                   "open, likely or sure; empty: no error was measured");

  // A number that a finding does not have is NaN in the file.
  for (const RealField& field : reals) {
    std::vector<double> values;
    for (const Finding& f : findings) values.push_back((f.*field.member).value_or(absent));
    file.write(field.dataset, values, field.unit, field.meaning);
  }

  std::vector<std::vector<double>> place;
  for (const Finding& finding : findings) place.push_back(finding.place);
  write_places(file, "/findings/place_m", place,
               "in the undeformed slab, in 2D two coordinates; NaN if there is no place");
  write_worst(file, findings);
}

std::vector<Finding> read_findings(const File& file) {
  if (!file.has("/findings")) return {};
  const auto severity = file.read_texts("/findings/severity");
  std::vector<Finding> findings(severity.size());
  for (std::size_t i = 0; i < findings.size(); ++i)
    findings[i].severity = parse_severity(file, severity[i]);

  for (const TextField& field : texts) {
    const auto values = file.read_texts(field.dataset, findings.size());
    for (std::size_t i = 0; i < findings.size(); ++i) findings[i].*field.member = values[i];
  }

  const auto certainty = file.read_texts("/findings/certainty", findings.size());
  for (std::size_t i = 0; i < findings.size(); ++i)
    findings[i].certainty = parse_certainty(certainty[i]);

  // NaN marks a number that the finding does not have.
  for (const RealField& field : reals) {
    const auto values = file.read_reals(field.dataset, findings.size());
    for (std::size_t i = 0; i < findings.size(); ++i)
      if (std::isfinite(values[i])) findings[i].*field.member = values[i];
  }

  const auto place = read_places(file, "/findings/place_m", findings.size());
  for (std::size_t i = 0; i < findings.size(); ++i) findings[i].place = place[i];
  read_worst(file, findings);
  return findings;
}

void write_margins(File& file, const std::vector<Margin>& margins) {
  if (margins.empty()) return;
  std::vector<std::string> code, key, unit;
  std::vector<double> value, limit, time;
  std::vector<std::vector<double>> place;
  for (const Margin& margin : margins) {
    code.push_back(margin.code);
    key.push_back(margin.key);
    unit.push_back(margin.unit);
    value.push_back(margin.worst.value);
    limit.push_back(margin.limit);
    time.push_back(margin.worst.time);
    place.push_back(margin.worst.place);
  }

  file.create_group("/margins");
  file.write_texts("/margins/code", code, "of the finding whose limit it is");
  file.write_texts("/margins/key", key, "key of the case that sets the limit");
  file.write_texts("/margins/unit", unit, "of value and limit");
  file.write("/margins/value", value, "1", "nearest to the limit or farthest beyond it");
  file.write("/margins/limit", limit, "1", "at that time");
  file.write("/margins/time_s", time, "s", "of the value");
  write_places(file, "/margins/place_m", place, "as that of a finding");
}

}  // namespace dccast::results
