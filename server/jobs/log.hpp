#pragma once

#include <fmt/core.h>

/// The daemon's log, one line an event: line ends and other control characters in a text are
/// written out, so that no title makes a line of its own. Only log.cpp includes the library's own
/// header, which takes seconds to compile.
namespace dccast::log {

enum class Format {
  text,
  json,     ///< an object with time, level, message, and job or study of "job {}: ..."
  journal,  ///< the level as systemd's journal takes it ("<6>"), which adds the time
};
/// Before threads write.
void set_format(Format format);

enum class Level { debug = 1, info, warning, error, critical };  // numbers of spdlog's levels

void write(Level level, fmt::string_view format, fmt::format_args arguments);

/// E.g. log::info("job {}: {}", id, text).
template <Level level>
inline constexpr auto write_at =
    []<typename... Arguments>(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
      write(level, format, fmt::make_format_args(arguments...));
    };
inline constexpr auto debug = write_at<Level::debug>;
inline constexpr auto info = write_at<Level::info>;
inline constexpr auto warn = write_at<Level::warning>;
inline constexpr auto error = write_at<Level::error>;
inline constexpr auto critical = write_at<Level::critical>;

}  // namespace dccast::log
