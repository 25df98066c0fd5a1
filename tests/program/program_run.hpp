// Runs the program from outside.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <sstream>
#include <string>

#include "tests/support/test_data.hpp"

namespace ballservo::test {

/// How a run ended.
struct Ending {
  int code = -1;
  std::string out, messages;
};

const char* program_path();

/// A folder of its own for each test, and the program run in it.
class ProgramTest : public testing::Test {
 protected:
  /// Runs the program in the temporary folder by the shell; `before` is put in front of it.
  Ending run(const std::string& arguments, const std::string& before = "") const {
    const std::string pages = pages_drawn ? "" : "export MPLBACKEND=none; ";
    const std::string command = "cd '" + dir.string() + "' && " + pages + before + " '" + program_path() +
                                "' " + arguments + " >../" + tag() + ".out 2>../" + tag() + ".err";
    const int status = std::system(command.c_str());
    Ending ending{WIFEXITED(status) ? WEXITSTATUS(status) : -1, taken(".out"), taken(".err")};
    EXPECT_THAT(ending.messages, testing::Not(testing::HasSubstr("fault of ours"))) << arguments;
    return ending;
  }
  std::set<std::string> names() const {
    std::set<std::string> found;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(dir))
      found.insert(entry.path().filename().string());
    return found;
  }
  void put(const std::string& name, const std::string& text) const { std::ofstream(dir / name) << text; }
  std::string contents(const std::string& name) const {
    std::ifstream stream(dir / name);
    return (std::stringstream() << stream.rdbuf()).str();
  }
  /// Pictures without anything in them, which no command can like.
  void put_grey_picture(const std::string& name) const {
    cv::imwrite((dir / name).string(), cv::Mat(120, 160, CV_8UC3, cv::Scalar::all(128)));
  }

  bool pages_drawn = false;  // a page takes longer than most runs
  TemporaryFolder temporary;
  std::filesystem::path dir = temporary.path();

 private:
  std::string tag() const { return dir.filename().string(); }
  std::string taken(const std::string& extension) const {
    const std::filesystem::path file = dir.parent_path() / (tag() + extension);
    std::ifstream stream(file);
    std::string text = (std::stringstream() << stream.rdbuf()).str();
    std::filesystem::remove(file);
    return text;
  }
};

}  // namespace ballservo::test
