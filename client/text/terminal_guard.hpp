#pragma once

#include <mutex>
#include <ostream>
#include <streambuf>
#include <string>
#include <string_view>

namespace dccast::client {

/// The text as a terminal may be given it: characters that would act on it are written out
/// (`\u{1B}`), besides line ends, tabs and the colours of this program.
std::string for_terminal(std::string_view text);

/// Stands between a stream and its terminal, as texts of case files, of other machines and of their
/// servers come to a screen in many places: everything goes through for_terminal(). Nothing is
/// changed where the stream is no terminal, so that files get each byte. Threads may write through
/// it at the same time: each text that a stream hands on in one piece comes out in one piece.
class TerminalGuard : public std::streambuf {
public:
  /// Guards the stream as long as this lives. @param descriptor  what it writes to
  TerminalGuard(std::ostream& stream, int descriptor);
  ~TerminalGuard() override;
  TerminalGuard(const TerminalGuard&) = delete;

  /// Writes what shall act on the terminal.
  void write_control(std::string_view sequence);

protected:
  /// Overrides of std::streambuf, which write by for_terminal().
  std::streamsize xsputn(const char* text, std::streamsize size) override;
  int_type overflow(int_type character) override;
  int sync() override;

private:
  /// Writes guarded text. @return false if the stream cannot be written
  bool write(std::string_view text);

  std::ostream& stream_;
  std::streambuf* const terminal_;
  const bool guards_;
  std::mutex mutex_;   // of what is written, and of the rest below
  std::string begun_;  // of a character whose other bytes come with the next text
};

/// A sequence of this program that acts on the terminal, such as that which begins its line anew.
struct Control {
  /// A sequence that the program itself sends to the terminal.
  std::string_view sequence;
};
inline constexpr Control begin_of_line{"\r"};
inline constexpr Control clear_rest_of_line{"\033[K"};
std::ostream& operator<<(std::ostream& stream, Control control);

}  // namespace dccast::client
