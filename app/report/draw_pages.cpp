#include "app/report/draw_pages.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <spdlog/spdlog.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstring>

#include "app/io/interrupt.hpp"
#include "app/io/messages.hpp"

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

/// Python at work, with a pipe from its stderr.
struct Child {
  pid_t id = 0;
  int messages = -1;
};

/// Python runs in the package's folder and in a process group of its own: nothing that lies in the user's
/// folder is imported, and Ctrl-C reaches this program alone, which then ends the child.
int spawn(const fs::path& package, const std::vector<fs::path>& results, bool figures, Child& child) {
  std::array<int, 2> pipe_ends{};
  if (pipe2(pipe_ends.data(), O_CLOEXEC) != 0) return errno;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, pipe_ends[1], STDERR_FILENO);
  posix_spawn_file_actions_adddup2(&actions, pipe_ends[1], STDOUT_FILENO);
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
  const int error = posix_spawn(&child.id, python, &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  close(pipe_ends[1]);
  child.messages = pipe_ends[0];
  if (error != 0) close(child.messages);
  return error;
}

/// What the child says until it ends, or "interrupted".
std::string listen(const Child& child, bool quiet) {
  constexpr int poll_ms = 100, said_after_looks = 20;  // another thread may take the signal: poll would go on
  constexpr std::size_t most_bytes = 100000;
  std::string text;
  int looks = 0;
  while (true) {
    if (interrupt_requested()) {
      kill(child.id, SIGKILL);
      return "interrupted";
    }
    pollfd ready{child.messages, POLLIN, 0};
    if (poll(&ready, 1, poll_ms) <= 0) {
      if (++looks == said_after_looks && !quiet) print_message("ballservo: drawing the page\n");
      continue;
    }
    std::array<char, 4096> piece{};
    const ssize_t count = read(child.messages, piece.data(), piece.size());
    if (count <= 0) return text;
    if (text.size() < most_bytes) text.append(piece.data(), static_cast<std::size_t>(count));
  }
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
  Child child;
  if (const int error = spawn(package, results, figures, child); error != 0) {
    return fmt::format("{}: {}; install python3-matplotlib python3-jinja2", python, std::strerror(error));
  }
  const std::string said = listen(child, quiet);
  close(child.messages);
  int status = 0;
  while (waitpid(child.id, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return "";
  return said.empty() ? "Python ended without a word" : last_line(said);
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
