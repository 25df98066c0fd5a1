// The first instructions. The program's libraries take a good part of a second to load, and Ctrl-C is heard
// in that time, too; so they are loaded from here.
#include <dlfcn.h>
#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <initializer_list>

namespace {

/// Opens what is closed of stdin, stdout and stderr, so that no file of the run gets its number: messages
/// then go nowhere, and what reads stdin or writes results to stdout fails.
void open_standard_streams() {
  // The lowest free number is the one that was closed.
  for (const int number : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(number, F_GETFD) < 0) open("/dev/null", number == STDOUT_FILENO ? O_RDONLY : O_WRONLY);
}

void set_signals() {
  std::signal(SIGPIPE, SIG_IGN);  // a write to a broken pipe fails
  std::signal(SIGXFSZ, SIG_IGN);  // and so does one beyond the user's file size limit
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    // Nothing is done yet that would have to be tidied up. An ignored SIGHUP stays so, as nohup has it.
    if (std::signal(number, [](int) { _exit(130); }) == SIG_IGN && number == SIGHUP)
      std::signal(number, SIG_IGN);
  }
}

}  // namespace

int main(int argc, char** argv) {
  open_standard_streams();
  set_signals();
  // Loaded with all the others, OpenCV's decoders would look for each of their many symbols in most of them.
  dlopen(BALLSERVO_DECODERS, RTLD_LAZY);
  void* const program = dlopen("libballservo_program.so", RTLD_LAZY);
  const auto run =
      program ? reinterpret_cast<int (*)(int, char**)>(dlsym(program, "ballservo_main")) : nullptr;
  if (run) return run(argc, argv);
  std::fprintf(stderr, "ballservo: %s\n", dlerror());
  return 3;
}
