#include "tests/support/test_data.hpp"

#include <stdlib.h>

#include <stdexcept>
#include <string>

namespace fs = std::filesystem;

namespace ballservo::test {
namespace {

const fs::path source_dir = BALLSERVO_SOURCE_DIR;

std::optional<fs::path> if_folder(const fs::path& folder) {
  std::error_code error;
  return fs::is_directory(folder, error) ? std::optional(folder) : std::nullopt;
}

}  // namespace

std::optional<fs::path> shared_data_dir() {
  if (const char* named = std::getenv("BALLSERVO_SHARED_DATA")) return if_folder(named);
  return if_folder(source_dir.parent_path() / "shared" / "data");
}

std::optional<fs::path> opencv_doc_dir() {
  const fs::path examples = "usr/share/doc/opencv-doc/examples/data";
  if (const auto installed = if_folder("/" / examples)) return installed;
  return if_folder(source_dir / "build" / "opencv-doc" / examples);
}

fs::path project_data_dir() { return source_dir / "data"; }

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "ballservo_test_XXXXXX").string();
  if (!::mkdtemp(name.data())) throw std::runtime_error("no temporary folder can be made at " + name);
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::permissions(path_, fs::perms::owner_all, fs::perm_options::add, ignored);
  fs::remove_all(path_, ignored);
}

}  // namespace ballservo::test
