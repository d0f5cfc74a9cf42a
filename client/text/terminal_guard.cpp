#include "client/text/terminal_guard.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <utility>

#include "proto/values/printable.hpp"

namespace dccast::client {
namespace {

// Bold, the colours of lines, and their end. They change the appearance of a text and hide nothing.
constexpr std::array<std::string_view, 8> permitted{"\033[0m",  "\033[1m",  "\033[31m", "\033[32m",
                                                    "\033[33m", "\033[34m", "\033[35m", "\033[36m"};
constexpr std::string_view line_end = "\r\n";

/// Length of the permitted sequence at the beginning of the text; 0 if there is none.
std::size_t permitted_length(std::string_view text) {
  if (text.starts_with(line_end)) return line_end.size();
  const auto found = std::ranges::find_if(
      permitted, [&](std::string_view each) { return text.starts_with(each); });
  return found == permitted.end() ? 0 : found->size();
}

/// Number of bytes at the end of the text that begin, but do not complete, a UTF-8 character or a
/// line end.
std::size_t begun_length(std::string_view text) {
  if (text.ends_with('\r')) return 1;
  constexpr std::size_t longest = 4;

  for (std::size_t length = 1; length < longest && length <= text.size(); ++length) {
    const auto byte = static_cast<unsigned char>(text[text.size() - length]);
    const bool continues = (byte & 0xC0) == 0x80;
    if (continues) continue;
    const std::size_t whole = byte >= 0xF0 ? 4 : byte >= 0xE0 ? 3 : byte >= 0xC0 ? 2 : 1;
    return length < whole ? length : 0;
  }
  return 0;
}

}  // namespace

std::string for_terminal(std::string_view text) {
  std::string shown;
  while (!text.empty()) {
    std::size_t length = permitted_length(text);
    if (length > 0) {
      shown += text.substr(0, length);
    } else {
      length = std::min(text.find_first_of("\r\033", 1), text.size());
      shown += values::escaped(text.substr(0, length), values::Lines::several);
    }
    text.remove_prefix(length);
  }
  return shown;
}

TerminalGuard::TerminalGuard(std::ostream& stream, int descriptor)
    : stream_(stream), terminal_(stream.rdbuf()), guards_(::isatty(descriptor) == 1) {
  stream_.rdbuf(this);
}

TerminalGuard::~TerminalGuard() {
  sync();
  stream_.rdbuf(terminal_);
}

bool TerminalGuard::write(std::string_view text) {
  const auto size = static_cast<std::streamsize>(text.size());
  return terminal_->sputn(text.data(), size) == size;
}

void TerminalGuard::write_control(std::string_view sequence) {
  const std::lock_guard lock(mutex_);
  write(sequence);
}

std::streamsize TerminalGuard::xsputn(const char* text, std::streamsize size) {
  const std::lock_guard lock(mutex_);
  const std::string_view given(text, static_cast<std::size_t>(size));
  if (!guards_) return write(given) ? size : 0;

  std::string whole = std::move(begun_);
  whole += given;
  begun_ = whole.substr(whole.size() - begun_length(whole));
  whole.resize(whole.size() - begun_.size());
  return write(for_terminal(whole)) ? size : 0;
}

TerminalGuard::int_type TerminalGuard::overflow(int_type character) {
  if (traits_type::eq_int_type(character, traits_type::eof()))
    return traits_type::not_eof(character);
  const char byte = traits_type::to_char_type(character);
  return xsputn(&byte, 1) == 1 ? character : traits_type::eof();
}

int TerminalGuard::sync() {
  const std::lock_guard lock(mutex_);
  const std::string rest = std::exchange(begun_, {});
  const bool written = rest.empty() || write(for_terminal(rest));
  return written ? terminal_->pubsync() : -1;
}

std::ostream& operator<<(std::ostream& stream, Control control) {
  // Appends to what has been written so far: neither stream nor guard buffers a whole text.
  if (auto* const guard = dynamic_cast<TerminalGuard*>(stream.rdbuf()))
    guard->write_control(control.sequence);
  else
    stream << control.sequence;
  return stream;
}

}  // namespace dccast::client
