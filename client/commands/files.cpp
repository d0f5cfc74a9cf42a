#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <sstream>
#include <thread>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/html/pages.hpp"
#include "client/session/download.hpp"
#include "client/session/jobs.hpp"

namespace dccast::client {
namespace {

namespace fs = std::filesystem;

struct FetchOptions {
  std::string id;
  std::string output = "results.h5";
  bool force = false;
  bool json = false;
};

std::string xml_escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += c == '&' ? "&amp;" : c == '<' ? "&lt;" : std::string(1, c);
  return escaped;
}

/// The sidecar names its HDF5 file without a folder, so that both can move together; the file may
/// have been fetched under another name.
void point_sidecar_at(const fs::path& sidecar, const fs::path& results) {
  std::ifstream stream(sidecar, std::ios::binary);
  std::string text(std::istreambuf_iterator<char>(stream), {});
  const std::string named = "results.h5:";
  const std::string name = xml_escaped(results.filename().string()) + ":";
  for (auto at = text.find(named); at != std::string::npos; at = text.find(named, at + name.size()))
    text.replace(at, named.size(), name);
  stream.close();
  write_file(sidecar, text);
}

/// Whether a sidecar can name a file: "results.h5:/mesh" is a file and a place in it.
bool fits_sidecar(const std::string& name) {
  const auto is_unfit = [](unsigned char c) { return c == ':' || c < 0x20 || c == 0x7F; };
  return std::ranges::none_of(name, is_unfit) && !name.starts_with(' ') && !name.ends_with(' ');
}

/// Destination of the results: a file, or results.h5 in a folder.
fs::path target_of(const std::string& output) {
  const auto refuse = [&](const std::string& why) {
    throw invalid("-o \"" + output + "\": " + why);
  };
  std::error_code error;
  if (output.empty()) refuse("give a file or a folder");
  if (output == "-") refuse("results are two files, which standard output cannot hold");
  const fs::path given = output;
  if (fs::is_directory(given, error)) return given / "results.h5";
  if (fs::exists(given, error) && !fs::is_regular_file(given, error))
    refuse("not a regular file; results would overwrite it");
  if (given.extension() == ".xdmf")
    refuse("the .xdmf is written beside it; give the name of the HDF5 file");
  if (const std::string name = given.filename().string(); !fits_sidecar(name))
    refuse(
        "the .xdmf beside it names the file, and ParaView ends a name at a colon, a blank at its "
        "end or a control character; leave these out");
  return given;
}

/// The last frame for programs that read no time series, and the record of the machine, where the
/// job has them.
void fetch_companions(Connection& connection, const std::string& id, const fs::path& file) {
  const auto beside = [&](const char* ending) {
    return file.parent_path() / (file.stem().string() + ending);
  };
  try {
    download(connection, id, "results-end.xdmf", beside("-end.xdmf"), std::cerr);
    point_sidecar_at(beside("-end.xdmf"), file);
    write_file(beside("-run.json"), read_file_of_job(connection, id, "run.json"));
  } catch (const CommandFailed& failure) {
    if (failure.code() != ExitCode::not_found) throw;
  }
}

ExitCode run(const FetchOptions& options, Program& program) {
  const fs::path file = target_of(options.output);
  Connection connection = program.connect();
  const std::string id = resolve_job(connection, options.id);

  const fs::path sidecar = fs::path(file).replace_extension(".xdmf");
  for (const fs::path& written : {file, sidecar}) require_free(written, options.force);
  const Download results = download(connection, id, "results.h5", file, std::cerr);
  // A sidecar is small, and half of one may be that of another job.
  fs::remove(sidecar.string() + ".part");
  download(connection, id, "results.xdmf", sidecar, std::cerr);
  point_sidecar_at(sidecar, file);
  fetch_companions(connection, id, file);

  if (options.json)
    print_line({{"job", id},
                {"file", file.string()},
                {"bytes", results.bytes},
                {"sha256", results.sha256},
                {"resumed_at", results.resumed_at},
                {"xdmf", sidecar.string()}});
  else
    std::cout << results.sha256 << "  " << file.string() << '\n';
  std::cerr << "fetched " << file.string() << " (" << results.bytes
            << " bytes, checksum verified) and " << sidecar.string() << '\n';
  return ExitCode::done;
}

/// Temporary folder, removed with its content.
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

/// The first of these programs in PATH; empty if none exists.
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

/// Runs a program without output; kills it with its children at the time limit.
void run_silently(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  for (const int descriptor : {0, 1, 2})
    posix_spawn_file_actions_addopen(&files, descriptor, "/dev/null", O_RDWR, 0);

  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  // A process group of its own, so that its children can be killed with it.
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK);
  pid_t process = 0;
  const int error =
      ::posix_spawn(&process, arguments[0], &files, &attributes, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) return;

