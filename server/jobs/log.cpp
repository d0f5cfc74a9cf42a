#include "server/jobs/log.hpp"

#include <spdlog/spdlog.h>

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

#include "proto/values/printable.hpp"

namespace dccast::log {

static_assert(static_cast<int>(Level::debug) == ::spdlog::level::debug);
static_assert(static_cast<int>(Level::critical) == ::spdlog::level::critical);

namespace {

Format format_of_lines = Format::text;

/// Severities of syslog(3), by level; none has 0.
constexpr std::array severities{6, 7, 6, 4, 3, 2};

/// Of "job {}: ..." the first argument as a field, of other formats nothing.
std::string subject_field(std::string_view format, fmt::format_args arguments) {
  for (const std::string_view name : {"job", "study"})
    if (format.starts_with(fmt::format("{} {{}}", name)))
      return fmt::format(R"("{}":"{}",)", name,
                         values::escaped_in_quotes(fmt::vformat("{}", arguments)));
  return {};
}

std::string line_of(Level level, fmt::string_view format, fmt::format_args arguments) {
  const std::string message = fmt::vformat(format, arguments);
  if (format_of_lines == Format::json)
    return fmt::format(R"({}"message":"{}")",
                       subject_field({format.data(), format.size()}, arguments),
                       values::escaped_in_quotes(message));
  std::string printable = values::escaped(message);
  if (format_of_lines == Format::journal)
    return fmt::format("<{}>{}", severities[static_cast<std::size_t>(level)], printable);
  return printable;
}

}  // namespace

void set_format(Format format) {
  format_of_lines = format;
  const char* pattern = format == Format::json
                            ? R"({"time":"%Y-%m-%dT%H:%M:%S.%eZ","level":"%l",%v})"
                        : format == Format::journal ? "%v"
                                                    : "%+";
  ::spdlog::set_pattern(pattern, format == Format::json ? ::spdlog::pattern_time_type::utc
                                                        : ::spdlog::pattern_time_type::local);
}

void write(Level level, fmt::string_view format, fmt::format_args arguments) {
  const auto native = static_cast<::spdlog::level::level_enum>(level);
  ::spdlog::logger& logger = *::spdlog::default_logger_raw();
  if (logger.should_log(native))
    logger.log(native, ::spdlog::string_view_t(line_of(level, format, arguments)));
}

}  // namespace dccast::log
