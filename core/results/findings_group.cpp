#include "core/results/findings_group.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <limits>

#include "core/hdf5/hdf5_file.hpp"
#include "core/storage/storage_error.hpp"

namespace dccast::results {

namespace {

using hdf5::File;

constexpr double absent = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t coordinates = 3;
constexpr std::array severities{Severity::note, Severity::warning, Severity::danger};

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

struct RealField {
  const char* dataset;
  const char* unit;  ///< that of the finding where it is 1
  const char* meaning;
  std::optional<double> Finding::*member;
};
constexpr std::array reals{
    RealField{"/findings/time_s", "s", "when first found; NaN: follows from the case alone",
              &Finding::time},
    RealField{"/findings/value", "1", "in the unit of the finding", &Finding::value},
    RealField{"/findings/limit", "1", "in the unit of the finding", &Finding::limit},
};

/// A column of a text for each finding.
template <class TextOf>
std::vector<std::string> column(const std::vector<Finding>& findings, TextOf&& text_of) {
  std::vector<std::string> values;
  for (const Finding& finding : findings) values.emplace_back(text_of(finding));
  return values;
}

/// Places of the undeformed slab as rows of three coordinates.
void write_places(File& file, const char* dataset, const std::vector<std::vector<double>>& place,
                  const char* meaning) {
  std::vector<double> rows(place.size() * coordinates, absent);
  for (std::size_t i = 0; i < place.size(); ++i)
    std::copy_n(place[i].begin(), std::min(place[i].size(), coordinates),
                rows.begin() + static_cast<std::ptrdiff_t>(i * coordinates));
  file.write(dataset, {place.size(), coordinates}, rows.data(), "m", meaning);
}

std::vector<std::vector<double>> read_places(const File& file, const char* dataset,
                                             std::size_t count) {
  const auto rows = file.read_reals(dataset);
  std::vector<std::vector<double>> place(count);
  for (std::size_t i = 0; i < count * coordinates; ++i)
    if (std::isfinite(rows.at(i))) place[i / coordinates].push_back(rows[i]);
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
  file.write("/findings/worst_time_s", {time.size()}, time.data(), "s",
             "of the figure farthest beyond the limit; NaN if there is none");
  file.write("/findings/worst_value", {value.size()}, value.data(), "1",
             "in the unit of the finding");
  write_places(file, "/findings/worst_place_m", place, "as place_m");
}

/// Files of programs that did not know it have none.
void read_worst(const File& file, std::vector<Finding>& findings) {
  if (!file.has("/findings/worst_value")) return;
  const auto time = file.read_reals("/findings/worst_time_s");
  const auto value = file.read_reals("/findings/worst_value");
  const auto place = read_places(file, "/findings/worst_place_m", findings.size());
  for (std::size_t i = 0; i < findings.size(); ++i)
    if (std::isfinite(value.at(i))) findings[i].worst = Exceedance{time.at(i), value[i], place[i]};
}

Severity severity_named(const File& file, const std::string& name) {
  const auto found = std::ranges::find(severities, name, [](Severity s) { return name_of(s); });
  if (found == severities.end())
    throw storage::StorageError(EINVAL, file.path().string() + ":/findings/severity",
                                "names " + name);
  return *found;
}

}  // namespace

void write_findings(File& file, const std::vector<Finding>& findings) {
  if (findings.empty()) return;
  file.create_group("/findings");
  for (const TextField& field : texts)
    file.write_texts(field.dataset,
                     column(findings, [&](const Finding& f) { return f.*field.member; }),
                     field.meaning);
  file.write_texts("/findings/severity",
                   column(findings, [](const Finding& f) { return name_of(f.severity); }),
                   "note, warning or danger");
  for (const RealField& field : reals) {
    std::vector<double> values;
    for (const Finding& f : findings) values.push_back((f.*field.member).value_or(absent));
    file.write(field.dataset, {values.size()}, values.data(), field.unit, field.meaning);
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
    findings[i].severity = severity_named(file, severity[i]);
  for (const TextField& field : texts) {
    const auto values = file.read_texts(field.dataset);
    for (std::size_t i = 0; i < findings.size(); ++i) findings[i].*field.member = values.at(i);
  }
  for (const RealField& field : reals) {
    const auto values = file.read_reals(field.dataset);
    for (std::size_t i = 0; i < findings.size(); ++i)
      if (std::isfinite(values.at(i))) findings[i].*field.member = values[i];
  }
  const auto place = read_places(file, "/findings/place_m", findings.size());
  for (std::size_t i = 0; i < findings.size(); ++i) findings[i].place = place[i];
  read_worst(file, findings);
  return findings;
}

}  // namespace dccast::results