  constexpr std::chrono::seconds longest{60};
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

/// Prints an HTML page to a PDF file by Chromium, without a window. Throws CommandFailed if there
/// is no Chromium, or if it writes no PDF within a minute.
void print_pdf(const std::string& page, const fs::path& file) {
  const fs::path browser = program_named({"chromium", "chromium-browser", "google-chrome"});
  if (browser.empty())
    throw invalid(file.string() +
                  ": a PDF is printed by Chromium, which is not installed here; give a name that "
                  "ends with .html");

  const TemporaryFolder folder;
  const fs::path html = folder.path / "page.html", pdf = folder.path / "page.pdf";
  std::ofstream(html, std::ios::binary) << page;
  std::vector<std::string> words{browser.string(),
                                 "--headless",
                                 "--disable-gpu",
                                 "--no-pdf-header-footer",
                                 "--enable-unsafe-swiftshader",  // WebGL without a graphics card
                                 "--virtual-time-budget=60000",  // until the page has drawn
                                 "--user-data-dir=" + (folder.path / "profile").string(),
                                 "--print-to-pdf=" + pdf.string(),
                                 "file://" + html.string()};
  if (::geteuid() == 0) words.insert(words.begin() + 1, "--no-sandbox");  // it refuses root

  run_silently(std::move(words));
  if (!is_pdf(pdf))
    throw CommandFailed(ExitCode::not_found,
                        browser.string() + " printed no PDF; give a name that ends with .html");

  std::error_code error;
  fs::copy_file(pdf, file, fs::copy_options::overwrite_existing, error);
  if (error)
    throw CommandFailed(ExitCode::not_found,
                        "cannot write " + file.string() + ": " + error.message());
}

struct ReportOptions {
  std::string id;
  std::string output = "report.html";
  bool force = false;
  bool json = false;
};

ExitCode run(const ReportOptions& options, Program& program) {
  require_free(options.output, options.force);
  Connection connection = program.connect();
  const v1::Job job = connection.call(&Stub::GetJob, resolve_job(connection, options.id));
  grpc::Status frame_status;
  const std::string page = report_of(connection, job, std::cerr, frame_status);
  // The histories come from the event log and are sound. A results file that was changed or lost
  // after the run ends with the exit code of `fetch`.
  const bool results_lost = frame_status.error_code() == grpc::StatusCode::DATA_LOSS;
  const ExitCode outcome =
      results_lost ? failure_of(frame_status, connection.server()).code() : ExitCode::done;

  if (options.output == "-") {
    std::cout << page;
    return outcome;
  }
  if (fs::path(options.output).extension() == ".pdf")
    print_pdf(page, options.output);
  else
    write_file(options.output, page);
  if (options.json)
    print_line(
        {{"job", job.id()}, {"file", options.output}, {"bytes", fs::file_size(options.output)}});
  else
    std::cout << options.output << '\n';
  return outcome;
}

}  // namespace

void add_fetch(CommandLine& line, Program& program) {
  const auto [command, options] =
      declare<FetchOptions>(line, program, run, "fetch",
                            "Fetch the results of a job that has succeeded: the HDF5 file and its "
                            "XDMF sidecar for ParaView",
                            "dccast fetch JOB -o results.h5");
  command.option("JOB", options.id, job_help, required);
  command.option("-o,--output", options.output,
                 "File or folder to write to; an interrupted FILE.part is continued", shown);
  add_force_flag(command, options.force);
  command.json(options.json, "What was written, as JSON");
}

void add_report(CommandLine& line, Program& program) {
  const auto [command, options] = declare<ReportOptions>(
      line, program, run, "report",
      "Write one HTML page about a job: findings, curl, recipe, histories, the last frame, checks",
      "dccast report JOB -o report.html");
  command.option("JOB", options.id, job_help, required);
  command.option("-o,--output", options.output,
                 "File to write, HTML or with Chromium also .pdf; - for standard output", shown);
  add_force_flag(command, options.force);
  command.json(options.json, "What was written, as JSON");
}

}  // namespace dccast::client
