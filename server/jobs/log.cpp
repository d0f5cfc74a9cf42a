#include "server/jobs/log.hpp"

#include <spdlog/spdlog.h>

namespace dccast::log {

static_assert(static_cast<int>(Level::debug) == ::spdlog::level::debug);
static_assert(static_cast<int>(Level::critical) == ::spdlog::level::critical);

void write(Level level, fmt::string_view format, fmt::format_args arguments) {
  const auto native = static_cast<::spdlog::level::level_enum>(level);
  ::spdlog::logger& logger = *::spdlog::default_logger_raw();
  if (logger.should_log(native))
    logger.log(native, ::spdlog::string_view_t(fmt::vformat(format, arguments)));
}

}  // namespace dccast::log
