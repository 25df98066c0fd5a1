#include "app/report/draw_pages.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <spdlog/spdlog.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <thread>

#include "app/io/interrupt.hpp"
#include "app/io/messages.hpp"
#include "calibration/base/system_file.hpp"

namespace ballservo {
namespace {

namespace fs = std::filesystem;

constexpr const char* python = "/usr/bin/python3";  // Debian's, which has Debian's matplotlib

/// The folder that holds the package `ballservo`: in the build tree beside the program's folder, installed
/// below the prefix. Empty where there is none.
fs::path package_folder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (const char* place : {"../python", "../lib/python3/dist-packages"}) {
    const fs::path folder = (program / place).lexically_normal();
    if (fs::exists(folder / "ballservo/report/__main__.py", error)) return folder;
  }
  return {};
}

/// Python runs in the package's folder and in a process group of its own: nothing that lies in the user's
/// folder is imported, and Ctrl-C reaches this program alone, which then ends the child. What it says goes
/// into the file `said`. The system's error, or 0.
int spawn(const fs::path& package, const std::vector<fs::path>& results, bool figures, int said,
          pid_t& child) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  for (const int stream : {STDERR_FILENO, STDOUT_FILENO})
    posix_spawn_file_actions_adddup2(&actions, said, stream);
  posix_spawn_file_actions_addchdir_np(&actions, package.c_str());
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);

  std::vector<std::string> words{python, "-E", "-s", "-m", "ballservo.report"};
  if (figures) words.emplace_back("--figures");
  for (const fs::path& file : results) words.push_back(fs::absolute(file).string());
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const int error = posix_spawn(&child, python, &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

/// Until the child ends, which it does too when the user interrupts; its status.
int wait_for(pid_t child, bool quiet) {
  using namespace std::chrono_literals;
  constexpr auto look = 20ms;
  constexpr int said_after_looks = 100;
  int status = 0;
  for (int looks = 0; waitpid(child, &status, WNOHANG) == 0; ++looks) {
    if (interrupt_requested()) kill(child, SIGKILL);
    if (looks == said_after_looks && !quiet) print_message("ballservo: drawing the page\n");
    std::this_thread::sleep_for(look);
  }
  return status;
}

std::string last_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text.substr(text.find_last_of('\n') + 1);
}

}  // namespace

std::string draw_pages(const std::vector<fs::path>& results, bool quiet, bool figures) {
  if (interrupt_requested()) return "interrupted";
  const fs::path package = package_folder();
  if (package.empty()) return "the Python package ballservo does not lie beside the program";
  const Descriptor said(memfd_create("said", MFD_CLOEXEC));
  pid_t child = 0;
  const int error = said.number() < 0 ? errno : spawn(package, results, figures, said.number(), child);
  if (error != 0) {
    return fmt::format("{}: {}; install python3-matplotlib python3-jinja2", python, std::strerror(error));
  }
  const int status = wait_for(child, quiet);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return "";
  if (interrupt_requested()) return "interrupted";
  std::string text(100000, '\0');
  text.resize(
      static_cast<std::size_t>(std::max<ssize_t>(0, pread(said.number(), text.data(), text.size(), 0))));
  return text.empty() ? "Python ended without a word" : last_line(text);
}

void draw_page_or_warn(const fs::path& folder, const std::string& name, bool quiet) {
  if (interrupt_requested()) return;
  const std::string why = draw_pages({folder}, quiet);
  if (!why.empty())
    spdlog::warn("report.html not drawn: {}; `ballservo report {}` draws it later", why, name);
}

void write_report(const OutputFolder& folder, const nlohmann::ordered_json& report, bool quiet) {
  folder.write(report_json_name, report_text(report));
  draw_page_or_warn(folder.path(), folder.target().string(), quiet);
}

std::string report_text(const nlohmann::ordered_json& report) {
  return report.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace ballservo
