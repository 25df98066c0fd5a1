// A user's own pictures, with what is known of the balls in them.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/comparison/pictures/picture_source.hpp"
#include "calibration/base/csv_table.hpp"

namespace ballservo {

/// What `compare --images` is told.
struct PictureFilesOptions {
  std::filesystem::path folder,
      truth;                    ///< truth.csv, as the interface has it; any cells but source may be empty
  std::string colors, camera;   ///< files; empty: not given
  double diameter_m = 0;        ///< 0: not known, no positions in 3-D
  bool start_at_truth = false;  ///< the fits start from the truth's circle, displaced as votes err
  std::uint64_t seed = 0;
  double max_pixels = 32e6;
};

/// One condition for each class that the truth names (all rows without one: "pictures"), one frame for each
/// row. In a picture of several balls each method's candidate nearest to the row's circle counts.
class PictureFiles : public PictureSource {
 public:
  /// Reads and checks everything but the pictures' pixels. Throws InputError with every fault: pictures that
  /// do not exist, rows that repeat, cells that are no numbers, pictures of another size than the camera's,
  /// classes that the colours do not have, a start that nothing tells.
  explicit PictureFiles(const PictureFilesOptions& options);

  const std::vector<ConditionInfo>& conditions() const override { return infos_; }
  void prepare(const std::vector<char>&) override {}
  ComparisonPicture picture(std::size_t condition, int frame) const override;
  std::string peer_words(std::size_t) const override {
    return "tuned to nothing, as tutorials have them: " + in_words(PeerSettings{});
  }

  /// Hash of every file that the results depend on.
  const std::string& sha256() const { return sha256_; }

 private:
  struct Row {
    FrameTruth truth;
    std::filesystem::path file;
    ClassIndex color_class = 1;
    std::string class_name;
  };
  std::string read_colors_and_camera(FaultList& faults);
  std::optional<Row> read_row(const CsvRow& reader) const;
  std::string checked_picture_sha256(const std::filesystem::path& file) const;
  void keep(Row row);
  std::shared_ptr<const RayTable> rays_of(const cv::Mat& bgr) const;

  PictureFilesOptions options_;
  std::shared_ptr<const ColorTable> colors_;
  std::shared_ptr<const RayTable> rays_;  // of the camera, if one is given
  std::vector<ConditionInfo> infos_;
  std::map<std::string, std::size_t> places_;  // of the conditions, by name
  std::vector<std::vector<Row>> rows_;         // by condition
  std::string sha256_;
};

}  // namespace ballservo
