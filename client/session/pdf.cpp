#include "client/session/pdf.hpp"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>
#include <vector>

#include "client/session/failure.hpp"

extern char** environ;

namespace dccast::client {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds longest{60};

/// A folder of its own, removed with what is in it.
class TemporaryFolder {
public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "dccast-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
      throw CommandFailed(ExitCode::not_found, "cannot make a folder in " + name);
    path = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code error;
    fs::remove_all(path, error);
  }
  fs::path path;
};

/// A program of the PATH; empty if there is none of these names.
fs::path program_named(const std::vector<std::string>& names) {
  const char* const path = std::getenv("PATH");
  for (const std::string& name : names) {
    std::istringstream folders(path == nullptr ? "" : path);
    for (std::string folder; std::getline(folders, folder, ':');)
      if (const fs::path file = fs::path(folder) / name; ::access(file.c_str(), X_OK) == 0)
        return file;
  }
  return {};
}

/// Runs a program in silence and ends it, with what it started, after the longest time.
void run(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  for (const int descriptor : {0, 1, 2})
    posix_spawn_file_actions_addopen(&files, descriptor, "/dev/null", O_RDWR, 0);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK);
  pid_t process = 0;
  const int error =
      ::posix_spawn(&process, arguments[0], &files, &attributes, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) return;
  const auto end = std::chrono::steady_clock::now() + longest;
  while (::waitpid(process, nullptr, WNOHANG) == 0) {
    if (std::chrono::steady_clock::now() > end) {
      ::kill(-process, SIGKILL);
      ::waitpid(process, nullptr, 0);
      return;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

bool is_pdf(const fs::path& file) {
  std::string begin(4, ' ');
  std::ifstream stream(file, std::ios::binary);
  return stream.read(begin.data(), 4) && begin == "%PDF";
}

}  // namespace

void print_pdf(const std::string& page, const fs::path& file) {
  const fs::path browser = program_named({"chromium", "chromium-browser", "google-chrome"});
  if (browser.empty())
    throw CommandFailed(ExitCode::invalid,
                        file.string() +
                            ": a PDF is printed by Chromium, which is not installed "
                            "here; give a name that ends with .html");
  const TemporaryFolder folder;
  const fs::path html = folder.path / "page.html", pdf = folder.path / "page.pdf";
  std::ofstream(html, std::ios::binary) << page;
  std::vector<std::string> words{browser.string(),
                                 "--headless",
                                 "--disable-gpu",
                                 "--no-pdf-header-footer",
                                 "--user-data-dir=" + (folder.path / "profile").string(),
                                 "--print-to-pdf=" + pdf.string(),
                                 "file://" + html.string()};
  if (::geteuid() == 0) words.insert(words.begin() + 1, "--no-sandbox");  // it refuses root
  run(std::move(words));
  if (!is_pdf(pdf))
    throw CommandFailed(ExitCode::not_found,
                        browser.string() + " printed no PDF; give a name that ends with .html");
  std::error_code error;
  fs::copy_file(pdf, file, fs::copy_options::overwrite_existing, error);
  if (error)
    throw CommandFailed(ExitCode::not_found,
                        "cannot write " + file.string() + ": " + error.message());
}

}  // namespace dccast::client
