// Live view of the server, refreshed until the user quits.
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <ctime>
#include <iostream>

#include "client/commands/commands.hpp"
#include "client/session/jobs.hpp"
#include "client/text/terminal.hpp"
#include "client/text/terminal_guard.hpp"
#include "client/text/top_page.hpp"

namespace dccast::client {
namespace {

struct TopOptions {
  bool once = false;
  int interval_s = 1;
};

/// Switches to the alternate screen, without cursor and echo; the destructor restores the terminal.
class FullScreen {
public:
  FullScreen() : keys_(::isatty(STDIN_FILENO) == 1 && ::tcgetattr(STDIN_FILENO, &before_) == 0) {
    if (keys_) {
      termios now = before_;
      now.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
      ::tcsetattr(STDIN_FILENO, TCSANOW, &now);
    }
    write("\033[?1049h\033[?25l");
  }
  FullScreen(const FullScreen&) = delete;
  ~FullScreen() {
    write("\033[?25h\033[?1049l");
    if (keys_) ::tcsetattr(STDIN_FILENO, TCSANOW, &before_);
  }
  void show(const std::string& page) const {
    std::string text = "\033[H";
    for (const char c : for_terminal(page))
      text += c == '\n' ? std::string("\033[K\n") : std::string(1, c);
    write(text + "\033[J");
  }
  bool reads_keys() const { return keys_; }

private:
  /// Does not use std::cout, which throws if the terminal has gone.
  static void write(const std::string& text) {
    [[maybe_unused]] const auto written = ::write(STDOUT_FILENO, text.data(), text.size());
  }

  termios before_{};
  const bool keys_;
};

int terminal_lines() {
  winsize size{};
  constexpr int usual = 24;
  return ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 2 ? size.ws_row : usual;
}

std::string page_now(Connection& connection, int columns, int lines) {
  constexpr int most = 1000;
  TopView view{.server = connection.server()};
  view.about = connection.call(&Stub::GetServerInfo, v1::GetServerInfoRequest());
  v1::ListJobsRequest request;
  request.add_states(v1::RUNNING);
  view.running = list_jobs(connection, request, most).jobs;
  request.set_states(0, v1::QUEUED);
  view.queued = list_jobs(connection, request, most).jobs;
  return top_page(view, columns, lines, std::time(nullptr));
}

/// @return whether the user quits
bool wait_for_key(Connection& connection, bool keys, int seconds) {
  constexpr int tick_ms = 100;
  for (int waited = 0; waited < 1000 * seconds; waited += tick_ms) {
    // Standard input that is no terminal belongs to someone else: only Ctrl-C ends the view.
    if (!keys) {
      connection.interruption().sleep(std::chrono::milliseconds(tick_ms));
      continue;
    }
    if (connection.interruption().came()) throw Interrupted("");
    pollfd key{STDIN_FILENO, POLLIN, 0};
    char pressed = 0;
    if (::poll(&key, 1, tick_ms) == 1 &&
        (::read(STDIN_FILENO, &pressed, 1) != 1 || pressed == 'q' || pressed == 'Q'))
      return true;
  }
  return false;
}

ExitCode run(const TopOptions& options, Program& program) {
  Connection connection = program.connect();
  const Terminal terminal = terminal_of(STDOUT_FILENO);

  if (options.once || !terminal.interactive) {
    std::cout << page_now(connection,
                          options.once && terminal.interactive ? terminal.columns : 1000, 0)
              << std::flush;
    return ExitCode::done;
  }

  std::string page = page_now(connection, columns_now(terminal), terminal_lines() - 1);
  const FullScreen screen;
  try {
    for (;;) {
      screen.show(page);
      if (wait_for_key(connection, screen.reads_keys(), options.interval_s)) break;
      page = page_now(connection, columns_now(terminal), terminal_lines() - 1);
    }
  } catch (const Interrupted&) {  // Ctrl-C is one way to leave
  }
  return ExitCode::done;
}

}  // namespace

void add_top(CommandLine& line, Program& program) {
  const auto [command, options] = declare<TopOptions>(
      line, program, run, "top",
      "Live view of running jobs, the queue by owner and the workers; q or Ctrl-C quits",
      "dccast top\n  dccast top --once");
  command.flag("--once", options.once,
               "Print the page once, as is done when output is not a terminal");
  command.number("-n,--interval", options.interval_s, 1, 3600, "Seconds between two pages");
}

}  // namespace dccast::client
