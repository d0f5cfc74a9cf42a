#pragma once

#include <cstdint>
#include <optional>
#include <string>

/// Times as people give them, in seconds since 1970. Without a "Z" they are local times of this
/// machine. A calendar time is today, yesterday, tomorrow, 2026-11-20, "2026-11-20 08:15" or
/// 2026-11-20T08:15:30Z; a span is "30 min", "3 h", "2 d" or "1 w".
namespace dccast::values {

/// A calendar time, or a span before `now`; empty for any other text.
std::optional<std::int64_t> past_time(const std::string& text, std::int64_t now);
/// A calendar time, a time of day, which is the next one ("22:00"), or a span after `now`; empty
/// for any other text.
std::optional<std::int64_t> coming_time(const std::string& text, std::int64_t now);

/// What past_time() and coming_time() take, for messages.
inline constexpr const char* past_times =
    "today, yesterday, \"3 h\", \"2 d\", \"1 w\", 2026-11-20 or \"2026-11-20 08:15\"";
inline constexpr const char* coming_times =
    "22:00, \"tomorrow\", \"30 min\", \"3 h\", \"2 d\", 2026-11-20 or \"2026-11-20 08:15\"";

}  // namespace dccast::values
