#include "client/text/terminal_guard.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

#include <sstream>
#include <string>
#include <thread>

namespace dccast::client {
namespace {

TEST(TerminalGuard, WritesOutWhatWouldActOnTheTerminal) {
  EXPECT_EQ(for_terminal("a\x1b]0;title\a b\x1b[2J\x1b[1A\x1b[8mhidden"),
            "a\\u{1B}]0;title\\u{7} b\\u{1B}[2J\\u{1B}[1A\\u{1B}[8mhidden");
  EXPECT_EQ(for_terminal("\xC2\x9B"
                         "2J \xE2\x80\xAE \xFF"),
            "\\u{9B}2J \\u{202E} \\x{FF}");
  EXPECT_EQ(for_terminal("over\rwritten"), "over\\u{D}written");
}

TEST(TerminalGuard, LeavesTextAndTheColoursOfTheProgram) {
  const std::string text = "\033[1mbold\033[0m \033[34mline\033[0m\tmm² ≤ 3\nnext\r\nlast";
  EXPECT_EQ(for_terminal(text), text);
}

/// A stream to both ends of a terminal.
class Screen {
public:
  Screen() { EXPECT_EQ(::openpty(&reader_, &terminal_, nullptr, nullptr, nullptr), 0); }
  ~Screen() {
    ::close(reader_);
    ::close(terminal_);
  }
  int descriptor() const { return terminal_; }

private:
  int reader_ = -1, terminal_ = -1;
};

TEST(TerminalGuard, GuardsAStreamToATerminalUntilItsEnd) {
  const Screen screen;
  std::ostringstream stream;
  {
    const TerminalGuard guard(stream, screen.descriptor());
    stream << "a\x1b[2J" << clear_rest_of_line << 'b' << '\x1b' << std::flush << begin_of_line;
  }
  stream << "\x1b";
  EXPECT_EQ(stream.str(), "a\\u{1B}[2J\033[Kb\\u{1B}\r\x1b");
}

TEST(TerminalGuard, TakesCharactersThatComeInParts) {
  const Screen screen;
  std::ostringstream stream;
  {
    const TerminalGuard guard(stream, screen.descriptor());
    for (const char byte : std::string("mm² ≤ 𝛼\r\n\r")) stream << byte;
    stream << "≤";
    stream << '\xE2' << std::flush << '\xC2';
  }
  EXPECT_EQ(stream.str(), "mm² ≤ 𝛼\r\n\\u{D}≤\\x{E2}\\x{C2}");
}

TEST(TerminalGuard, ChangesNothingInAFile) {
  const int file = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  std::ostringstream stream;
  {
    const TerminalGuard guard(stream, file);
    stream << "a\x1b[2J\r" << '\xE2' << begin_of_line;
  }
  ::close(file);
  EXPECT_EQ(stream.str(), "a\x1b[2J\r\xE2\r");
}

// The sender of readings reports what it left out while the watch of its job prints steps.
TEST(TerminalGuard, IsSharedByThreads) {
  constexpr int lines = 50000;
  std::ostringstream out;
  TerminalGuard guard(out, STDERR_FILENO);
  const auto write = [&guard](char letter) {
    std::string line(40, letter);
    line.back() = '\n';
    for (int i = 0; i < lines; ++i) {
      guard.sputn(line.data(), static_cast<std::streamsize>(line.size()));
      guard.pubsync();
    }
  };
  std::jthread other(write, 'b');
  write('a');
  other.join();

  std::istringstream written(out.str());
  int whole = 0;
  for (std::string line; std::getline(written, line);)
    whole += line == std::string(39, line.front()) ? 1 : 0;
  EXPECT_EQ(whole, 2 * lines);
}

}  // namespace
}  // namespace dccast::client
