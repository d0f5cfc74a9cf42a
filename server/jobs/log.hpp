#pragma once

#include <fmt/core.h>

/// The daemon's log, one line an event: line ends and other control characters in a text are
/// written out, so that no title makes a line of its own. Only log.cpp includes the library's own
/// header, which takes seconds to compile.
namespace dccast::log {

enum class Format {
  text,
  json,     ///< an object with time, level and message
  journal,  ///< the level as systemd's journal takes it ("<6>"), which adds the time
};
/// Before threads write.
void set_format(Format format);

enum class Level { debug = 1, info, warning, error, critical };  // numbers of spdlog's levels

void write(Level level, fmt::string_view format, fmt::format_args arguments);

template <typename... Arguments>
void debug(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  write(Level::debug, format, fmt::make_format_args(arguments...));
}
template <typename... Arguments>
void info(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  write(Level::info, format, fmt::make_format_args(arguments...));
}
template <typename... Arguments>
void warn(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  write(Level::warning, format, fmt::make_format_args(arguments...));
}
template <typename... Arguments>
void error(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  write(Level::error, format, fmt::make_format_args(arguments...));
}
template <typename... Arguments>
void critical(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  write(Level::critical, format, fmt::make_format_args(arguments...));
}

}  // namespace dccast::log
