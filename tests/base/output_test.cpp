#include "calibration/base/output.hpp"

#include <gtest/gtest.h>
#include <sys/inotify.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <fstream>
#include <functional>
#include <set>
#include <sstream>

#include "calibration/base/fault.hpp"
#include "tests/support/test_data.hpp"

namespace fs = std::filesystem;

namespace ballservo {
namespace {

std::string contents(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return (std::stringstream() << stream.rdbuf()).str();
}

void put(const fs::path& file, const std::string& text) { std::ofstream(file, std::ios::binary) << text; }

/// Every name below a folder, hidden ones too.
std::set<std::string> names(const fs::path& folder) {
  std::set<std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    found.insert(entry.path().lexically_relative(folder).string());
  }
  return found;
}

/// Runs `action` in a child process after `prepare`. True if it ended with an InputError.
bool refused_in_child(const std::function<void()>& prepare, const std::function<void()>& action) {
  const pid_t child = ::fork();
  if (child == 0) {
    prepare();
    int code = 1;
    try {
      action();
    } catch (const InputError&) {
      code = 0;
    } catch (...) {
      code = 2;
    }
    ::_exit(code);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// The same where files may not grow beyond `bytes`, as if the disk were full there.
bool refused_on_full_disk(rlim_t bytes, const std::function<void()>& action) {
  const auto limit_files = [bytes] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, bytes};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  };
  return refused_in_child(limit_files, action);
}

/// Permissions do not bind root, who becomes nobody for this.
void give_up_root() {
  if (::geteuid() == 0 && ::setuid(65534) != 0) ::_exit(3);
}

class Output : public testing::Test {
 protected:
  test::TemporaryFolder temporary;
  fs::path dir = temporary.path();
};

TEST_F(Output, FileAppearsOnlyWhenWhole) {
  {
    OutputFile file(dir / "a.csv", Overwrite::refuse);
    file.write("half");
    EXPECT_FALSE(fs::exists(dir / "a.csv"));
    EXPECT_EQ(file.staging_path().extension(), ".csv");
    EXPECT_EQ(file.staging_path().parent_path(), dir);
  }
  EXPECT_TRUE(names(dir).empty());
  write_file(dir / "a.csv", "whole", Overwrite::refuse);
  EXPECT_EQ(contents(dir / "a.csv"), "whole");
  EXPECT_EQ(names(dir), std::set<std::string>{"a.csv"});
}

TEST_F(Output, ExistingFileStaysWithoutForce) {
  put(dir / "a", "old");
  EXPECT_THROW(OutputFile(dir / "a", Overwrite::refuse), InputError);
  EXPECT_EQ(contents(dir / "a"), "old");
  write_file(dir / "a", "new", Overwrite::allow);
  EXPECT_EQ(contents(dir / "a"), "new");
  EXPECT_EQ(names(dir).size(), 1u);
}

TEST_F(Output, FileThatAppearsMeanwhileStays) {
  OutputFile file(dir / "a", Overwrite::refuse);
  file.write("mine");
  put(dir / "a", "another's");
  EXPECT_THROW(file.commit(), InputError);
  EXPECT_EQ(contents(dir / "a"), "another's");
}

TEST_F(Output, TargetsThatCannotBeWrittenAreRefusedAtOnce) {
  EXPECT_THROW(OutputFile(dir / "none" / "a", Overwrite::allow), InputError);
  EXPECT_THROW(OutputFile("", Overwrite::allow), InputError);
  EXPECT_THROW(OutputFile(dir, Overwrite::allow), InputError);
  EXPECT_THROW(OutputFile("/dev/null", Overwrite::allow), InputError);
  put(dir / "file", "");
  EXPECT_THROW(OutputFile(dir / "file" / "a", Overwrite::allow), InputError);
  EXPECT_THROW(OutputFolder(dir / "file", Overwrite::allow), InputError);
  EXPECT_THROW(OutputFolder(dir / "none" / "a", Overwrite::allow), InputError);
  EXPECT_THROW(OutputFolder("/proc/ballservo", Overwrite::allow), InputError);
  EXPECT_THROW(OutputFile("/proc/ballservo", Overwrite::allow), InputError);
  EXPECT_EQ(names(dir), std::set<std::string>{"file"});
}

TEST_F(Output, FolderWithoutWritePermissionIsRefused) {
  fs::create_directory(dir / "out");
  fs::permissions(dir / "out", static_cast<fs::perms>(0555));
  fs::permissions(dir, static_cast<fs::perms>(0555));
  EXPECT_TRUE(refused_in_child(give_up_root, [&] { OutputFile(dir / "a", Overwrite::allow); }));
  EXPECT_TRUE(refused_in_child(give_up_root, [&] { OutputFolder(dir / "a", Overwrite::allow); }));
  EXPECT_TRUE(refused_in_child(give_up_root, [&] { OutputFolder(dir / "out", Overwrite::allow); }));
}

TEST_F(Output, LinkStaysALink) {
  put(dir / "real", "old");
  fs::create_symlink("real", dir / "link");
  EXPECT_THROW(OutputFile(dir / "link", Overwrite::refuse), InputError);
  write_file(dir / "link", "new", Overwrite::allow);
  EXPECT_TRUE(fs::is_symlink(dir / "link"));
  EXPECT_EQ(contents(dir / "real"), "new");
}

TEST_F(Output, FullDiskLeavesThePreviousOutputUntouched) {
  put(dir / "a", "good");
  const std::string large(1 << 20, 'x');
  EXPECT_TRUE(refused_on_full_disk(1000, [&] { write_file(dir / "a", large, Overwrite::allow); }));
  EXPECT_TRUE(refused_on_full_disk(1000, [&] {
    OutputFolder folder(dir / "b", Overwrite::allow);
    folder.write("large", large);
    folder.commit();
  }));
  EXPECT_FALSE(refused_on_full_disk(2 << 20, [&] { write_file(dir / "c", large, Overwrite::allow); }));
  EXPECT_EQ(contents(dir / "a"), "good");
  EXPECT_EQ(names(dir), (std::set<std::string>{"a", "c"}));
}

TEST_F(Output, NewFolderAppearsWhole) {
  {
    OutputFolder abandoned(dir / "out", Overwrite::refuse);
    abandoned.write("a.csv", "1");
  }
  EXPECT_TRUE(names(dir).empty());
  OutputFolder folder(dir / "out/", Overwrite::refuse);
  folder.write("a.csv", "1");
  folder.write("frames/0.png", "2");
  EXPECT_FALSE(fs::exists(dir / "out"));
  folder.commit();
  EXPECT_EQ(names(dir), (std::set<std::string>{"out", "out/a.csv", "out/frames", "out/frames/0.png"}));
  EXPECT_EQ(contents(dir / "out/frames/0.png"), "2");
}

TEST_F(Output, ExistingFolderKeepsWhatIsTheUsers) {
  fs::create_directory(dir / "out");
  { OutputFolder empty(dir / "out", Overwrite::refuse); }
  put(dir / "out/notes.txt", "mine");
  put(dir / "out/a.csv", "old");
  EXPECT_THROW(OutputFolder(dir / "out", Overwrite::refuse), InputError);
  OutputFolder folder(dir / "out", Overwrite::allow);
  folder.write("a.csv", "new");
  folder.write("frames/0.png", "2");
  EXPECT_EQ(contents(dir / "out/a.csv"), "old");
  folder.commit();
  EXPECT_EQ(contents(dir / "out/a.csv"), "new");
  EXPECT_EQ(contents(dir / "out/notes.txt"), "mine");
  EXPECT_EQ(names(dir / "out"), (std::set<std::string>{"a.csv", "frames", "frames/0.png", "notes.txt"}));
}

TEST_F(Output, WhatAnEarlierRunLeftGoesWithTheNewOnesArrival) {
  fs::create_directories(dir / "out/old");
  for (const char* const name : {"old_0", "old_1", "mine", "old/old_2"}) put(dir / "out" / name, "1");
  fs::create_symlink("old_loop", dir / "out/old_loop");
  const auto is_earlier = [](const std::string& name) { return name.rfind("old", 0) == 0; };
  {
    OutputFolder abandoned(dir / "out", Overwrite::allow);
    abandoned.supersede(is_earlier);
  }
  EXPECT_EQ(names(dir / "out"),
            (std::set<std::string>{"mine", "old", "old/old_2", "old_0", "old_1", "old_loop"}));
  OutputFolder folder(dir / "out", Overwrite::allow);
  folder.supersede(is_earlier);
  folder.write("old_0", "2");
  folder.commit();
  EXPECT_EQ(names(dir / "out"), (std::set<std::string>{"mine", "old", "old/old_2", "old_0", "old_loop"}));
  EXPECT_EQ(contents(dir / "out/old_0"), "2");
}

TEST_F(Output, ASummaryIsGoneBeforeAndComesLast) {
  fs::create_directory(dir / "out");
  for (const char* const name : {"a.csv", "report.json", "z.csv"})
    put(dir / (std::string("out/") + name), "1");
  const int watch = ::inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  ASSERT_GE(::inotify_add_watch(watch, (dir / "out").c_str(), IN_DELETE | IN_MOVED_TO), 0);
  OutputFolder folder(dir / "out", Overwrite::allow);
  for (const char* const name : {"a.csv", "report.json", "z.csv"}) folder.write(name, "2");
  folder.commit();
  alignas(inotify_event) std::array<char, 4096> buffer{};
  const ssize_t read = ::read(watch, buffer.data(), buffer.size());
  ::close(watch);
  std::vector<std::string> events;
  for (ssize_t at = 0; at < read;) {
    const auto* const event = reinterpret_cast<const inotify_event*>(buffer.data() + at);
    if (event->name[0] != '.')
      events.push_back(std::string(event->mask & IN_DELETE ? "-" : "+") + event->name);
    at += static_cast<ssize_t>(sizeof(inotify_event)) + event->len;
  }
  ASSERT_EQ(events.size(), 4u);
  EXPECT_EQ(events.front(), "-report.json");
  EXPECT_EQ(events.back(), "+report.json");
}

TEST_F(Output, AFolderThatALinkNamesAppearsWhereItPoints) {
  fs::create_symlink("there", dir / "link");
  OutputFolder folder(dir / "link", Overwrite::refuse);
  folder.write("a.csv", "1");
  folder.commit();
  EXPECT_EQ(contents(dir / "there/a.csv"), "1");
  EXPECT_TRUE(fs::is_symlink(dir / "link"));
  fs::create_symlink("no/where", dir / "dangling");
  EXPECT_THROW(OutputFolder(dir / "dangling", Overwrite::allow), InputError);
  EXPECT_THROW(OutputFile(dir / "dangling", Overwrite::allow), InputError);
  fs::create_symlink("new.csv", dir / "link.csv");
  write_file(dir / "link.csv", "2", Overwrite::refuse);
  EXPECT_EQ(contents(dir / "new.csv"), "2");
  EXPECT_TRUE(fs::is_symlink(dir / "link.csv"));
}

TEST_F(Output, AnUnusedNameIsNobodysNotEvenALinks) {
  EXPECT_EQ(unused_path(dir / "run"), dir / "run_2");
  put(dir / "run_2", "mine");
  fs::create_symlink("nowhere", dir / "run_3");
  EXPECT_EQ(unused_path(dir / "run"), dir / "run_4");
}

TEST_F(Output, NamesTakenByAnotherKindMoveNothing) {
  fs::create_directories(dir / "out/z.csv");
  OutputFolder folder(dir / "out", Overwrite::allow);
  folder.write("a.csv", "1");
  folder.write("z.csv", "2");
  EXPECT_THROW(folder.commit(), InputError);
  EXPECT_FALSE(fs::exists(dir / "out/a.csv"));
}

TEST_F(Output, FolderRefusesNamesOutsideIt) {
  OutputFolder folder(dir / "out", Overwrite::allow);
  for (const char* name : {"../a", "/tmp/a", "x/../../a", ""}) {
    EXPECT_THROW(folder.write(name, ""), std::invalid_argument) << name;
  }
}

}  // namespace
}  // namespace ballservo
