#include "proto/values/times.hpp"

#include <array>
#include <cstdio>
#include <ctime>
#include <string_view>
#include <utility>

namespace dccast::values {

namespace {

using Time = std::optional<std::int64_t>;

constexpr std::int64_t minute_s = 60, hour_s = 3600, day_s = 24 * hour_s;

std::tm local_day(std::int64_t now) {
  const std::time_t seconds = now;
  std::tm day{};
  ::localtime_r(&seconds, &day);
  day.tm_hour = day.tm_min = day.tm_sec = 0;
  return day;
}

std::int64_t seconds_of(std::tm time) {
  // mktime() finds out whether summer time holds then.
  time.tm_isdst = -1;
  return std::mktime(&time);
}

/// Fails for a 31st of June, which mktime() would take for the first of July.
Time checked_seconds(const std::tm& time, bool utc) {
  std::tm normal = time;
  normal.tm_isdst = -1;
  const std::int64_t seconds = utc ? ::timegm(&normal) : std::mktime(&normal);
  const bool exists = normal.tm_mday == time.tm_mday && normal.tm_mon == time.tm_mon;
  return exists ? Time(seconds) : std::nullopt;
}

/// "2026-11-20", with "08", "08:15" or "08:15:30" after a blank or "T", and perhaps a "Z".
Time parse_date(const std::string& text) {
  for (const char* form : {"%Y-%m-%d", "%Y-%m-%d %H", "%Y-%m-%dT%H", "%Y-%m-%d %H:%M",
                           "%Y-%m-%dT%H:%M", "%Y-%m-%d %H:%M:%S", "%Y-%m-%dT%H:%M:%S"}) {
    std::tm time{};
    const char* const end = ::strptime(text.c_str(), form, &time);
    if (end == nullptr || (*end != '\0' && std::string_view(end) != "Z")) continue;
    const bool has_four_digits = text.find('-') == 4;
    return has_four_digits ? checked_seconds(time, *end == 'Z') : std::nullopt;
  }
  return std::nullopt;
}

Time parse_calendar(const std::string& text, std::int64_t now) {
  constexpr std::array<std::pair<std::string_view, int>, 3> days{
      {{"yesterday", -1}, {"today", 0}, {"tomorrow", 1}}};
  for (const auto& [name, from_today] : days) {
    if (text != name) continue;
    std::tm day = local_day(now);
    day.tm_mday += from_today;
    return seconds_of(day);
  }
  return parse_date(text);
}

/// "30 min", "3 h", "2 d", "1 w" [s].
Time parse_span(const std::string& text) {
  constexpr std::array<std::pair<std::string_view, std::int64_t>, 4> units{
      {{"min", minute_s}, {"h", hour_s}, {"d", day_s}, {"w", 7 * day_s}}};
  int number = 0, end = 0;
  if (std::sscanf(text.c_str(), "%6d %n", &number, &end) != 1 || number < 0) return std::nullopt;
  for (const auto& [name, seconds] : units)
    if (text.substr(static_cast<std::size_t>(end)) == name) return number * seconds;
  return std::nullopt;
}

/// "22:00": the next one.
Time parse_time_of_day(const std::string& text, std::int64_t now) {
  std::tm of_day{};
  const char* const end = ::strptime(text.c_str(), "%H:%M", &of_day);
  if (end == nullptr || *end != '\0') return std::nullopt;

  std::tm time = local_day(now);
  time.tm_hour = of_day.tm_hour;
  time.tm_min = of_day.tm_min;
  if (const std::int64_t today = seconds_of(time); today > now) return today;
  ++time.tm_mday;
  return seconds_of(time);
}

}  // namespace

Time past_time(const std::string& text, std::int64_t now) {
  if (const Time time = parse_calendar(text, now)) return time;
  const Time span = parse_span(text);
  return span ? Time(now - *span) : std::nullopt;
}

Time coming_time(const std::string& text, std::int64_t now) {
  if (const Time time = parse_calendar(text, now)) return time;
  if (const Time time = parse_time_of_day(text, now)) return time;
  const Time span = parse_span(text);
  return span ? Time(now + *span) : std::nullopt;
}

}  // namespace dccast::values
