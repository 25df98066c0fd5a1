// Videos whose names FFmpeg would take for an address or a pattern of other files' names.
#include <opencv2/core.hpp>

#include "app/io/video_writer.hpp"
#include "tests/hostile/commands.hpp"

namespace ballservo {
namespace {

using testing::HasSubstr;

class VideoNames : public test::Hostile {
 protected:
  void put_grey_video(const std::string& name, int pictures) const {
    VideoFile video(dir / "video.mkv", Overwrite::refuse, 30);
    for (int i = 0; i < pictures; ++i) video.write(cv::Mat(120, 160, CV_8UC3, cv::Scalar::all(128)));
    video.commit();
    std::filesystem::create_directories((dir / name).parent_path());
    std::filesystem::rename(dir / "video.mkv", dir / name);
  }
  std::string track(const std::string& name) const {
    return run("track '" + name + "' --colors '" + (test::project_data_dir() / "colors/red.colors").string() +
               "'")
        .messages;
  }
};

TEST_F(VideoNames, AreNamesOfFiles) {
  put_grey_video("long.mkv", 9);
  for (const char* name :
       {"concat:long.mkv", "http:/127.0.0.1:9/x.mkv", "http:x.mkv", "pipe:0", "picture%03d.png"}) {
    put_grey_video(name, 4);
    EXPECT_THAT(track(name), HasSubstr("no ball in 4 pictures")) << name;
  }
  EXPECT_THAT(track("http://127.0.0.1:9/x.mkv"), HasSubstr("no ball in 4 pictures"));
}

TEST_F(VideoNames, OfOutputsAreNamesOfFilesToo) {
  put_grey_video("long.mkv", 9);
  std::filesystem::create_directories(dir / "http:/127.0.0.1:9");
  track("long.mkv' --video 'http://127.0.0.1:9/y.mkv");
  EXPECT_TRUE(std::filesystem::exists(dir / "http:/127.0.0.1:9/y.mkv"));
}

}  // namespace
}  // namespace ballservo
