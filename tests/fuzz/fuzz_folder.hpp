// What the fuzz targets share: a folder of their own for inputs that are read from files.
#pragma once

#include <stdlib.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

namespace ballservo::fuzz {

inline std::string text_of(const std::uint8_t* data, std::size_t size) {
  return std::string(reinterpret_cast<const char*>(data), size);
}

/// Ends the run: a property that must hold does not.
inline void require(bool holds, const char* what) {
  if (!holds) {
    fprintf(stderr, "does not hold: %s\n", what);
    abort();
  }
}

/// A folder that goes with the process, beside the project's cameras and colours as scenarios name them.
class Folder {
 public:
  explicit Folder(const std::filesystem::path& data_dir) {
    std::string pattern = (std::filesystem::temp_directory_path() / "ballservo_fuzz_XXXXXX").string();
    if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
    path_ = pattern;
    std::filesystem::create_directory(path_ / "inputs");
    for (const char* name : {"cameras", "colors"})
      std::filesystem::create_directory_symlink(data_dir / name, path_ / name);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::filesystem::path file(const std::string& name, const std::string& contents) const {
    const auto path = path_ / "inputs" / name;
    std::ofstream(path, std::ios::binary | std::ios::trunc) << contents;
    return path;
  }
  std::filesystem::path inputs() const { return path_ / "inputs"; }

 private:
  std::filesystem::path path_;
};

}  // namespace ballservo::fuzz
