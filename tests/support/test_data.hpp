// Where tests find real pictures; each may be missing on a machine, and the test then says so and skips.
#pragma once

#include <filesystem>
#include <optional>

namespace ballservo::test {

/// The folder of pictures by other people beside the project (never part of it), or nothing.
std::optional<std::filesystem::path> shared_data_dir();

/// The examples of Debian's opencv-doc (chessboards left*.jpg, right*.jpg; smarties.png), installed or
/// unpacked by the set-up, or nothing.
std::optional<std::filesystem::path> opencv_doc_dir();

/// The project's own data/ folder.
std::filesystem::path project_data_dir();

/// A fresh empty folder for one test, removed with the object.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace ballservo::test
